"""A block drilled through from the top and, narrower, from the side: the holes meet."""

import cadquery as cq

result = (
    cq.Workplane().box(60, 40, 30).faces(">Z").workplane().hole(14).faces(">X").workplane(origin=(30, 0, 0)).hole(8)
)

show_object(result, name="cross_drilled_crossing")  # noqa: F821
