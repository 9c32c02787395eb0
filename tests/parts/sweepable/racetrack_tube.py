"""A closed tube around a racetrack: no caps, no axis, two shells."""

import cadquery as cq

path = (
    cq.Workplane()
    .moveTo(0, -6)
    .lineTo(4, -6)
    .threePointArc((10, 0), (4, 6))
    .lineTo(-4, 6)
    .threePointArc((-10, 0), (-4, -6))
    .close()
)
result = cq.Workplane("YZ", origin=(0, -6, 0)).circle(2).circle(1.2).sweep(path)

show_object(result, name="racetrack_tube")  # noqa: F821
