"""A plate with two square holes that touch along an edge: four faces meet there, and no wall is left between them."""

import cadquery as cq

result = (
    cq.Workplane().box(30, 30, 10).cut(cq.Workplane().pushPoints([(4, 4), (-4, -4)]).rect(8, 8).extrude(20, both=True))
)

show_object(result, name="touching_pockets")  # noqa: F821
