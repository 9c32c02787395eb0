"""Half a tube: a block bent to a semicircle, swept in any of three directions."""

import cadquery as cq

result = (
    cq.Workplane()
    .moveTo(8, 0)
    .threePointArc((0, 8), (-8, 0))
    .lineTo(-6, 0)
    .threePointArc((0, 6), (6, 0))
    .close()
    .extrude(10)
)

show_object(result, name="half_tube")  # noqa: F821
