"""A wide blind bore that ends inside of a narrower one beside its axis."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(60, 60, 25)
    .cut(cq.Workplane("XZ", origin=(2, 30, 1)).circle(6).extrude(60))
    .cut(cq.Workplane("XY", origin=(4, 3, 1.5)).circle(11).extrude(30))
)

show_object(result, name="bore_into_bore")  # noqa: F821
