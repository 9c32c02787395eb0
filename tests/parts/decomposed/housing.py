"""A housing: open on top, with a bore through one wall and a flange with holes around its rim."""

import cadquery as cq

box = cq.Workplane().box(60, 44, 40, centered=(True, True, False))
flange = cq.Workplane(origin=(0, 0, 34)).box(80, 64, 6, centered=(True, True, False))
result = (
    box.union(flange)
    .cut(cq.Workplane(origin=(0, 0, 5)).box(50, 34, 40, centered=(True, True, False)))
    .faces(">Z").workplane(origin=(0, 0, 40)).rect(68, 52, forConstruction=True).vertices().hole(6)
    .cut(cq.Workplane("YZ", origin=(20, 0, 20)).circle(7).extrude(20))
)  # fmt: skip

show_object(result, name="housing")  # noqa: F821
