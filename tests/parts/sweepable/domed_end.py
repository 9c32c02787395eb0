"""A round bar with a domed end: the cap is a piece of a sphere, in several faces."""

import cadquery as cq

bar = cq.Workplane().circle(6).extrude(20)
result = bar.intersect(cq.Workplane().sphere(15).translate((0, 0, 4)))

show_object(result, name="domed_end")  # noqa: F821
