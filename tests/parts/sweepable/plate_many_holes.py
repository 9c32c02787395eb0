"""A plate with 16 holes."""

import cadquery as cq

result = cq.Workplane().box(60, 60, 4).faces(">Z").workplane().rarray(13, 13, 4, 4).hole(4)

show_object(result, name="plate_many_holes")  # noqa: F821
