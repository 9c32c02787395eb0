"""Five steps with a hole down through each."""

import cadquery as cq

result = cq.Workplane().box(8, 20, 3, centered=(True, True, False))
for k in range(1, 5):
    result = result.union(cq.Workplane().box(8, 20, 3 * (k + 1), centered=(True, True, False)).translate((8 * k, 0, 0)))
for k in range(5):
    result = result.cut(cq.Workplane().circle(2).extrude(20).translate((8 * k, 0, 0)))

show_object(result, name="stairs")  # noqa: F821
