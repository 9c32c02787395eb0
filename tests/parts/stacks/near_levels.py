"""A plate with bosses 10.00 and 10.05 high: their tops share a level."""

import cadquery as cq

result = cq.Workplane().box(40, 20, 4, centered=(True, True, False))
result = result.union(cq.Workplane().rect(8, 8).extrude(10.0).translate((-10, 0, 0)))
result = result.union(cq.Workplane().rect(8, 8).extrude(10.05).translate((10, 0, 0)))

show_object(result, name="near_levels")  # noqa: F821
