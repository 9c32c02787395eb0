"""A plate with a round boss: the boss ends on a cap of its own."""

import cadquery as cq

result = cq.Workplane().box(30, 30, 5).faces(">Z").workplane().circle(6).extrude(8)

show_object(result, name="boss_on_plate")  # noqa: F821
