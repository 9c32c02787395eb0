"""A round bar whose two ends have a ridge each, square to one another: both caps are divided, and not alike."""

import cadquery as cq

bar = cq.Workplane().circle(5).extrude(30)
top = cq.Workplane("XZ").polyline([(-6, 28), (0, 30), (6, 28), (6, 40), (-6, 40)]).close().extrude(20, both=True)
bottom = cq.Workplane("YZ").polyline([(-6, 2), (0, 0), (6, 2), (6, -9), (-6, -9)]).close().extrude(20, both=True)
result = bar.cut(top).cut(bottom)

show_object(result, name="caps_folded_unalike")  # noqa: F821
