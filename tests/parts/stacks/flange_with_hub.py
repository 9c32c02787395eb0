"""A flange with a hub, a bore and a bolt circle."""

import cadquery as cq

result = cq.Workplane().circle(40).extrude(8).faces(">Z").workplane().circle(18).extrude(20)
result = result.faces("<Z").workplane().circle(10).cutThruAll()
result = result.faces("<Z").workplane().polarArray(29, 0, 360, 6).circle(4).cutThruAll()

show_object(result, name="flange_with_hub")  # noqa: F821
