"""Trait: the upper edges of a plate and of its holes are rounded."""

import cadquery as cq

plate = cq.Workplane().rect(24, 16).extrude(4).edges("|Z").fillet(3)
show_object(plate.faces(">Z").workplane().rarray(12, 1, 2, 1).hole(5).faces(">Z").edges().fillet(0.8))  # noqa: F821
