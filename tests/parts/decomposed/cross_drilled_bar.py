"""A round bar with a hole across it and a pocket in its end."""

import cadquery as cq

result = cq.Workplane().circle(8).extrude(30).cut(cq.Workplane("YZ").center(0, 10).circle(2).extrude(20, both=True))
result = result.faces(">Z").workplane().hole(4, 6)

show_object(result, name="cross_drilled_bar")  # noqa: F821
