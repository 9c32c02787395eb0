"""A leaf of a hinge: a plate with three holes, and two knuckles with a bore along the edge."""

import cadquery as cq

plate = cq.Workplane().box(40, 60, 5, centered=(False, True, False))
plate = plate.cut(cq.Workplane().pushPoints([(26, -20), (26, 0), (26, 20)]).circle(3).extrude(5))
knuckles = (
    cq.Workplane("XZ", origin=(0, 30, 5)).circle(8).extrude(18)
    .union(cq.Workplane("XZ", origin=(0, -12, 5)).circle(8).extrude(18))
)  # fmt: skip
result = (
    plate.cut(cq.Workplane("XZ", origin=(0, 12, 5)).circle(9).extrude(24))
    .union(knuckles)
    .cut(cq.Workplane("XZ", origin=(0, 40, 5)).circle(4).extrude(80))
)

show_object(result, name="hinge")  # noqa: F821
