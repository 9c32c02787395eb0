"""Nodes of a fitted grid put on the model: vertices, then edges, then faces, and the inside after them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import spsolve

from ..arrays import FloatArray, IntArray
from ..brep import Solid
from ..cells import HEX_EDGES
from .sheets import Fitted

_EVEN = 0.4
"""Share of an even step that projected nodes on an edge are apart at least; else they are laid evenly."""


def place_on_model(solid: Solid, mesh: Fitted) -> FloatArray:
    """Points (n, 3) of the mesh with every node of its boundary on its vertex, edge or face.

    Nodes of an edge keep the places nearest to them where these are in order and apart, else they lie evenly. Those
    inside faces are first laid evenly between the edges; the inside follows the boundary harmonically.
    """
    points = mesh.points.copy()
    is_set = np.zeros(len(points), dtype=bool)
    for number, chain in mesh.chains.items():
        edge = solid.edges[number]
        even = np.linspace(0.0, 1.0, len(chain))
        found = edge.curve.project(points[chain])
        found[[0, -1]] = 0.0, 1.0
        if np.diff(found).min() < _EVEN / (len(chain) - 1):
            found = even
        places = edge.curve.evaluate(found)
        places[0], places[-1] = solid.vertices[edge.start], solid.vertices[edge.end]
        points[chain] = places
        is_set[chain] = True
    for number in np.unique(mesh.labels).tolist():
        face = solid.faces[number]
        quads = mesh.quads[mesh.labels == number]
        sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
        laid = _followed(mesh.points, points, sides, is_set)
        inner = np.unique(quads)
        inner = inner[~is_set[inner]]
        if len(inner):
            points[inner] = face.surface.evaluate(face.surface.project(laid[inner]))
    is_set[mesh.quads] = True
    return _followed(mesh.points, points, mesh.hexes[:, HEX_EDGES].reshape(-1, 2), is_set)


def outside_of(solid: Solid, mesh: Fitted, height: float) -> tuple[IntArray, Callable[[FloatArray], FloatArray]]:
    """Hexahedra (q, 8) outside on the mesh's quads, and what gives their outer nodes for nodes (n, 3) of the mesh.

    Outer nodes are numbered after the mesh's, those of each face by themselves, `height` off it.
    """
    hexes, places, first = [], [], len(mesh.points)
    for face in np.unique(mesh.labels).tolist():
        nodes, local = np.unique(mesh.quads[mesh.labels == face], return_inverse=True)
        local = local.reshape(-1, 4)
        hexes.append(np.concatenate([nodes[local], first + local], axis=1))
        places.append((solid.faces[face].surface, nodes))
        first += len(nodes)

    def outer(points: FloatArray) -> FloatArray:
        return np.concatenate(
            [points[nodes] + height * surface.normals(surface.project(points[nodes])) for surface, nodes in places]
        )

    return np.concatenate(hexes), outer


def _followed(rest: FloatArray, points: FloatArray, sides: IntArray, is_set: np.ndarray) -> FloatArray:
    """The points; those of the sides (s, 2) that are not set move from `rest` as those around them do, harmonically."""
    nodes, local = np.unique(sides, return_inverse=True)
    local = local.reshape(-1, 2)
    n = len(nodes)
    graph = coo_array((np.ones(len(local)), (local[:, 0], local[:, 1])), shape=(n, n)).tocsr()
    graph = graph + graph.T
    laplacian = (diags_array(graph.sum(axis=1)) - graph).tocsr()
    known = is_set[nodes]
    free = ~known
    if not free.any():
        return points
    moved = (points - rest)[nodes]
    right = -(laplacian[free][:, known] @ moved[known])
    found = points.copy()
    found[nodes[free]] = rest[nodes[free]] + spsolve(laplacian[free][:, free].tocsc(), right).reshape(-1, 3)
    return found
