"""A bar with slots that widen inwards, a bore, and a hole across it that runs through two slanted walls."""

import cadquery as cq

result = cq.Workplane().rect(40, 40).extrude(60)
slot = cq.Workplane().rect(8, 10).extrude(60).translate((0, 17, 0))
slot = slot.union(cq.Workplane().polyline([(-10, 15.5), (10, 15.5), (4, 9.5), (-4, 9.5)]).close().extrude(60))
for angle in (0, 90, 180, 270):
    result = result.cut(slot.rotate((0, 0, 0), (0, 0, 1), angle))
result = result.cut(cq.Workplane().circle(3.4).extrude(60))
result = result.cut(cq.Workplane("YZ").center(12.4, 30).circle(1.5).extrude(60, both=True))

show_object(result, name="drilled_profile")  # noqa: F821
