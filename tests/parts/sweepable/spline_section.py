"""A section bounded by one spline: a closed face without a corner."""

import cadquery as cq

points = [(10, 0), (6, 6), (0, 9), (-7, 5), (-9, -2), (-3, -8), (6, -6)]
result = cq.Workplane().spline(points, periodic=True).close().extrude(12)

show_object(result, name="spline_section")  # noqa: F821
