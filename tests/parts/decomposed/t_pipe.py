"""Two round bars that cross in a T."""

import cadquery as cq

result = cq.Workplane().circle(5).extrude(40).union(cq.Workplane("YZ").center(0, 20).circle(5).extrude(25))

show_object(result, name="t_pipe")  # noqa: F821
