"""A cone: its sides meet in a point."""

import cadquery as cq

result = cq.Workplane(obj=cq.Solid.makeCone(6, 0, 10))

show_object(result, name="cone")  # noqa: F821
