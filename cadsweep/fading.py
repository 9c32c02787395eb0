"""How the bow of curved boundary edges fades into a mesh: a harmonic field on its edges.

Place in the flow: called by :mod:`cadsweep.elevate`.

Method. The field lives on the mesh edges and is linked over the opposite edges of quads. These links never leave a
sheet of parallel edges, so the system falls into many small ones, each solved by conjugate gradients for x, y and z
together while it lies in the cache, and not at all where nothing bows.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
from numba import njit
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from .quality.threads import n_threads
from .topology import FloatArray, IntArray

ACCURACY = 1e-4
"""Residual, over the right-hand side, at which a field is smooth enough: one a little off harmonic is as good."""

MOST_STEPS = 2000

_njit = njit(cache=True, error_model="numpy", nogil=True)


def fade(values: FloatArray, fixed: np.ndarray, pairs: IntArray) -> FloatArray:
    """Continue values harmonically over the links of a graph.

    Parameters
    ----------
    values : (n, 3) float64
        Of which the fixed rows count.
    fixed : (n,) bool
    pairs : (p, 2) int64
        Links, each once.

    Returns
    -------
    (n, 3) float64
        The fixed rows as they are; the others the mean of those they are linked with; zero where no link leads to a
        fixed one.
    """
    free = np.flatnonzero(~fixed)
    if len(free) == 0:
        return values
    n = len(values)
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    links = coo_array((np.ones(len(rows)), (rows, columns)), shape=(n, n)).tocsr()[free]
    right = links[:, np.flatnonzero(fixed)] @ values[fixed]
    inner = csr_array(links[:, free])
    n_parts, part = connected_components(inner, directed=False)
    order = np.argsort(part, kind="stable")
    inner = csr_array(inner[order][:, order])
    starts = np.searchsorted(part[order], np.arange(n_parts + 1))
    found = np.zeros((len(free), 3))
    degree, target = np.asarray(links.sum(axis=1)).ravel()[order], np.ascontiguousarray(right[order])
    # Sheets of about the same number of unknowns to every thread.
    shares = np.searchsorted(starts, np.linspace(0, len(free), 1 + n_threads()))
    indptr, indices = inner.indptr.astype(np.int64), inner.indices.astype(np.int64)

    def work(share: tuple[int, int]) -> None:
        _solve(indptr, indices, degree, target, starts[share[0] : share[1] + 1], found)

    with ThreadPoolExecutor(n_threads(), thread_name_prefix="fading") as pool:
        list(pool.map(work, pairwise(shares.tolist())))
    result = values.copy()
    result[free[order]] = found
    return result


@_njit
def _multiply(indptr, indices, degree, first, vector, image):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Fill `image` with (degree - links) vector, for the rows from `first`; return their products."""
    products = np.zeros(3)
    for i in range(len(vector)):
        row = first + i
        x, y, z = degree[row] * vector[i, 0], degree[row] * vector[i, 1], degree[row] * vector[i, 2]
        for k in range(indptr[row], indptr[row + 1]):
            j = indices[k] - first
            x -= vector[j, 0]
            y -= vector[j, 1]
            z -= vector[j, 2]
        image[i, 0], image[i, 1], image[i, 2] = x, y, z
        products[0] += x * vector[i, 0]
        products[1] += y * vector[i, 1]
        products[2] += z * vector[i, 2]
    return products


@_njit
def _solve(indptr, indices, degree, right, starts, found):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Solve (degree - links) found = right for every part of the graph, rows starts[p] to starts[p + 1]."""
    for p in range(len(starts) - 1):
        first, last = starts[p], starts[p + 1]
        m = last - first
        residual, direction, image = right[first:last].copy(), np.empty((m, 3)), np.empty((m, 3))
        wanted, product = np.zeros(3), np.zeros(3)
        for i in range(m):
            for c in range(3):
                wanted[c] += residual[i, c] * residual[i, c]
                direction[i, c] = residual[i, c] / degree[first + i]
                product[c] += residual[i, c] * direction[i, c]
        wanted *= ACCURACY * ACCURACY
        for _ in range(MOST_STEPS):
            if product[0] + product[1] + product[2] == 0.0:
                break
            curvature = _multiply(indptr, indices, degree, first, direction, image)
            step = np.zeros(3)
            for c in range(3):
                step[c] = product[c] / curvature[c] if curvature[c] > 0.0 else 0.0
            left, after = np.zeros(3), np.zeros(3)
            for i in range(m):
                for c in range(3):
                    found[first + i, c] += step[c] * direction[i, c]
                    residual[i, c] -= step[c] * image[i, c]
                    left[c] += residual[i, c] * residual[i, c]
                    after[c] += residual[i, c] * residual[i, c] / degree[first + i]
            if left[0] <= wanted[0] and left[1] <= wanted[1] and left[2] <= wanted[2]:
                break
            turn = np.zeros(3)
            for c in range(3):
                turn[c] = after[c] / product[c] if product[c] > 0.0 else 0.0
                product[c] = after[c]
            for i in range(m):
                for c in range(3):
                    direction[i, c] = residual[i, c] / degree[first + i] + turn[c] * direction[i, c]
