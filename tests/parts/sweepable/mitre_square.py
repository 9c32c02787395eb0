"""A square bar with a mitre: two columns are stacked, two are one plane face."""

import cadquery as cq

path = cq.Workplane("XZ").polyline([(0, 0), (0, 20), (15, 35)])
result = cq.Workplane("XY").rect(6, 6).sweep(path, transition="right")

show_object(result, name="mitre_square")  # noqa: F821
