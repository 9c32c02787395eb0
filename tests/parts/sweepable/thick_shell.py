"""A free-form shell thickened: both caps are curved."""

import cadquery as cq

points = [[cq.Vector(x, y, 0.03 * x * x - 0.02 * y * y) for x in range(-12, 13, 4)] for y in range(-12, 13, 4)]
result = cq.Workplane(obj=cq.Face.makeSplineApprox(points).thicken(2))

show_object(result, name="thick_shell")  # noqa: F821
