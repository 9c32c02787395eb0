"""A plate with ribs of two heights that cross."""

import cadquery as cq

result = cq.Workplane().box(50, 50, 4, centered=(True, True, False))
for x in (-15, 0, 15):
    result = result.union(cq.Workplane().box(3, 50, 12, centered=(True, True, False)).translate((x, 0, 0)))
for y in (-12, 12):
    result = result.union(cq.Workplane().box(50, 3, 8, centered=(True, True, False)).translate((0, y, 0)))

show_object(result, name="crossing_ribs")  # noqa: F821
