"""A shaft with a shoulder, a hole across it and a keyway."""

import cadquery as cq

result = (
    cq.Workplane("YZ")
    .circle(15).extrude(60)
    .faces(">X").workplane().circle(10).extrude(40)
    .cut(cq.Workplane("XY", origin=(0, 0, -20)).center(25, 0).circle(4).extrude(40))
    .cut(cq.Workplane("XY", origin=(0, 0, 6)).center(80, 0).slot2D(22, 6).extrude(10))
)  # fmt: skip

show_object(result, name="shaft_with_cross_hole")  # noqa: F821
