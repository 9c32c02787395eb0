"""CGNS' element types of orders 1 to 4, and the order of their nodes.

Place in the flow: tables for :mod:`cadsweep.io.cgns`.

References
----------
CGNS SIDS, "Unstructured Grid Element Numbering Conventions"; of orders 3 and 4 held against files of gmsh's writer.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from ..arrays import IntArray
from ..lattice import lexicographic, order_of, quad_lexicographic

HEX_TYPES = {8: 17, 20: 18, 27: 19, 64: 39, 125: 56}
QUAD_TYPES = {4: 7, 8: 8, 9: 9, 16: 28, 25: 44}

_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 5), (2, 6), (3, 7), (4, 5), (5, 6), (6, 7), (7, 4))
_FACES = ((0, 1, 3), (0, 1, 4), (1, 2, 5), (2, 3, 6), (3, 0, 7), (4, 5, 7))
"""Corners from which, and towards which two, the nodes inside a face are walked."""


def _spiral(n: int) -> IntArray:
    """Places (n * n, 2) of a square lattice, around from its first corner and inwards."""
    if n < 2:
        return np.zeros((n, 2), dtype=np.int64)
    side = np.arange(n - 1)
    low, high = np.zeros(n - 1, dtype=np.int64), np.full(n - 1, n - 1)
    around = [(side, low), (high, side), (high - side, high), (low, high - side)]
    return np.concatenate([*(np.column_stack(pair) for pair in around), _spiral(n - 2) + 1])


@cache
def hex_order(size: int) -> IntArray:
    """``cgns_nodes = vtk_nodes[:, hex_order(n)]``: corners, bottom, upright and top edges, faces, inside by layers."""
    order = order_of(size)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    corners = order * np.array([[*corner, k] for k in (0, 1) for corner in square.tolist()])
    steps, across = np.arange(1, order)[:, None], _spiral(order - 1) + 1
    edges = [corners[a] + (corners[b] - corners[a]) // order * steps for a, b in _EDGES]
    faces = [corners[a] + across @ (corners[[b, d]] - corners[a]) // order for a, b, d in _FACES]
    layers = [np.column_stack([across, np.full(len(across), k)]) for k in range(1, order)]
    places = np.concatenate([corners, *edges, *faces, *layers])
    numbers = lexicographic(order)[places @ (order + 1) ** np.arange(3)]
    return numbers[numbers < size]  # of 20 nodes the first of 27


@cache
def quad_order(size: int) -> IntArray:
    """The same of quads: corners, edges around, inside around."""
    if size == 8:
        return np.arange(8)
    order = int(size**0.5) - 1
    corners = order * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    steps = np.arange(1, order)[:, None]
    edges = [a + (b - a) // order * steps for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    places = np.concatenate([corners, *edges, _spiral(order - 1) + 1])
    return quad_lexicographic(order)[places @ (order + 1) ** np.arange(2)]
