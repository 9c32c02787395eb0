"""A free-form lump, closed over two points: one smooth face all around, no caps and no edge to begin from."""

from math import cos, pi, sin

import cadquery as cq
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.gp import gp_Pnt


def ring(z, a, b, turn):
    """A closed spline about the axis, neither round nor plane."""
    angles = [2 * pi * j / 12 for j in range(12)]
    points = [
        (a * cos(u + turn) * (1 + 0.15 * sin(3 * u)), b * sin(u + turn) * (1 + 0.1 * cos(2 * u)), z + 0.8 * sin(2 * u))
        for u in angles
    ]
    return cq.Wire.assembleEdges([cq.Edge.makeSpline([cq.Vector(*p) for p in points], periodic=True)])


loft = BRepOffsetAPI_ThruSections(True, False, 1e-6)
loft.AddVertex(BRepBuilderAPI_MakeVertex(gp_Pnt(0, 0, -10)).Vertex())
for section in ((-7, 5, 4, 0.0), (0, 9, 6, 0.3), (6, 5, 7, 0.6)):
    loft.AddWire(ring(*section).wrapped)
loft.AddVertex(BRepBuilderAPI_MakeVertex(gp_Pnt(1, 0, 11)).Vertex())
loft.Build()
result = cq.Workplane(obj=cq.Shape.cast(loft.Shape()))

show_object(result, name="pebble")  # noqa: F821
