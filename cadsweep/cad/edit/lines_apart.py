"""Which projected outlines touch no other one, so that nothing has to divide them.

Place in the flow: between the projection of a stack's edges and their fuse.

Method: edges of one flat cap meet nowhere but in their common ends, because that face is seen once along the direction.
Any other two are apart where bounds of their pieces say so. Lines that hang together with one that may touch a stranger
go to the fuse with it; the others take common vertices where their ends meet.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Edge, TopoDS_Vertex

from ...arrays import BoolArray, FloatArray, IntArray
from ...brep import Solid
from ..geometry.plane_curves import PlaneCurves, near_pairs
from ..shapes import space_range

_CONFUSED = 1e-7
"""Tolerance of OpenCASCADE's own new edges and vertices."""
_ENDS = (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED)


class Corners:
    """Where projected lines begin and end.

    Parameters
    ----------
    ends : (n, 2, 3) float64
        Of each line on the plane.
    reach : float
        Distance up to which ends count as one.
    """

    def __init__(self, ends: FloatArray, reach: float) -> None:
        places = ends.reshape(-1, 3)
        close = scipy.spatial.cKDTree(places).query_pairs(reach, output_type="ndarray")
        self.of_lines: IntArray = components(len(places), close).reshape(-1, 2)
        _, first = np.unique(self.of_lines, return_index=True)
        self.places = places[first]
        off = np.linalg.norm(places - self.places[self.of_lines.ravel()], axis=1)
        self.tolerances = np.full(len(first), _CONFUSED)
        np.maximum.at(self.tolerances, self.of_lines.ravel(), 1.01 * off)
        self._vertices: dict[int, Any] = {}
        self._builder = BRep_Builder()

    def join(self, line: int, shape: Any) -> Any:
        """A projected edge between the common vertices of its ends."""
        joined = TopoDS_Edge()
        self._builder.MakeEdge(joined, BRep_Tool.Curve_s(shape, 0.0, 1.0), _CONFUSED)
        for corner, turn in zip(self.of_lines[line].tolist(), _ENDS, strict=True):
            self._builder.Add(joined, self._vertex(corner).Oriented(turn))
        self._builder.Range(joined, *space_range(shape))
        return joined

    def _vertex(self, corner: int) -> Any:
        if corner not in self._vertices:
            self._vertices[corner] = vertex = TopoDS_Vertex()
            self._builder.MakeVertex(vertex, gp_Pnt(*self.places[corner]), float(self.tolerances[corner]))
        return self._vertices[corner]


def lines_apart(  # noqa: PLR0917
    solid: Solid,
    sides: Mapping[int, int],
    over: Sequence[Sequence[int]],
    curves: PlaneCurves,
    corners: Corners,
    reach: float,
) -> BoolArray:
    """Tell which lines hang together with none that may come near a stranger.

    Parameters
    ----------
    solid : Solid
    sides : mapping of int to int
        Its caps.
    over : sequence of n sequences of int
        Edges of the solid over each line.
    curves : PlaneCurves
        Of the lines.
    corners : Corners
        Their ends.
    reach : float
        Distance from which on they are strangers.
    """
    flat = [
        {f for e in own for f in solid.edges[e].faces if f in sides and solid.faces[f].kind == "plane"} for own in over
    ]
    pairs = near_pairs(curves.boxes, curves.boxes, reach)
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    strangers = np.array([flat[a].isdisjoint(flat[b]) for a, b in pairs.tolist()], dtype=np.bool_)
    pairs = pairs[strangers]
    ends = corners.of_lines[pairs]
    joined = (ends[:, 0, :, None] == ends[:, 1, None, :]).any(axis=(1, 2))
    joined[~joined] = curves.touching(pairs[~joined], reach)
    touched = np.zeros(len(over), dtype=np.bool_)
    touched[pairs[joined]] = True
    touched |= ~curves.bounded()
    together = components(len(corners.places), corners.of_lines)[corners.of_lines[:, 0]]
    return ~np.isin(together, together[touched])


def components(n: int, pairs: IntArray) -> IntArray:
    """For each of n things the number of the group that pairs (m, 2) join it to, groups by their first."""
    graph = scipy.sparse.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, labels = scipy.sparse.csgraph.connected_components(graph, directed=False)
    found: IntArray = labels.astype(np.int64)
    return found


__all__ = ["Corners", "components", "lines_apart"]
