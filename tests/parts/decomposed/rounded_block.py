"""A block with round corners and a rounding all around its top, a bore across and one down."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(60, 40, 30)
    .edges("|Z").fillet(8)
    .faces(">Z").edges().fillet(3)
    .cut(cq.Workplane("XZ", origin=(-12, 20, 0)).circle(5).extrude(40))
    .cut(cq.Workplane(origin=(14, 0, -15)).circle(7).extrude(30))
)  # fmt: skip

show_object(result, name="rounded_block")  # noqa: F821
