"""A lens: two spherical faces that meet at 8 degrees in a sharp rim, and no wall between them."""

from math import cos, radians, sin

import cadquery as cq

half = radians(4)
radius = 10 / sin(half)
ball = cq.Workplane().sphere(radius)
result = ball.translate((0, 0, -radius * cos(half))).intersect(ball.translate((0, 0, radius * cos(half))))

show_object(result, name="lens")  # noqa: F821
