"""A block with a pocket in its top and one in a side."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(60, 40, 30)
    .faces(">Z").workplane().rect(30, 20).cutBlind(-8)
    .faces(">X").workplane(origin=(30, 0, -4)).rect(20, 10).cutBlind(-10)
)  # fmt: skip

show_object(result, name="pockets_two_sides")  # noqa: F821
