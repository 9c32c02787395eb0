"""A plate with eight countersunk holes."""

import cadquery as cq

result = cq.Workplane().box(60, 30, 8).faces(">Z").workplane().rarray(14, 14, 4, 2).cskHole(4, 8, 90)

show_object(result, name="countersunk_plate")  # noqa: F821
