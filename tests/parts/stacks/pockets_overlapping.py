"""Pockets from above and from below that overlap in plan; a web is left between them."""

import cadquery as cq

result = cq.Workplane().box(30, 16, 10, centered=(True, True, False))
result = result.cut(cq.Workplane().box(14, 9, 4, centered=(True, True, False)).translate((-3, 1, 6)))
result = result.cut(cq.Workplane().circle(5.5).extrude(4).translate((4, -1, 0)))

show_object(result, name="pockets_overlapping")  # noqa: F821
