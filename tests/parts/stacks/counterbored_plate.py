"""A plate with eight counterbored holes."""

import cadquery as cq

result = cq.Workplane().box(60, 30, 8).faces(">Z").workplane().rarray(14, 14, 4, 2).cboreHole(4, 8, 3)

show_object(result, name="counterbored_plate")  # noqa: F821
