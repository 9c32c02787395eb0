"""A valve body: a blind bore, bolt holes along it, a port from the side and one in a boss on the other."""

import cadquery as cq

block = cq.Workplane().box(60, 60, 30, centered=(True, True, False))
boss = cq.Workplane("YZ").workplane(offset=30).center(0, 19).circle(8).extrude(10)
result = (
    block.union(boss)
    .cut(cq.Workplane().workplane(offset=8).circle(16).extrude(22))
    .cut(cq.Workplane().rect(46, 46, forConstruction=True).vertices().circle(3).extrude(30))
    .cut(cq.Workplane("YZ").workplane(offset=10).center(0, 19).circle(4).extrude(30))
    .cut(cq.Workplane("YZ").workplane(offset=-30).center(0, 19).circle(5).extrude(20))
)  # fmt: skip

show_object(result, name="ported_valve")  # noqa: F821
