"""The skin of a mesh whose nodes are put somewhere else: its segments, what is under it, and what follows what moved.

Place in the flow: foundation, for whoever lays a mesh on the model afterwards (``fitted``, ``blends``).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import cg, spsolve

from .arrays import BoolArray, FloatArray, IntArray
from .cells import HEX_FACES
from .errors import SurfaceMeshError

_DIRECT = 20_000
"""Free nodes up to which the equations are solved at once; iterated for more, where factors would take long."""
_CLOSE = 1e-8
"""Residual, as a share of the right side, at which iterations end."""


def sides_of(quads: IntArray) -> tuple[IntArray, IntArray]:
    """Segments (s, 2) of the quads of a closed skin, and the two quads (s, 2) beside each.

    Raises
    ------
    SurfaceMeshError
        The skin touches itself along a segment.
    """
    every = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    order = np.lexsort(every.T)
    ordered = every[order]
    if len(ordered) % 2 or (ordered[::2] != ordered[1::2]).any() or (ordered[2::2] == ordered[:-2:2]).all(axis=1).any():
        raise SurfaceMeshError("the skin of the mesh touches itself along an edge")
    return ordered[::2], (order // 4).reshape(-1, 2)


def followed(
    rest: FloatArray, points: FloatArray, sides: IntArray, is_set: BoolArray, *, by_length: bool = False
) -> FloatArray:
    """The points; those of the sides (s, 2) that are not set move from `rest` as those around them do, harmonically.

    `by_length`: short sides are stiff, so that thin hexahedra move as a whole.
    """
    nodes, local = np.unique(sides, return_inverse=True)
    local = local.reshape(-1, 2)
    n = len(nodes)
    stiff = np.ones(len(local))
    if by_length:
        stiff /= np.maximum(((rest[sides[:, 0]] - rest[sides[:, 1]]) ** 2).sum(axis=1), 1e-300)
        stiff /= stiff.mean()
    graph = coo_array((stiff, (local[:, 0], local[:, 1])), shape=(n, n)).tocsr()
    graph = graph + graph.T
    laplacian = (diags_array(graph.sum(axis=1)) - graph).tocsr()
    known = is_set[nodes]
    free = ~known
    moved = (points - rest)[nodes]
    right = -(laplacian[free][:, known] @ moved[known])
    found = points.copy()
    if not free.any():
        return found
    if not right.any():
        found[nodes[free]] = rest[nodes[free]]
        return found
    own = laplacian[free][:, free].tocsc()
    if len(right) <= _DIRECT:
        by = spsolve(own, right).reshape(-1, 3)
    else:
        scaled = diags_array(1.0 / own.diagonal())
        by = np.column_stack([cg(own, column, rtol=_CLOSE, M=scaled)[0] for column in right.T])
    found[nodes[free]] = rest[nodes[free]] + by
    return found


def find_hexes(hexes: IntArray, quads: IntArray) -> IntArray:
    """The hexahedron (q,) that each quad (q, 4) of the boundary is of."""
    on_skin = np.zeros(int(hexes.max()) + 1, dtype=bool)
    on_skin[quads] = True
    near = np.flatnonzero(on_skin[hexes[:, HEX_FACES]].all(axis=2).ravel())  # few of all
    every = np.sort(hexes[:, HEX_FACES].reshape(-1, 4)[near], axis=1)
    _, numbers = np.unique(np.concatenate([every, np.sort(quads, axis=1)]), axis=0, return_inverse=True)
    numbers = numbers.ravel()
    at = np.full(int(numbers.max()) + 1, -1)
    at[numbers[: len(every)]] = near
    return at[numbers[len(every) :]] // 6


def mean_around(points: FloatArray, cells: IntArray) -> FloatArray:
    """Mean (n, 3) of the middles of the cells (quads or hexahedra) around every node; zero where there are none."""
    middles = np.repeat(points[cells].mean(axis=1), cells.shape[1], axis=0)
    total, counts = np.zeros_like(points), np.zeros(len(points))
    np.add.at(total, cells.ravel(), middles)
    np.add.at(counts, cells.ravel(), 1.0)
    return total / np.maximum(counts, 1.0)[:, None]


__all__ = ["find_hexes", "followed", "mean_around", "sides_of"]
