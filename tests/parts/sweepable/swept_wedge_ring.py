"""A ring segment of 120 degrees with an L-shaped section."""

import cadquery as cq

section = cq.Workplane("XZ").polyline([(10, 0), (16, 0), (16, 2), (12, 2), (12, 6), (10, 6)]).close()
result = section.revolve(120, (0, 0, 0), (0, 1, 0))

show_object(result, name="swept_wedge_ring")  # noqa: F821
