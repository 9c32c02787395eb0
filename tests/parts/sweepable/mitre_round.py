"""A round pipe with a mitre: every column is stacked, the station is an ellipse."""

import cadquery as cq

path = cq.Workplane("XZ").polyline([(0, 0), (0, 20), (15, 35)])
result = cq.Workplane("XY").circle(4).sweep(path, transition="right")

show_object(result, name="mitre_round")  # noqa: F821
