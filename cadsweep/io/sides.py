"""Sides of hexes: the quads that a (hex, side) pair stands for, of any order."""

from __future__ import annotations

import numpy as np

from ..mesh import HEX_FACES
from ..topology import IntArray

HEX_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]], dtype=np.int64
)
"""Edge j of a hex has its middle at node 8 + j."""


def _full_sides() -> IntArray:
    middle = {frozenset(edge): 8 + j for j, edge in enumerate(HEX_EDGES.tolist())}
    centres = {
        (0, 3, 4, 7): 20,
        (1, 2, 5, 6): 21,
        (0, 1, 4, 5): 22,
        (2, 3, 6, 7): 23,
        (0, 1, 2, 3): 24,
        (4, 5, 6, 7): 25,
    }
    rows = []
    for face in HEX_FACES.tolist():
        edges = [middle[frozenset((face[k], face[(k + 1) % 4]))] for k in range(4)]
        rows.append([*face, *edges, centres[tuple(sorted(face))]])
    return np.array(rows, dtype=np.int64)


SIDES = _full_sides()
"""Local nodes of the six outward sides: corners, middles of the edges, centre; the order of ``HEX_FACES``."""


def quads_of_sides(hexes: IntArray, of: IntArray, sides: IntArray) -> IntArray:
    """Outward quads (q, 4 | 8 | 9) of the sides of hexes (m, 8 | 20 | 27)."""
    width = {8: 4, 20: 8, 27: 9}[hexes.shape[1]]
    return hexes[np.asarray(of)[:, None], SIDES[np.asarray(sides), :width]]
