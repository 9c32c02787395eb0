"""A shaft of two diameters with a keyway in one of them."""

import cadquery as cq

result = cq.Workplane().circle(8).extrude(20).faces(">Z").circle(5).extrude(20)
result = result.cut(cq.Workplane().box(2, 10, 8).translate((0, 8, 30)))

show_object(result, name="stepped_shaft")  # noqa: F821
