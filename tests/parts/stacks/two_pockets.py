"""A box with blind pockets in two adjacent sides."""

import cadquery as cq

result = cq.Workplane().box(20, 20, 20).faces(">Z").workplane().rect(6, 6).cutBlind(-5)
result = result.faces(">X").workplane().rect(6, 6).cutBlind(-5)

show_object(result, name="two_pockets")  # noqa: F821
