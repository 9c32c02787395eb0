"""Nodes on faces of the model and of contacts that smoothing may move: inside a face on it, on an edge along it.

Place in the flow: ``pipeline`` asks for them where the checks of a joined mesh ask for smoothing. A node is one node
for all cells and solids that have it, so the mesh stays conformal wherever it goes. Where a cut meets a face of the
model nothing is there: the nodes move on the face.

Not moved: nodes at vertices of the cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..brep import Curve, Part, Surface
from .finish import by_face
from .joined import JoinedMesh
from .naming import NamedFaces

_STEP = 1e-6
"""Fraction of an edge's length over which its tangent is measured."""


@dataclass(frozen=True, kw_only=True, eq=False)
class InterfaceSlides:
    """Nodes that may move on faces or along edges.

    Attributes
    ----------
    mask : (n,) bool
        Nodes that may.
    surface, curve : (n,) int64
        Number of the surface that a node is on, or of the edge; -1 for none.
    surfaces : sequence of Surface
    curves : sequence of Curve
    """

    mask: BoolArray
    surface: IntArray
    curve: IntArray
    surfaces: Sequence[Surface]
    curves: Sequence[Curve]

    def projectors(self, nodes: IntArray, points: FloatArray) -> FloatArray:
        """What of a movement (m, 3, 3) nodes (m,) at points (m, 3) can follow; all of it for those that are free."""
        found = np.repeat(np.eye(3)[None], len(nodes), axis=0)
        for number, at in _groups(self.surface[nodes]):
            own = self.surfaces[number]
            normals = own.normals(own.project(points[at]))
            found[at] -= normals[:, :, None] * normals[:, None, :]
        for number, at in _groups(self.curve[nodes]):
            edge = self.curves[number]
            fractions = edge.project(points[at])
            tangents = edge.evaluate(np.minimum(fractions + _STEP, 1.0)) - edge.evaluate(
                np.maximum(fractions - _STEP, 0.0)
            )
            tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-300)
            found[at] = tangents[:, :, None] * tangents[:, None, :]
        return found

    def snapped(self, nodes: IntArray, points: FloatArray, start: FloatArray) -> FloatArray:
        """Points (m, 3) brought back to their nodes' faces and edges; those that have not moved from `start` stay."""
        found = points.copy()
        has_moved = (points != start).any(axis=1)
        for number, at in _groups(np.where(has_moved, self.surface[nodes], -1)):
            own = self.surfaces[number]
            found[at] = own.evaluate(own.project(points[at]))
        for number, at in _groups(np.where(has_moved, self.curve[nodes], -1)):
            edge = self.curves[number]
            found[at] = edge.evaluate(edge.project(points[at]))
        return found

    def ways(self, nodes: IntArray, ends: IntArray, points: FloatArray) -> FloatArray:
        """Tangents (m, 3) of edges that `ends` (m,) slide along, at nodes (m,) at points (m, 3) that are on them."""
        found = np.full((len(nodes), 3), np.nan)
        for number, at in _groups(self.curve[ends]):
            edge = self.curves[number]
            fractions = edge.project(points[at])
            low, high = np.maximum(fractions - _STEP, 0.0), np.minimum(fractions + _STEP, 1.0)
            tangents = edge.evaluate(high) - edge.evaluate(low)
            off = np.linalg.norm(edge.evaluate(fractions) - points[at], axis=1)
            on = off <= _STEP * np.linalg.norm(tangents, axis=1) / (high - low)
            found[at[on]] = tangents[on]
        return found


def _groups(numbers: IntArray) -> list[tuple[int, IntArray]]:
    return [(int(number), np.flatnonzero(numbers == number)) for number in np.unique(numbers[numbers >= 0])]


def find_interface_slides(
    part: Part,
    joined: JoinedMesh,
    names: NamedFaces,
    *,
    along_edges: bool = True,
    outside: bool = True,
    curved: bool = True,
) -> InterfaceSlides:
    """Find the nodes on faces and edges of the model, and of contacts, that may move.

    Parameters
    ----------
    part : Part
    joined : JoinedMesh
    names : NamedFaces
    along_edges : bool
        Let nodes move along edges, too; not where their places were asked for.
    outside : bool
        Let nodes on outer faces and their edges move; not where they have to answer others.
    curved : bool
        Let nodes move where what they are on is bent; not where quads and segments have to keep a tolerance.
    """
    n = len(joined.points)
    surface, curve = np.full((2, n), -1, dtype=np.int64)
    surfaces: list[Surface] = []
    curves: list[Curve] = []
    of_contact: set[int] = set()
    around: dict[int, set[tuple[int, str]]] = {}
    for cell, face in names.outside | names.between:
        solid = part.solids[cell]
        own = solid.faces[face]
        for key in map(int, solid.edge_keys[list(own.edges)]):
            # Pieces of one face of the model that a cut parted are one face.
            around.setdefault(key, set()).add((part.owners[cell], own.key or f"{cell}, {face}"))
            if (cell, face) in names.between:
                of_contact.add(key)
    for (cell, face), quads in by_face(joined):
        between = names.first.get((cell, face), False)  # of the two sides of a contact one is enough
        own = part.solids[cell].faces[face]
        if (between or (outside and (cell, face) in names.outside)) and (curved or own.kind == "plane"):
            surface[quads[:, :4]] = len(surfaces)
            surfaces.append(own.surface)
    edges = {
        int(key): edge.curve
        for solid in part.solids
        for key, edge in zip(solid.edge_keys, solid.edges, strict=True)
        if int(key) in around and (curved or edge.kind == "line")
    }
    uses = np.zeros(n, dtype=np.int64)
    for key, nodes in joined.edge_nodes.items():
        if len(around.get(key, ())) == 1 and key not in of_contact:
            surface[nodes[[0, -1]]] = -1  # a cut ends on the face there: what is along it stays on the face
            continue
        surface[nodes] = -1
        uses[nodes] += 1
        uses[nodes[[0, -1]]] += 2  # at a vertex
        if along_edges and key in edges and (outside or key in of_contact):
            curve[nodes[1:-1]] = len(curves)
            curves.append(edges[key])
    curve[uses > 1] = -1
    return InterfaceSlides(
        mask=(surface >= 0) | (curve >= 0), surface=surface, curve=curve, surfaces=surfaces, curves=curves
    )


__all__ = ["InterfaceSlides", "find_interface_slides"]
