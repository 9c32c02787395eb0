"""A block with holes whose one upper edge is rounded: a tangent face at the rim of the cap."""

import cadquery as cq

block = cq.Workplane().box(30, 20, 10).edges(">Z and >Y").fillet(3)
result = block.cut(cq.Workplane().pushPoints([(-8, -2), (8, -2)]).circle(3).extrude(20, both=True))

show_object(result, name="fillet_one_edge")  # noqa: F821
