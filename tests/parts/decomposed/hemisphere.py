"""Half a ball: the flat face meets the round one without a side between them."""

import cadquery as cq

result = cq.Workplane().sphere(8).intersect(cq.Workplane().box(20, 20, 20).translate((0, 0, 10)))

show_object(result, name="hemisphere")  # noqa: F821
