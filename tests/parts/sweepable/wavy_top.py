"""A block whose top is a free-form face."""

import math

import cadquery as cq

points = [
    [cq.Vector(x, y, 8 + 1.5 * math.sin(0.4 * x) * math.cos(0.5 * y)) for x in range(-12, 13, 3)]
    for y in range(-12, 13, 3)
]
tool = cq.Workplane(obj=cq.Solid.extrudeLinear(cq.Face.makeSplineApprox(points), cq.Vector(0, 0, 20)))
result = cq.Workplane().rect(20, 16).extrude(15).cut(tool)

show_object(result, name="wavy_top")  # noqa: F821
