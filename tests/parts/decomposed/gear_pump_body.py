"""The body of a gear pump: two bores that overlap, blind, a hole for each shaft, and a port from the side to each."""

import cadquery as cq

body = cq.Workplane().box(100, 64, 40, centered=(True, True, False))
for x in (-16, 16):
    body = body.cut(cq.Workplane(origin=(x, 0, 12)).circle(20).extrude(40))
    body = body.cut(cq.Workplane(origin=(x, 0, 0)).circle(6).extrude(40))
body = body.cut(cq.Workplane("XZ", origin=(24, 0, 26)).circle(4).extrude(60))
body = body.cut(cq.Workplane("XZ", origin=(-24, 0, 26)).circle(4).extrude(-60))
bolts = cq.Workplane().pushPoints([(44, 26), (-44, 26), (44, -26), (-44, -26)]).circle(3).extrude(40)
result = body.cut(bolts)

show_object(result, name="gear_pump_body")  # noqa: F821
