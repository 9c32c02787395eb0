"""A block with two crossing holes: whichever way, a hole lies in the sides."""

import cadquery as cq

result = cq.Workplane().box(20, 20, 20).faces(">Z").hole(5).faces(">X").workplane().hole(5)

show_object(result, name="crossing_holes")  # noqa: F821
