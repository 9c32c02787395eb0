"""A pulley with a groove and no bore: a solid of revolution whose side is stacked from five bands."""

import cadquery as cq

section = [(0, 0), (20, 0), (20, 4), (14, 6), (14, 10), (20, 12), (20, 16), (0, 16)]
result = cq.Workplane("XZ").polyline(section).close().revolve(360, (0, 0, 0), (0, 1, 0))

show_object(result, name="grooved_pulley")  # noqa: F821
