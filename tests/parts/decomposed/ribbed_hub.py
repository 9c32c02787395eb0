"""A bearing housing: a flange with bolt holes, a hub with a stepped bore, four ribs, and a grease hole between two."""

import cadquery as cq

body = cq.Workplane().circle(50).extrude(12).faces(">Z").workplane().circle(28).extrude(38)
body = body.faces(">Z").workplane().hole(30, 40).cut(cq.Workplane().circle(10).extrude(60))
body = body.cut(cq.Workplane().polarArray(40, 45, 360, 4).circle(4).extrude(20))
rib = cq.Workplane("XZ").polyline([(27, 12), (46, 12), (27, 40)]).close().extrude(3, both=True)
for k in range(4):
    body = body.union(rib.rotate((0, 0, 0), (0, 0, 1), 90 * k))
grease = cq.Workplane("YZ", origin=(0, 0, 30)).circle(2.5).extrude(30).rotate((0, 0, 0), (0, 0, 1), 45)

show_object(body.cut(grease), name="ribbed_hub")  # noqa: F821
