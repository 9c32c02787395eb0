"""A block with two bores that cross, their axes passing each other."""

import cadquery as cq

result = cq.Workplane().box(40, 40, 40).cut(cq.Workplane(origin=(-2, -2, -20)).circle(7).extrude(40))
result = result.cut(cq.Workplane("YZ", origin=(-20, 6, 0)).circle(4).extrude(40))

show_object(result, name="crossing_off_axis")  # noqa: F821
