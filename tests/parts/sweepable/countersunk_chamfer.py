"""A plate with a chamfered hole: a station on the hole alone."""

import cadquery as cq

result = cq.Workplane().box(30, 30, 6).faces(">Z").workplane().hole(10).faces(">Z").edges("%CIRCLE").chamfer(1)

show_object(result, name="countersunk_chamfer")  # noqa: F821
