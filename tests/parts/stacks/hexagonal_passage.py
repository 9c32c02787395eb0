"""A block with a hexagonal passage across it and a pocket above."""

import cadquery as cq

bar = cq.Workplane("XZ").polygon(6, 10).extrude(60, both=True)
result = cq.Workplane().box(40, 24, 20).cut(bar).faces(">Z").workplane().rect(12, 8).cutBlind(-3)

show_object(result, name="hexagonal_passage")  # noqa: F821
