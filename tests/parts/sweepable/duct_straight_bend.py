"""A square duct of straight, bend and straight."""

import cadquery as cq

path = cq.Workplane("XZ").lineTo(0, 20).radiusArc((15, 35), 15).lineTo(30, 35)
result = cq.Workplane("XY").rect(8, 8).sweep(path)

show_object(result, name="duct_straight_bend")  # noqa: F821
