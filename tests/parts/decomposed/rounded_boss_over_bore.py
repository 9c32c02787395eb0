"""A boss that is rounded into its plate, over a bore across the plate."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(48, 36, 24, centered=(True, True, False))
    .faces(">Z").workplane().circle(10).extrude(12)
    .edges(cq.selectors.BoxSelector((-11, -11, 23.5), (11, 11, 24.5))).fillet(4)
    .cut(cq.Workplane("XZ", origin=(0, 18, 8)).circle(5).extrude(36))
)  # fmt: skip

show_object(result, name="rounded_boss_over_bore")  # noqa: F821
