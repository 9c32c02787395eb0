"""Half a hollow ball on a flange: skins that leave the plane of their loops, each with a pole."""

import cadquery as cq

below = cq.Workplane().box(100, 100, 50, centered=(True, True, False)).translate((0, 0, -50))
dome = cq.Workplane().sphere(25).cut(cq.Workplane().sphere(23)).cut(below)
result = dome.union(cq.Workplane().circle(35).circle(23.5).extrude(2)).clean()

show_object(result, name="dome_on_flange")  # noqa: F821
