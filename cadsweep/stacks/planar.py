"""How good the quads of every cell of an arrangement are, beside what its corners allow.

Place in the flow: after the arrangement has been meshed. Columns are straight, so the worst corner of a hexahedron is
that of its quad, but for the lean of its caps.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..mesh import QuadMesh
from ..stack import Stack
from .sides import LEAST_ACROSS, MOST_ACROSS

_ENDS_ALONG = 1e-3
"""1 - cosine to the direction up to which an edge ends along it."""
WANTED = 0.35
"""Worst corner sine below which a cell is worth shorter segments: somewhat more than is promised of hexahedra."""
_SHARE = 0.9
"""Part of what a cell's own corners allow that is good enough."""


def corner_sines(stack: Stack, mesh: QuadMesh) -> FloatArray:
    """Worst corner sine of every quad, seen along the direction; negative where it is folded."""
    corners = mesh.points[mesh.quads]
    after, before = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    area = np.cross(after, before) @ stack.direction
    lengths = np.linalg.norm(after, axis=2) * np.linalg.norm(before, axis=2)
    return np.asarray((area / np.maximum(lengths, 1e-300)).min(axis=1))


def find_poor_edges(stack: Stack, mesh: QuadMesh) -> tuple[set[int], float]:
    """Edges of the cells whose quads are worse than they need be.

    Returns
    -------
    edges : set of int
        Of the arrangement.
    worst : float
        Worst corner sine of all quads.
    """
    sines = corner_sines(stack, mesh)
    worst = np.ones(len(stack.arrangement.prism.faces))
    np.minimum.at(worst, mesh.faces, sines)
    poor: set[int] = set()
    for f in stack.arrangement.bottoms:
        face = stack.arrangement.prism.faces[f]
        sharpest = min([np.pi / 2, *(angle for loop in face.loops for angle in loop.angles)])
        if worst[f] < min(WANTED, _SHARE * np.sin(sharpest)):
            poor.update(face.edges)
    return poor, float(sines.min())


def sizes_across(stack: Stack, size: float) -> dict[int, float]:
    """Lengths of the segments of edges across roundings, where the plane shows nothing of their turn.

    Returns
    -------
    dict of int to float
        By edge of the arrangement: such that a quarter of a circle has two chords or more, and three at most, since of
        more the one at the wall would be too steep.
    """
    solid, rounded = stack.solid, set(stack.rounded)
    sizes: dict[int, float] = {}
    for own, over in stack.arrangement.over.items():
        for e in over:
            edge = solid.edges[e]
            if rounded.intersection(edge.faces) and np.abs(edge.tangents @ stack.direction).max() > 1.0 - _ENDS_ALONG:
                length = stack.arrangement.prism.edges[own].length
                sizes[own] = length / min(max(round(length / size), LEAST_ACROSS), MOST_ACROSS)
    return sizes
