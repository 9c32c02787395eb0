"""A hexagon bar with a rectangular imprint in the middle of a side, named: the side is no rectangle with it."""

import cadquery as cq


def imprinted(part, tool):
    """Leave the outline of a tool on the faces of a part: cut in two and fused again without cleaning up."""
    return part.cut(tool).fuse(part.intersect(tool)).Solids()[0]


bar = cq.Workplane().polygon(6, 20).extrude(25).val()
solid = imprinted(bar, cq.Workplane("XZ", origin=(0, -6, 12)).rect(4, 8).extrude(6).val())
pad = min(solid.Faces(), key=lambda face: face.Area())
result = cq.Assembly(solid, name="bar")
result.addSubshape(pad, name="pad")

show_object(result, name="imprint_on_side")  # noqa: F821
