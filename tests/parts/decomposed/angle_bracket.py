"""An angle bracket with holes in both legs and a gusset between them."""

import cadquery as cq

legs = cq.Workplane("XZ").polyline([(0, 0), (50, 0), (50, 8), (8, 8), (8, 50), (0, 50)]).close().extrude(-40)
gusset = cq.Workplane("XZ", origin=(0, 17, 0)).polyline([(8, 8), (32, 8), (8, 32)]).close().extrude(-6)
holes = cq.Workplane("XY").pushPoints([(38, 10), (38, 30)]).circle(4).extrude(20)
more = cq.Workplane("YZ").pushPoints([(10, 38), (30, 38)]).circle(4).extrude(20)
result = legs.union(gusset).cut(holes).cut(more)

show_object(result, name="angle_bracket")  # noqa: F821
