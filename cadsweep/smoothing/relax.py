"""Relaxation of a patch: every free node at the weighted mean of its neighbours, by one sparse solve.

Place in the flow: the first, cheap step of :mod:`cadsweep.smoothing.ladder` on an inverted patch.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from ..topology import FloatArray
from .patch import EDGES, BoolArray, Patch

MOST_FREE = 20_000
"""Free nodes up to which the system is solved directly; larger ones are iterated."""


def relaxed(patch: Patch, points: FloatArray) -> FloatArray:
    """Move the free nodes to the mean of their neighbours along edges, weighted by one over length.

    The weights come from the wanted lengths, so a layer half as thick pulls twice as hard and
    graded layers keep their proportions.

    Returns
    -------
    (n, 3) float64
        New positions; nodes that are not free keep theirs, bit for bit.
    """
    n = len(points)
    rows, cols, weights = [], [], []
    for axis in range(3):
        for a, b in EDGES[axis]:
            rows.append(patch.hexes[:, a])
            cols.append(patch.hexes[:, b])
            weights.append(1.0 / patch.lengths[:, axis])
    i, j, w = (np.concatenate(part) for part in (rows, cols, weights))
    w = np.asarray(w / np.max(w))
    adjacency = sparse.coo_matrix((np.r_[w, w], (np.r_[i, j], np.r_[j, i])), shape=(n, n)).tocsr()
    laplacian = sparse.diags(np.asarray(adjacency.sum(axis=1)).ravel()) - adjacency
    result = points.copy()
    result[patch.free] = _solved(laplacian.tocsr(), patch.free, points)
    return result


def _solved(laplacian: sparse.csr_matrix, free: BoolArray, points: FloatArray) -> FloatArray:
    rows = laplacian[free]
    A, b = rows[:, free].tocsc(), -rows[:, ~free] @ points[~free]
    if A.shape[0] <= MOST_FREE:
        return np.asarray(spsolve(A, b)).reshape(-1, 3)
    x = points[free].copy()
    diagonal = sparse.diags(1.0 / A.diagonal())
    for c in range(3):
        x[:, c], _ = sparse.linalg.cg(A, b[:, c], x0=x[:, c], rtol=1e-6, maxiter=500, M=diagonal)
    return x
