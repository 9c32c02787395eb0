"""A block with blind round holes from the top and from a side."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(60, 40, 30)
    .faces(">Z").workplane().pushPoints([(-10, 0)]).circle(8).cutBlind(-12)
    .faces(">X").workplane(origin=(30, 0, 0)).circle(6).cutBlind(-15)
)  # fmt: skip

show_object(result, name="round_pockets")  # noqa: F821
