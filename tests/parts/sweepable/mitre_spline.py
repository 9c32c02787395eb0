"""A mitred bar with a closed spline for its section: the intersection curve of the mitre ends in tiny hooks."""

import cadquery as cq

section = cq.Workplane().spline([(6, 0), (2, 4.7), (-4, 3), (-4.5, -3), (1.5, -5.5)], periodic=True).close()
result = section.sweep(cq.Workplane("XZ").polyline([(0, 0), (0, 15), (10, 27)]), transition="right")

show_object(result, name="mitre_spline")  # noqa: F821
