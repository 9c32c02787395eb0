"""A sleeve with a collar and a hole across it: the hole leaves the round wall, and meets no edge of it."""

import cadquery as cq

result = (
    cq.Workplane("XY")
    .circle(12).extrude(30)
    .union(cq.Workplane("XY").circle(18).extrude(6))
    .cut(cq.Workplane("XY").circle(7).extrude(30))
    .cut(cq.Workplane("YZ").center(0, 18).circle(2.5).extrude(20))
)  # fmt: skip

show_object(result, name="drilled_sleeve")  # noqa: F821
