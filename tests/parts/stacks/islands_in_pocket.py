"""A pocket with three islands of different heights, one of them round."""

import cadquery as cq

result = cq.Workplane().box(40, 30, 10, centered=(True, True, False))
pocket = cq.Workplane().rect(32, 22).extrude(7).edges("|Z").fillet(4)
result = result.cut(pocket.translate((0, 0, 3)))
result = result.union(cq.Workplane().rect(6, 5).extrude(8).translate((-8, 3, 2)))
result = result.union(cq.Workplane().circle(3).extrude(5).translate((6, -4, 2)))
result = result.union(cq.Workplane().rect(4, 4).extrude(3).translate((7, 6, 2)))

show_object(result, name="islands_in_pocket")  # noqa: F821
