"""Three blocks through each other, along x, y and z."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(80, 16, 20)
    .union(cq.Workplane().box(20, 70, 12))
    .union(cq.Workplane().box(14, 24, 60))
)  # fmt: skip

show_object(result, name="crossing_blocks")  # noqa: F821
