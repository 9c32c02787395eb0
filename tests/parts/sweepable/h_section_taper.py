"""An H section that tapers along its length."""

import cadquery as cq

half = [
    (-10, -10),
    (10, -10),
    (10, -6),
    (3, -6),
    (3, 6),
    (10, 6),
    (10, 10),
    (-10, 10),
    (-10, 6),
    (-3, 6),
    (-3, -6),
    (-10, -6),
]
small = [(0.6 * x, 0.6 * y) for x, y in half]
result = cq.Workplane().polyline(half).close().workplane(offset=40).polyline(small).close().loft(ruled=True)

show_object(result, name="h_section_taper")  # noqa: F821
