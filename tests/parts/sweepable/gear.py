"""A gear with 24 teeth and a bore: caps with hundreds of edges."""

import math

import cadquery as cq

points = []
for k in range(24):
    for turn, radius in ((0.0, 20.0), (0.3, 20.0), (0.4, 24.0), (0.6, 24.0), (0.7, 20.0)):
        angle = 2 * math.pi * (k + turn) / 24
        points.append((radius * math.cos(angle), radius * math.sin(angle)))
result = cq.Workplane().polyline(points).close().circle(6).extrude(8)

show_object(result, name="gear")  # noqa: F821
