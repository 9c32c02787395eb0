"""A plate with 36 holes."""

import cadquery as cq

result = cq.Workplane().box(60, 60, 4).faces(">Z").workplane().rarray(9, 9, 6, 6).hole(4)

show_object(result, name="plate_many_holes")  # noqa: F821
