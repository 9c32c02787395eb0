"""A block with pockets in its top, in its front and in a side."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(60, 50, 40)
    .faces(">Z").workplane().rect(30, 20).cutBlind(-8)
    .faces(">X").workplane(origin=(30, 4, -3)).rect(22, 14).cutBlind(-10)
    .faces("<Y").workplane(origin=(-6, -25, -6)).rect(24, 12).cutBlind(-9)
)  # fmt: skip

show_object(result, name="pockets_three_sides")  # noqa: F821
