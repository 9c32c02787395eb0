"""A bar with slots that widen inwards, and a hole across it beside its middle: it runs through two slanted walls."""

import cadquery as cq

result = cq.Workplane().rect(20, 20).extrude(12)
slot = (
    cq.Workplane().polyline([(-2, 11), (-2, 8), (-5, 8), (-2, 5), (2, 5), (5, 8), (2, 8), (2, 11)]).close().extrude(12)
)
for angle in (0, 90, 180, 270):
    result = result.cut(slot.rotate((0, 0, 0), (0, 0, 1), angle))
result = result.cut(cq.Workplane("YZ").center(6.3, 6).circle(0.7).extrude(15, both=True))

show_object(result, name="drilled_profile")  # noqa: F821
