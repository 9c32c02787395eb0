"""A block with a square hole turned by 45 degrees: thin necks at its corners."""

import cadquery as cq

hole = cq.Workplane().transformed(rotate=(0, 0, 45)).rect(12, 12).extrude(10)
result = cq.Workplane().rect(20, 20).extrude(10).cut(hole)

show_object(result, name="square_hole_turned")  # noqa: F821
