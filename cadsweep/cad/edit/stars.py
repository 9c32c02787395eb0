"""A polyhedron parted from a point inside that sees all of its faces: a tetrahedron over every triangle.

Place in the flow: the last candidate of :mod:`.cutters`. Planes through a corner with more than three edges part most
solids into cells with a block of hexahedra at every corner; where many such corners hang together (an icosahedron),
each plane leaves as many as it takes away.

Method: a triangle from every edge to the point, and, of a face with more than three corners, from each of them and the
face's middle. All cells have four corners of three edges each.

Not handled: curved faces, faces with holes, solids that no point sees all of.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
from OCP.gp import gp_Pnt

from ...arrays import FloatArray
from ...brep import Face, Solid
from ...corner_blocks import View
from ..shapes import shapes_of
from .central import Cutter

DEEP = 0.05
"""Distance of the point from all faces, as a share of the solid's size, from which on its cells are no slivers."""
MOST_FACES = 60
"""Faces of a solid beyond which cells over all of them are too many."""


def from_inside(solid: Solid) -> list[Cutter]:
    """Triangles from all edges to a point inside; none where no corner has more than three edges, or no point does."""
    center = _center(solid)
    if center is None:
        return []
    corners = [solid.vertices[[edge.start, edge.end]] for edge in solid.edges]
    for face in solid.faces:
        if len(face.edges) > 3:
            vertices = sorted({v for e in face.edges for v in (solid.edges[e].start, solid.edges[e].end)})
            corners += [np.array([solid.vertices[v], face.center]) for v in vertices]
    return [
        Cutter(
            kind="star",
            reason="triangles from all edges to a point inside",
            tools=tuple(_triangle(first, last, center) for first, last in corners),
            weight=solid.size,
        )
    ]


def _center(solid: Solid) -> FloatArray | None:
    """A point that sees all faces, near the middle; None where the solid is none that a star parts."""
    if len(solid.faces) > MOST_FACES or any(edge.kind != "line" for edge in solid.edges):
        return None
    if any(face.kind != "plane" or len(face.loops) > 1 or not _sees_outline(solid, face) for face in solid.faces):
        return None
    degrees = np.bincount([v for edge in solid.edges for v in (edge.start, edge.end)])
    if degrees.max() < 4:
        return None
    view = View.of(np.array([face.center for face in solid.faces]), -np.array([face.normal for face in solid.faces]))
    return None if view.depth() < DEEP * solid.size else view.nearest(shapes_of(solid).mass[1])


def _sees_outline(solid: Solid, face: Face) -> bool:
    """Whether a face's middle sees the whole outline."""
    return all(
        float(np.cross(first - face.center, last - first) @ face.normal) > 0.0
        for e, forward in face.loops[0].directed
        for first, last in [solid.vertices[[solid.edges[e].start, solid.edges[e].end][:: 1 if forward else -1]]]
    )


def _triangle(*places: FloatArray) -> Any:
    wire = BRepBuilderAPI_MakePolygon()
    for place in places:
        wire.Add(gp_Pnt(*map(float, place)))
    wire.Close()
    return BRepBuilderAPI_MakeFace(wire.Wire(), True).Face()


__all__ = ["from_inside"]
