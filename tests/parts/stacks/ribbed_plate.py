"""A plate with a rib across it that ends inside."""

import cadquery as cq

result = cq.Workplane().box(30, 20, 4).union(cq.Workplane().box(18, 3, 8).translate((0, 0, 6)))

show_object(result, name="ribbed_plate")  # noqa: F821
