"""A block drilled from the top and from two sides: the holes pass each other."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(60, 40, 30)
    .faces(">Z").workplane().pushPoints([(-20, 8)]).hole(10)
    .faces(">X").workplane(origin=(30, 0, 0)).pushPoints([(-10, -5)]).hole(6)
    .faces(">Y").workplane(origin=(0, 20, 0)).pushPoints([(-18, 5)]).hole(8)
)  # fmt: skip

show_object(result, name="cross_drilled_passing")  # noqa: F821
