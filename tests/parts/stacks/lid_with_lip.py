"""A round lid with a lip below and a knob above."""

import cadquery as cq

result = cq.Workplane().circle(30).extrude(4)
result = result.union(cq.Workplane(origin=(0, 0, -6)).circle(26).circle(23).extrude(6))
result = result.union(cq.Workplane(origin=(0, 0, 4)).circle(7).extrude(9))

show_object(result, name="lid_with_lip")  # noqa: F821
