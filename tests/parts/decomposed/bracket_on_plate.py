"""A plate with four holes, and on it an eye with a bore across."""

import cadquery as cq

plate = cq.Workplane().box(70, 50, 10, centered=(True, True, False)).faces(">Z").workplane()
plate = plate.rect(54, 36, forConstruction=True).vertices().hole(6)
eye = (
    cq.Workplane("XZ", origin=(0, 6, 10))
    .moveTo(-14, 0).lineTo(14, 0).lineTo(14, 18).threePointArc((0, 32), (-14, 18)).close()
    .extrude(12)
    .cut(cq.Workplane("XZ", origin=(0, 6, 28)).circle(7).extrude(12))
)  # fmt: skip
result = plate.union(eye)

show_object(result, name="bracket_on_plate")  # noqa: F821
