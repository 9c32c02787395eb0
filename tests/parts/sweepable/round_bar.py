"""A round bar: its side is one closed face, its caps are discs."""

import cadquery as cq

result = cq.Workplane().circle(2).extrude(10)

show_object(result, name="round_bar")  # noqa: F821
