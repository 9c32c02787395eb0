"""A pan drawn from sheet of 1.5, with a flange and a hole in each of floor, wall and flange."""

import cadquery as cq


def rounded(length, width, height, corner, floor):
    """A box on its floor with rounded edges."""
    box = cq.Workplane().box(length, width, height, centered=(True, True, False))
    return box.edges("|Z").fillet(corner).edges("<Z").fillet(floor)


flange = cq.Workplane().workplane(offset=18.5).box(76, 56, 1.5, centered=(True, True, False)).edges("|Z").fillet(10)
cavity = rounded(57, 37, 30, 6.5, 3.5).translate((0, 0, 1.5))
holes = [
    cq.Workplane().center(5, 5).circle(5).extrude(5),
    cq.Workplane().workplane(offset=15).center(33, 23).circle(2).extrude(10),
    cq.Workplane("YZ").workplane(offset=20).center(0, 10).circle(3).extrude(20),
]
result = rounded(60, 40, 20, 8, 5).union(flange).cut(cavity).clean()
for hole in holes:
    result = result.cut(hole)

show_object(result, name="drawn_pan")  # noqa: F821
