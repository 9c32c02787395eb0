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
from .tips import Tip

_EVEN = 0.4
"""Share of an even step that projected nodes on an edge are apart at least; else they are laid evenly."""


def place_on_model(solid: Solid, mesh: Fitted, creases: Sequence[Crease] = (), tips: Sequence[Tip] = ()) -> FloatArray:
    """Points (n, 3) of the mesh with every node of its boundary on its vertex, edge or face, tips where they end.

    Nodes of an edge keep the places nearest to them where these are in order and apart, else they lie evenly. Those
    inside faces are first laid evenly between the edges, some then on a crease inside the face; the inside follows the
    boundary harmonically.
    """
    points = mesh.points.copy()
    is_set = np.zeros(len(points), dtype=bool)
    ends = {(tip.vertex, edge): fraction for tip in tips for edge, fraction in tip.fractions.items()}
    for number, chain in mesh.chains.items():
        edge = solid.edges[number]
        first, last = ends.get((edge.start, number), 0.0), ends.get((edge.end, number), 1.0)
        even = np.linspace(first, last, len(chain))
        found = edge.curve.project(points[chain])
        found[[0, -1]] = first, last
        if np.diff(found).min() < _EVEN * (last - first) / (len(chain) - 1):
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
