"""A lens-shaped bar: two faces, two sharp edges of 50 degrees."""

import cadquery as cq

result = (
    cq.Workplane()
    .moveTo(-10, 0)
    .threePointArc((0, 4.5), (10, 0))
    .threePointArc((0, -4.5), (-10, 0))
    .close()
    .extrude(15)
)

show_object(result, name="knife_edges")  # noqa: F821
