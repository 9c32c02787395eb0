"""Values of some nodes of a quad mesh carried to all others: each of these the mean of its neighbours.

Place in the flow: foundation of :mod:`.nodes`, :mod:`.places` and :mod:`.straight`.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import BoolArray, FloatArray, IntArray

_LEAST = 1e-6
"""Length, in sizes of the mesh, below which neighbours count as if they were so far away."""


def carried(values: FloatArray, fixed: BoolArray, quads: IntArray, points: FloatArray | None = None) -> FloatArray:
    """Values (n, k) of all nodes of quads (q, 4): those that are `fixed` (n,) keep theirs.

    Where `points` (n, 3) are given, neighbours count by one over the square of their distance, as in a harmonic
    function of the plane: the two sides of a narrow cell go together, whatever is beyond.
    """
    inner, outer = np.flatnonzero(~fixed), np.flatnonzero(fixed)
    if not len(inner):
        return values
    n = len(values)
    ends = np.stack([quads, np.roll(quads, -1, axis=1)]).reshape(2, -1)
    pairs = np.concatenate([ends, ends[::-1]], axis=1)
    weights = scipy.sparse.coo_array((np.ones(pairs.shape[1]), (pairs[0], pairs[1])), shape=(n, n)).tocsr()
    weights.data[:] = 1.0  # an edge of two quads is one neighbour
    if points is not None:
        rows = np.repeat(np.arange(n), np.diff(weights.indptr))
        lengths = np.linalg.norm(points[rows] - points[weights.indices], axis=1)
        typical = float(np.median(lengths))
        weights.data[:] = (typical / np.maximum(lengths, _LEAST * typical)) ** 2
    degree = np.asarray(weights.sum(axis=1)).ravel()
    rows = weights[inner]
    matrix = scipy.sparse.csc_array(scipy.sparse.diags_array(degree[inner]) - rows[:, inner])
    found = values.copy()
    found[inner] = scipy.sparse.linalg.splu(matrix).solve(np.ascontiguousarray(rows[:, outer] @ values[outer]))
    return found
