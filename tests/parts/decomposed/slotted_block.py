"""A block with a round ended slot from the top, a slot across the bottom and a hole along it."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(70, 40, 30)
    .faces(">Z").workplane().slot2D(40, 12).cutBlind(-8)
    .cut(cq.Workplane(origin=(18, 0, -12)).box(10, 40, 6))
    .cut(cq.Workplane("YZ", origin=(-35, 10, -6)).circle(4).extrude(70))
)  # fmt: skip

show_object(result, name="slotted_block")  # noqa: F821
