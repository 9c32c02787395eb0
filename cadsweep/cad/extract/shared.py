"""What the solids of a part share: keys, curves, surfaces and vertices, each one object for all.

Place in the flow: ``imprint`` makes one for a part of several solids, ``solids`` one for a solid alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS

from ...arrays import FloatArray, IntArray
from ...errors import CadError
from ..geometry.convert import read_curves, read_surface
from ..geometry.curves import EdgeCurve
from ..geometry.surfaces import Geometry
from ..shapes import EDGE, FACE, VERTEX, index_map, mapped, space_range
from .sampling import EdgeSamples, sample_edges


class PartGeometry:
    """The vertices, edges and faces of a whole part, each with one key and read once for all of its solids.

    Parameters
    ----------
    shape : TopoDS_Shape
        The part: one solid, or a compound of solids that share what they touch in.
    curves : sequence of (EdgeCurve, str), optional
        Curves and kinds of all its edges, where they were read already.
    closed : float
        Width of gaps between solids that were closed, which leaves edges as far from vertices and faces.
    """

    def __init__(self, shape: Any, *, curves: Sequence[tuple[EdgeCurve, str]] = (), closed: float = 0.0) -> None:
        self.closed = closed
        self._maps = {kind: index_map(shape, kind) for kind in (VERTEX, EDGE, FACE)}
        self._given = list(curves)
        self._surfaces: dict[int, Geometry] = {}

    def keys(self, kind: Any, own: Sequence[Any]) -> IntArray:
        """Numbers (m,) of vertices, edges or faces within the part."""
        found = self._maps[kind]
        return np.array([found.FindIndex(s) - 1 for s in own], dtype=np.int64)

    @cached_property
    def curves(self) -> list[tuple[EdgeCurve, str]]:
        """Curve and kind of every edge, by key."""
        return self._given or read_edge_curves(mapped(self._maps[EDGE], EDGE))

    def surface(self, face: Any) -> Geometry:
        """Surface of a face, one object for both of its solids."""
        key = self._maps[FACE].FindIndex(face)
        if key not in self._surfaces:
            self._surfaces[key] = read_surface(BRep_Tool.Surface_s(face))
        return self._surfaces[key]

    @cached_property
    def samples(self) -> EdgeSamples:
        """Every edge at its start, middle and end, by key."""
        return sample_edges([curve for curve, _ in self.curves])

    @cached_property
    def ends(self) -> IntArray:
        """Keys (n_edges, 2) of the vertices where each edge starts and ends, by key."""
        vertices = self._maps[VERTEX]
        found = []
        for edge in mapped(self._maps[EDGE], EDGE):
            forward = TopoDS.Edge_s(edge.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
            ends = TopExp.FirstVertex_s(forward, True), TopExp.LastVertex_s(forward, True)
            found.append([vertices.FindIndex(vertex) - 1 for vertex in ends])
        return np.array(found, dtype=np.int64).reshape(-1, 2)

    @cached_property
    def vertex_shapes(self) -> list[Any]:
        """The vertices, by key."""
        return mapped(self._maps[VERTEX], VERTEX)

    @cached_property
    def vertices(self) -> FloatArray:
        """Points (n_vertices, 3) as the model has them."""
        places = [BRep_Tool.Pnt_s(vertex) for vertex in self.vertex_shapes]
        return np.array([(p.X(), p.Y(), p.Z()) for p in places]).reshape(-1, 3)

    @cached_property
    def positions(self) -> FloatArray:
        """Points (n_vertices, 3): of several that sewing took for one vertex, always the first edge's end."""
        points = self.vertices.copy()
        points[self.ends[::-1].ravel()] = self.samples.points[::-1, ::2].reshape(-1, 3)
        return points


def read_edge_curves(edges: Sequence[Any]) -> list[tuple[EdgeCurve, str]]:
    """Curve and kind of every edge."""
    found = [BRep_Tool.Curve_s(edge, 0.0, 1.0) for edge in edges]
    if None in found:
        raise CadError(
            f"Edge {found.index(None)} has no curve in space. Repair the model in its CAD program and export it again."
        )
    read = []
    for edge, (geometry, kind, breaks, constant_speed) in zip(edges, read_curves(found), strict=True):
        first, last = space_range(edge)
        curve = EdgeCurve(geometry=geometry, first=first, last=last, breaks=breaks, constant_speed=constant_speed)
        read.append((curve, kind))
    return read
