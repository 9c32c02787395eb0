"""Nodes of a fitted grid put on the model: vertices, then edges, then faces, and the inside after them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid
from ..cells import HEX_EDGES
from ..harmonic import followed
from .finding import Crease
from .sheets import Fitted

_EVEN = 0.4
"""Share of an even step that projected nodes on an edge are apart at least; else they are laid evenly."""


def place_on_model(solid: Solid, mesh: Fitted, creases: Sequence[Crease] = ()) -> FloatArray:
    """Points (n, 3) of the mesh with every node of its boundary on its vertex, edge or face.

    Nodes of an edge keep the places nearest to them where these are in order and apart, else they lie evenly. Those
    inside faces are first laid evenly between the edges, some then on a crease inside the face; the inside follows the
    boundary harmonically.
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
        laid = followed(mesh.points, points, sides, is_set)
        inner = np.unique(quads)
        inner = inner[~is_set[inner]]
        if len(inner):
            points[inner] = face.surface.evaluate(face.surface.project(laid[inner]))
    for crease in creases:
        nodes = crease.nodes[~is_set[crease.nodes]]
        points[nodes] = crease.edge.curve.nearest(points[nodes])
    is_set[mesh.quads] = True
    return followed(mesh.points, points, mesh.hexes[:, HEX_EDGES].reshape(-1, 2), is_set)
