"""A block with a round boss on top and one on a side."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(50, 40, 30)
    .faces(">Z").workplane().circle(10).extrude(10)
    .faces(">X").workplane(origin=(25, 0, 0)).circle(8).extrude(12)
)  # fmt: skip

show_object(result, name="boss_on_two_sides")  # noqa: F821
