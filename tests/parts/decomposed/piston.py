"""A piston: a ring groove, a hole for the pin across it, hollow from below."""

import cadquery as cq

result = (
    cq.Workplane("XY")
    .circle(35).extrude(60)
    .cut(cq.Workplane("XY").circle(26).extrude(46))
    .cut(cq.Workplane("XY", origin=(0, 0, 50)).circle(40).circle(31).extrude(4))
    .cut(cq.Workplane("YZ", origin=(-40, 0, 0)).center(0, 24).circle(9).extrude(80))
)  # fmt: skip

show_object(result, name="piston")  # noqa: F821
