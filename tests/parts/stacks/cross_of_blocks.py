"""A cross of three bars in space."""

import cadquery as cq

result = cq.Workplane().box(30, 8, 8).union(cq.Workplane().box(8, 30, 8)).union(cq.Workplane().box(8, 8, 30))

show_object(result, name="cross_of_blocks")  # noqa: F821
