"""A plate with an oblique hole that is stacked from two cylinders."""

import cadquery as cq

hole = cq.Workplane().circle(4).extrude(40, both=True).rotate((0, 0, 0), (0, 1, 0), 25)
result = cq.Workplane().box(40, 30, 8).cut(hole)

show_object(result, name="skew_hole")  # noqa: F821
