"""A plate with a pocket of each side, whose floors are rounded into their walls, one under the other."""

import cadquery as cq


def pocket(x, y, z, length, width, depth):
    """A rounded pocket that reaches `depth` up from its floor, or down where that is negative."""
    solid = cq.Workplane("XY", (x, y, z)).rect(length, width).extrude(depth).edges("|Z").fillet(6)
    return solid.faces("<Z" if depth > 0 else ">Z").edges().fillet(2)


result = cq.Workplane().box(80, 50, 20)
result = result.cut(pocket(-15, 0, 4, 25, 30, 20)).cut(pocket(12, 3, -4, 30, 25, -20))

show_object(result, name="pockets_filleted")  # noqa: F821
