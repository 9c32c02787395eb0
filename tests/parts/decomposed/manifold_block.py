"""A manifold: a main bore through the block, three blind ports from the top that reach it, two from the sides."""

import cadquery as cq

result = (
    cq.Workplane()
    .box(100, 40, 40)
    .faces(">X").workplane().hole(16)
    .faces(">Z").workplane(origin=(0, 0, 20)).pushPoints([(-30, 0), (0, 0), (30, 0)]).circle(5).cutBlind(-20)
    .faces(">Y").workplane(origin=(0, 20, 0)).pushPoints([(15, 0)]).circle(4).cutBlind(-20)
    .faces("<Y").workplane(origin=(0, -20, 0)).pushPoints([(15, 0)]).circle(4).cutBlind(-20)
)  # fmt: skip

show_object(result, name="manifold_block")  # noqa: F821
