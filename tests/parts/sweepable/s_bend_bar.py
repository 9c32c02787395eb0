"""A bar swept along an S-shaped spline."""

import cadquery as cq

path = cq.Workplane("XZ").spline([(0, 0), (2, 15), (18, 30), (20, 45)], tangents=[(0, 1), (0, 1)])
result = cq.Workplane("XY").rect(6, 4).sweep(path)

show_object(result, name="s_bend_bar")  # noqa: F821
