"""A tube whose bore is far off its centre: a wall thin on one side."""

import cadquery as cq

result = cq.Workplane().circle(10).extrude(20).cut(cq.Workplane().center(3.5, 0).circle(5).extrude(20))

show_object(result, name="eccentric_tube")  # noqa: F821
