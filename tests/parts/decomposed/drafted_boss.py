"""A plate with a cast boss: its flank leans 3 degrees, so it is no wall along the boss, and too steep for a cap."""

import cadquery as cq

result = cq.Workplane().box(30, 24, 5).faces(">Z").workplane().circle(6).extrude(9, taper=3)

show_object(result, name="drafted_boss")  # noqa: F821
