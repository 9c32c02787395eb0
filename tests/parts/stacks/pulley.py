"""A pulley with a straight groove, a bore and a hub."""

import cadquery as cq

profile = [(6, 0), (30, 0), (30, 4), (22, 4), (22, 12), (30, 12), (30, 16), (12, 16), (12, 24), (6, 24)]
result = cq.Workplane("XZ").polyline(profile).close().revolve(360, (0, 0, 0), (0, 1, 0))

show_object(result, name="pulley")  # noqa: F821
