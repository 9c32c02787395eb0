"""A box drawn from sheet of 1.5: all its edges are round, and its rim is a plane ring."""

import cadquery as cq

box = cq.Workplane().box(60, 40, 20).edges("|Z").fillet(8).edges("<Z").fillet(5)
result = box.faces(">Z").shell(-1.5)

show_object(result, name="drawn_box")  # noqa: F821
