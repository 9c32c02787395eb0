"""A plate with a hole, whose wall, sides and top are divided by a step and a box at places of their own."""

import cadquery as cq

body = cq.Workplane().rect(14, 12).extrude(9).faces(">Z").workplane(origin=(1, 0.5)).hole(5).val()
for tool in (
    cq.Solid.makeBox(20, 40, 20, pnt=cq.Vector(2, -20, 3)),
    cq.Solid.makeBox(3, 4, 4, pnt=cq.Vector(-3, 1, 6)),
    cq.Workplane("XZ", origin=(-4, -6, 5)).circle(1.5).extrude(1, both=True).val(),
):
    body = body.cut(tool).fuse(body.intersect(tool)).Solids()[0]
result = body

show_object(result, name="hole_across_imprints")  # noqa: F821
