"""A plate with a pocket of each side, whose floors are rounded into their walls."""

import cadquery as cq


def pocket(x, z, length, depth):
    """A rounded pocket that reaches `depth` up from its floor, or down where that is negative."""
    solid = cq.Workplane("XY", (x, 0, z)).rect(length, 36).extrude(depth).edges("|Z").fillet(6)
    return solid.faces("<Z" if depth > 0 else ">Z").edges().fillet(2)


result = cq.Workplane().box(90, 50, 20).cut(pocket(-21, 4, 34, 20)).cut(pocket(21, -4, 34, -20))

show_object(result, name="pockets_filleted")  # noqa: F821
