"""A sheet bent twice, up and down, with a hole in each end."""

import cadquery as cq

sheet = (
    cq.Workplane("XZ")
    .moveTo(0, 0)
    .lineTo(20, 0)
    .radiusArc((25, 5), -5)
    .lineTo(25, 20)
    .radiusArc((30, 25), 5)
    .lineTo(45, 25)
    .lineTo(45, 27)
    .lineTo(30, 27)
    .radiusArc((23, 20), -7)
    .lineTo(23, 5)
    .radiusArc((20, 2), 3)
    .lineTo(0, 2)
    .close()
    .extrude(-30)
)
round_hole = cq.Workplane().center(10, 15).circle(3).extrude(10)
slot = cq.Workplane("XY").workplane(offset=20).center(37, 15).rect(6, 8).extrude(20)
result = sheet.cut(round_hole).cut(slot)

show_object(result, name="z_sheet")  # noqa: F821
