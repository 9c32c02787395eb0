"""A plate with slots: loops of lines and arcs that are tangent."""

import cadquery as cq

result = cq.Workplane().box(60, 40, 5).faces(">Z").workplane().rarray(25, 15, 2, 2).slot2D(15, 5).cutThruAll()

show_object(result, name="slotted_plate")  # noqa: F821
