"""A square ring that turns by a quarter on its way around: each of its sides goes on in the next one."""

from math import cos, pi, sin

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing


def corner(j, t):
    """Corner j of the section after the share t of the way around."""
    turn = pi / 4 + j * pi / 2 + t * pi / 2
    radius = 10 + 2 * cos(turn)
    return cq.Vector(radius * cos(2 * pi * t), radius * sin(2 * pi * t), 2 * sin(turn))


sewing = BRepBuilderAPI_Sewing(1e-3)
for half in (0.0, 0.5):
    for j in range(4):
        edges = [cq.Edge.makeSpline([corner(k, half + i / 24) for i in range(13)]) for k in (j, j + 1)]
        sewing.Add(cq.Face.makeRuledSurface(*edges).wrapped)
sewing.Perform()
result = cq.Solid.makeSolid(cq.Shape.cast(sewing.SewedShape())).fix()

show_object(result, name="twisted_band")  # noqa: F821
