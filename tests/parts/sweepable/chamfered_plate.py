"""A plate with its upper edges chamfered: a station below the cap."""

import cadquery as cq

result = cq.Workplane().box(30, 20, 6).edges(">Z").chamfer(1)

show_object(result, name="chamfered_plate")  # noqa: F821
