"""A hexagonal bar: every corner of the cap has 120 degrees."""

import cadquery as cq

result = cq.Workplane().polygon(6, 4).extrude(9)

show_object(result, name="hexagon_bar")  # noqa: F821
