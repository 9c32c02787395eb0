"""A gear wheel of 16 straight-flanked teeth with a hub on one side and a bore."""

from math import cos, pi, sin

import cadquery as cq

points = []
for k in range(16):
    for radius, share in ((20, -0.36), (25, -0.18), (25, 0.18), (20, 0.36)):
        angle = 2 * pi * (k + share) / 16
        points.append((radius * cos(angle), radius * sin(angle)))
result = cq.Workplane().polyline(points).close().extrude(8)
result = result.union(cq.Workplane().circle(10).extrude(18)).cut(cq.Workplane().circle(5).extrude(18))

show_object(result, name="gear_with_hub")  # noqa: F821
