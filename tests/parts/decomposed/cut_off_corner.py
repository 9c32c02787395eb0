"""A cube with a corner cut off: a triangle, three squares and three pentagons."""

import cadquery as cq

beyond = cq.Workplane(cq.Plane(origin=(6, 6, 6), normal=(1, 1, 1))).rect(60, 60).extrude(40)
result = cq.Workplane().box(20, 20, 20).cut(beyond)

show_object(result, name="cut_off_corner")  # noqa: F821
