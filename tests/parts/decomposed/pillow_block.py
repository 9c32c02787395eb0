"""A pillow block: a foot with two holes, and a bore across above it."""

import cadquery as cq

foot = cq.Workplane().box(100, 30, 12, centered=(True, True, False))
housing = (
    cq.Workplane("XZ", origin=(0, 15, 0))
    .moveTo(-22, 12).lineTo(22, 12).lineTo(22, 36).threePointArc((0, 58), (-22, 36)).close()
    .extrude(30)
)  # fmt: skip
result = (
    foot.union(housing)
    .cut(cq.Workplane("XZ", origin=(0, 15, 36)).circle(12).extrude(30))
    .cut(cq.Workplane().pushPoints([(-38, 0), (38, 0)]).circle(5).extrude(12))
)

show_object(result, name="pillow_block")  # noqa: F821
