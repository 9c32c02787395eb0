"""Quads between nodes at places of a lattice.

Place in the flow: for the block-structured ways of :mod:`.filling`.
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray

STEPS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
"""The four ways from a place, counterclockwise."""
CELL = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
"""Corners of a cell, counterclockwise from its lower left place."""


def quads_of(number: IntArray, cells: IntArray) -> IntArray:
    """Quads (m, 4) of cells (m, 2), the nodes numbered by place."""
    corners = cells[:, None] + CELL
    return number[corners[..., 0], corners[..., 1]]


def numbered(number: IntArray, cells: IntArray, first: int) -> IntArray:
    """The same numbers, and those of the inner nodes of cells, from `first` on; -1 where no cell is."""
    touched = np.zeros(number.shape, dtype=np.bool_)
    corners = cells[:, None] + CELL
    touched[corners[..., 0], corners[..., 1]] = True
    inner = np.argwhere(touched & (number < 0))
    number[inner[:, 0], inner[:, 1]] = first + np.arange(len(inner))
    return number


def places_around(p: int, q: int) -> IntArray:
    """Places around a rectangle of p x q cells, clockwise from its lower left corner."""
    steps = np.repeat(STEPS[[1, 0, 3, 2]], [q, p, q, p], axis=0)
    return np.concatenate([np.zeros((1, 2), dtype=np.int64), np.cumsum(steps, axis=0)[:-1]])


def every_cell(core: IntArray) -> IntArray:
    """Places (c, 2) of all cells between nodes that are numbered (p + 1, q + 1)."""
    return np.argwhere(np.ones((core.shape[0] - 1, core.shape[1] - 1), dtype=np.bool_))


def rectangle(n: int, first: int, p: int) -> IntArray:
    """Numbers (p + 1, q + 1) of the nodes of p x q quads with n nodes around, these first, a corner at node `first`."""
    q = n // 2 - p
    core = np.empty((p + 1, q + 1), dtype=np.int64)
    edge = np.roll(np.arange(n), -first)
    core[:, 0] = edge[: p + 1]
    core[-1, :] = edge[p : p + q + 1]
    core[:, -1] = edge[p + q : 2 * p + q + 1][::-1]
    core[0, 1:] = edge[2 * p + q :][::-1]
    core[1:-1, 1:-1] = n + np.arange((p - 1) * (q - 1)).reshape(p - 1, q - 1)
    return core
