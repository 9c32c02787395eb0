"""A wide ring of constant section with a stepped, full outline turned by 300 degrees."""

import cadquery as cq

section = [(10, 0), (20, 0), (20, 3), (14, 3), (14, 8), (10, 8)]
result = cq.Workplane("XZ").polyline(section).close().revolve(300, (0, 0, 0), (0, 1, 0))

show_object(result, name="stepped_flange_ring")  # noqa: F821
