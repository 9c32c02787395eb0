"""A quarter of a round bar, turned about its own axis: the sides meet on the axis, at a sphere."""

import cadquery as cq

result = cq.Workplane("XZ").moveTo(0, 0).lineTo(6, 0).threePointArc((4.243, 4.243), (0, 6)).close()
result = result.revolve(90, (0, 0, 0), (0, 1, 0))

show_object(result, name="axis_wedge")  # noqa: F821
