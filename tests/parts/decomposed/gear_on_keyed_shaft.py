"""A gear that is one piece with its shaft, which has a keyway."""

from math import cos, pi, sin

import cadquery as cq

N = 14
points = []
for tooth in range(N):
    for turn, radius in ((-0.3, 20), (-0.17, 25), (0.17, 25), (0.3, 20)):
        a = 2 * pi * (tooth + turn) / N
        points.append((radius * cos(a), radius * sin(a)))
gear = cq.Workplane("XY").polyline(points).close().extrude(14)
shaft = cq.Workplane("XY", origin=(0, 0, -25)).circle(9).extrude(80)
keyway = cq.Workplane("XZ", origin=(0, -5, 0)).center(0, 36).slot2D(20, 5, 90).extrude(10)
result = gear.union(shaft).cut(keyway)

show_object(result, name="gear_on_keyed_shaft")  # noqa: F821
