"""A triangular bar: its caps have three corners."""

import cadquery as cq

result = cq.Workplane().polygon(3, 6).extrude(8)

show_object(result, name="triangle_bar")  # noqa: F821
