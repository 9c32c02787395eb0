"""A round bar with one end cut obliquely."""

import cadquery as cq

bar = cq.Workplane().circle(5).extrude(30)
result = bar.cut(cq.Workplane("XY").box(40, 40, 20).rotate((0, 0, 0), (0, 1, 0), 35).translate((0, 0, 32)))

show_object(result, name="oblique_cylinder")  # noqa: F821
