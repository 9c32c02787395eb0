"""A block with one blind hole: its floor is a third cap."""

import cadquery as cq

result = cq.Workplane().box(20, 20, 20).faces(">Z").workplane().hole(6, 8)

show_object(result, name="blind_hole")  # noqa: F821
