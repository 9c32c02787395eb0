"""A block with a chamfer, a V-groove and a pocket: caps that are not flat."""

import cadquery as cq

result = cq.Workplane().box(40, 24, 12, centered=(True, True, False)).faces(">Z").edges(">X").chamfer(3, 5)
groove = cq.Workplane("XZ").polyline([(-4, 12), (0, 8), (4, 12), (4, 20), (-4, 20)]).close().extrude(40, both=True)
result = result.cut(groove.translate((-8, 0, 0))).faces("<Z").workplane(invert=True).center(5, 0).rect(8, 8).cutBlind(4)

show_object(result, name="v_groove")  # noqa: F821
