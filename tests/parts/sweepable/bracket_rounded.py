"""A bracket bent from sheet, with holes in both flanges: it can only be swept through its thickness."""

import cadquery as cq

profile = (
    cq.Workplane("XZ")
    .moveTo(0, 30)
    .lineTo(0, 5)
    .radiusArc((5, 0), -5)
    .lineTo(40, 0)
    .lineTo(40, 3)
    .lineTo(5, 3)
    .radiusArc((3, 5), 2)
    .lineTo(3, 30)
    .close()
    .extrude(-20)
)
holes = cq.Workplane("XY").pushPoints([(15, 10), (30, 10)]).circle(4).extrude(10)
hole = cq.Workplane("YZ").center(10, 18).circle(5).extrude(10)
result = profile.cut(holes).cut(hole)

show_object(result, name="bracket_rounded")  # noqa: F821
