"""A bore that crosses a counterbored one, the counterbore's floor above, and a blind hole beside them."""

import cadquery as cq

block = cq.Workplane().box(50, 46, 40)
block = block.cut(cq.Workplane("XZ").center(-12, 5).circle(8).extrude(23, both=True))
block = block.cut(cq.Workplane("XY", origin=(-12, 6, 0)).circle(4).extrude(20, both=True))
block = block.cut(cq.Workplane("XY", origin=(-12, 6, -20)).circle(7).extrude(11))
result = block.cut(cq.Workplane("XZ", origin=(12, -23, -6)).circle(5).extrude(-17))
