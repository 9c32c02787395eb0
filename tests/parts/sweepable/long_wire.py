"""A long thin wire of square section."""

import cadquery as cq

result = cq.Workplane().rect(0.5, 0.5).extrude(60)

show_object(result, name="long_wire")  # noqa: F821
