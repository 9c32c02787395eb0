"""A hollow shaft of five steps outside and two inside."""

import cadquery as cq

result = cq.Workplane().circle(9).extrude(10)
for radius, start, height in ((12, 10, 14), (17, 24, 8), (13, 32, 16), (10, 48, 10)):
    result = result.union(cq.Workplane(origin=(0, 0, start)).circle(radius).extrude(height))
result = result.cut(cq.Workplane().circle(5).extrude(60)).cut(cq.Workplane().circle(7).extrude(30))

show_object(result, name="hollow_shaft")  # noqa: F821
