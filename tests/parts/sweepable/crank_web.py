"""Two round ends joined by tangents, with two bores."""

import cadquery as cq

result = (
    cq.Workplane()
    .moveTo(0, 8)
    .threePointArc((-8, 0), (0, -8))
    .lineTo(30, -5)
    .threePointArc((35, 0), (30, 5))
    .close()
    .pushPoints([(0, 0)])
    .circle(4)
    .pushPoints([(30, 0)])
    .circle(2.5)
    .extrude(7)
)

show_object(result, name="crank_web")  # noqa: F821
