"""A dovetail: acute corners in the caps."""

import cadquery as cq

result = (
    cq.Workplane()
    .polyline([(-10, 0), (10, 0), (10, 6), (4, 6), (7, 12), (-7, 12), (-4, 6), (-10, 6)])
    .close()
    .extrude(30)
)

show_object(result, name="dovetail")  # noqa: F821
