"""Relaxation of a patch: every free node at the weighted mean of its neighbours, by one sparse solve.

Place in the flow: the first, cheap step of :mod:`cadsweep.smoothing.ladder` on an inverted patch. Its Laplacian
serves :mod:`.optimise` as well.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from ..arrays import FloatArray
from ..cells import AXIS_EDGES
from .patch import BoolArray, Patch

MOST_FREE = 30_000
"""Free nodes up to which a system is solved directly."""


def laplacian(patch: Patch) -> scipy.sparse.csr_matrix:
    """Graph Laplacian (n, n) of a patch's edges, weighted by one over the length that they should have.

    A layer half as thick pulls twice as hard, so graded layers keep their proportions.
    """
    n = len(patch.points)
    rows, cols, weights = [], [], []
    for axis in range(3):
        for a, b in AXIS_EDGES[axis]:
            rows.append(patch.hexes[:, a])
            cols.append(patch.hexes[:, b])
            weights.append(1.0 / patch.lengths[:, axis])
    i, j, w = (np.concatenate(part) for part in (rows, cols, weights))
    w = np.asarray(w / np.max(w))
    adjacency = scipy.sparse.coo_matrix((np.r_[w, w], (np.r_[i, j], np.r_[j, i])), shape=(n, n)).tocsr()
    return (scipy.sparse.diags(np.asarray(adjacency.sum(axis=1)).ravel()) - adjacency).tocsr()


def laplacian_solver(patch: Patch) -> Callable[[FloatArray], FloatArray]:
    """Inverse of the Laplacian of the free nodes, or of its diagonal where the patch is large."""
    system = laplacian(patch)[patch.free][:, patch.free].tocsc()
    if system.shape[0] > MOST_FREE:
        diagonal = system.diagonal()[:, None]
        return lambda rhs: rhs / diagonal
    factor = scipy.sparse.linalg.splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return lambda rhs: factor.solve(np.ascontiguousarray(rhs))


def relaxed(patch: Patch, points: FloatArray) -> FloatArray:
    """Move the free nodes to the mean of their neighbours along edges (:func:`laplacian`).

    Returns
    -------
    (n, 3) float64
        New positions; nodes that are not free keep theirs, bit for bit.
    """
    result = points.copy()
    moved = _solved(laplacian(patch), patch.free, points)
    if patch.snap is None:
        result[patch.free] = moved
        return result
    result[patch.free] += patch.allowed(moved - result[patch.free])
    return patch.snap(result)


def _solved(laplacian: scipy.sparse.csr_matrix, free: BoolArray, points: FloatArray) -> FloatArray:
    rows = laplacian[free]
    A, b = rows[:, free].tocsc(), -rows[:, ~free] @ points[~free]
    if A.shape[0] <= MOST_FREE:
        return np.asarray(scipy.sparse.linalg.spsolve(A, b)).reshape(-1, 3)
    x = points[free].copy()
    diagonal = scipy.sparse.diags(1.0 / A.diagonal())
    for c in range(3):
        x[:, c], _ = scipy.sparse.linalg.cg(A, b[:, c], x0=x[:, c], rtol=1e-6, maxiter=500, M=diagonal)
    return x
