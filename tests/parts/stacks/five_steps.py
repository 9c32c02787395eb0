"""A shaft of five diameters."""

import cadquery as cq

result = cq.Workplane().circle(6).extrude(10)
for radius, start, height in ((9, 10, 14), (14, 24, 8), (10, 32, 16), (7, 48, 10)):
    result = result.union(cq.Workplane(origin=(0, 0, start)).circle(radius).extrude(height))

show_object(result, name="five_steps")  # noqa: F821
