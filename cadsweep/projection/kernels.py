"""Compiled loops: the product ``basis @ coefficients[k]`` at the speed of memory, and sums over rings.

Place in the flow: :func:`pack` and :func:`place` serve :meth:`FactoredSweep.points`, the sums over rings
:mod:`.fitting`.

Method. :func:`place` does ``out[k] = basis @ coefficients[k]; out[k, ring_nodes] = rings[k]``. A general matrix product
wastes most of its time on three columns, so the loop is written out: nodes in blocks whose columns lie one after the
other, four columns at a time, a few layers for each block while it is in the nearest cache. Layers are shared among
threads; every node of every layer is summed in the same order, so the bits do not depend on their number.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..arrays import FloatArray, IntArray
from ..compiled import compiled
from ..threads import n_threads

_BLOCK = 128
"""Nodes of a block: a kilobyte a column, so the columns of a block stay in the first cache."""
_LAYERS = 8
"""Layers of a run at least: the modes that are read once serve all of them."""
_RUN_NODES = 40_000
"""A run has `_LAYERS` layers, or more of small ones: about a megabyte, which the second cache holds."""
_ENOUGH_NODES = 200_000
"""Below this many nodes starting threads costs more than they save."""


def pack(basis: FloatArray) -> FloatArray:
    """Lay out a basis (n, r) for :func:`place`: (n_blocks, columns * block), columns padded to a multiple of four."""
    n, r = basis.shape
    n_blocks, columns = -(-n // _BLOCK), 4 * -(-r // 4)
    packed = np.zeros((n_blocks, columns, _BLOCK))
    full = n // _BLOCK
    packed[:full, :r] = basis[: full * _BLOCK].reshape(full, _BLOCK, r).transpose(0, 2, 1)
    if full < n_blocks:
        packed[-1, :r, : n - full * _BLOCK] = basis[full * _BLOCK :].T
    return packed.reshape(n_blocks, -1)


def place(
    packed: FloatArray, coefficients: FloatArray, ring_nodes: IntArray, rings: FloatArray, out: FloatArray
) -> None:
    """Fill contiguous `out` (K, n, 3) from a packed basis, coefficients (K, r, 3) and rings (K, b, 3)."""
    n_layers, r, _ = coefficients.shape
    padded = np.zeros((n_layers, 4 * -(-r // 4), 3))
    padded[:, :r] = coefficients

    def work(run: slice) -> None:
        _place(packed, padded[run], ring_nodes, rings[run], out[run])

    share_layers(work, n_layers, out.shape[1])


def share_layers(work: Callable[[slice], None], n_layers: int, n_nodes: int) -> None:
    """Call ``work(run)`` for runs of a few layers of `n_nodes` nodes, on several threads where that pays."""
    step = max(_LAYERS, _RUN_NODES // n_nodes)
    runs = [slice(k, min(k + step, n_layers)) for k in range(0, n_layers, step)]
    threads = min(n_threads(), len(runs)) if n_layers * n_nodes >= _ENOUGH_NODES else 1
    if threads == 1:
        for run in runs:
            work(run)
        return
    with ThreadPoolExecutor(threads, thread_name_prefix="layers") as pool:
        for _ in pool.map(work, runs):
            pass


# Contraction lets a multiplication and an addition be one instruction; it changes no order of summation.
@compiled(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _place(packed, coefficients, ring_nodes, rings, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    n = out.shape[1]
    sums = np.empty(3 * _BLOCK)
    for block in range(packed.shape[0]):
        start = block * _BLOCK
        m = min(_BLOCK, n - start)
        columns = packed[block]
        for k in range(out.shape[0]):
            for g in range(0, coefficients.shape[1], 4):
                a = coefficients[k, g : g + 4]
                b = columns[g * _BLOCK : (g + 4) * _BLOCK]
                x0, x1, x2, x3 = a[0, 0], a[1, 0], a[2, 0], a[3, 0]
                y0, y1, y2, y3 = a[0, 1], a[1, 1], a[2, 1], a[3, 1]
                z0, z1, z2, z3 = a[0, 2], a[1, 2], a[2, 2], a[3, 2]
                if g == 0:
                    for i in range(_BLOCK):
                        b0, b1, b2, b3 = b[i], b[i + _BLOCK], b[i + 2 * _BLOCK], b[i + 3 * _BLOCK]
                        sums[i] = b0 * x0 + b1 * x1 + b2 * x2 + b3 * x3
                        sums[i + _BLOCK] = b0 * y0 + b1 * y1 + b2 * y2 + b3 * y3
                        sums[i + 2 * _BLOCK] = b0 * z0 + b1 * z1 + b2 * z2 + b3 * z3
                else:
                    for i in range(_BLOCK):
                        b0, b1, b2, b3 = b[i], b[i + _BLOCK], b[i + 2 * _BLOCK], b[i + 3 * _BLOCK]
                        sums[i] += b0 * x0 + b1 * x1 + b2 * x2 + b3 * x3
                        sums[i + _BLOCK] += b0 * y0 + b1 * y1 + b2 * y2 + b3 * y3
                        sums[i + 2 * _BLOCK] += b0 * z0 + b1 * z1 + b2 * z2 + b3 * z3
            rows = out[k, start : start + m]
            for i in range(m):
                rows[i, 0] = sums[i]
                rows[i, 1] = sums[i + _BLOCK]
                rows[i, 2] = sums[i + 2 * _BLOCK]
    for k in range(out.shape[0]):
        for j in range(ring_nodes.shape[0]):
            i = ring_nodes[j]
            for c in range(3):
                out[k, i, c] = rings[k, j, c]


# Sums may be taken in any order here: they are of like sizes, and nothing is promised bit for bit.
@compiled(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def loop_sums(rings, bounds, projector, centers, grams, turns, products):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """For loop j, rows ``bounds[j]:bounds[j + 1]`` of rings (K, m, n), with x the nodes about their mean.

    centers[k, j] = mean, grams[k, j] = ``sum x_i (x) x_i``, turns[k, j] = ``sum x_i (x) x_(i+1)``, all of one loop, and
    products[k] += ``projector x`` over all.
    """
    n = rings.shape[2]
    local = np.empty((n, rings.shape[1]))
    for k in range(rings.shape[0]):
        for j in range(len(bounds) - 1):
            first, m = bounds[j], bounds[j + 1] - bounds[j]
            for c in range(n):
                total = 0.0
                for i in range(m):
                    total += rings[k, first + i, c]
                center = total / m
                centers[k, j, c] = center
                for i in range(m):
                    local[c, i] = rings[k, first + i, c] - center
            for c in range(n):
                for d in range(n):
                    a, b = local[c], local[d]
                    same, turn = a[m - 1] * b[m - 1], a[m - 1] * b[0]
                    for i in range(m - 1):
                        same += a[i] * b[i]
                        turn += a[i] * b[i + 1]
                    grams[k, j, c, d], turns[k, j, c, d] = same, turn
                for p in range(projector.shape[0]):
                    row, a = projector[p, first : first + m], local[c]
                    total = 0.0
                    for i in range(m):
                        total += row[i] * a[i]
                    products[k, p, c] += total


@compiled(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def gram_matrices(rings, centers, grams):  # type: ignore[no-untyped-def]  # pragma: no cover
    """``(ring - center)^T (ring - center)`` of rings (K, m, n) about centers (K, n), into grams (K, n, n)."""
    n = rings.shape[2]
    for k in range(rings.shape[0]):
        for c in range(n):
            for d in range(c + 1):
                at, bt = centers[k, c], centers[k, d]
                total = 0.0
                for i in range(rings.shape[1]):
                    total += (rings[k, i, c] - at) * (rings[k, i, d] - bt)
                grams[k, c, d] = grams[k, d, c] = total


@compiled(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc", "nsz"})
def turned_products(rings, centers, first, stop, turns, turned, crossed):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """For first <= k < stop, Z the ring before k, centred and turned by turns[k]: ``Z^T Z``, ``Z^T (ring - c)``."""
    m, n = rings.shape[1], rings.shape[2]
    X, Y, Z = np.empty((n, m)), np.empty((n, m)), np.empty((n, m))
    for k in range(max(first - 1, 0), stop):
        for c in range(n):
            for i in range(m):
                Y[c, i] = rings[k, i, c] - centers[k, c]
        if k < first:
            X, Y = Y, X
            continue
        if k == 0:
            X[:] = Y
        for c in range(n):
            z, t0, t1, x0, x1 = Z[c], turns[k, 0, c], turns[k, 1, c], X[0], X[1]
            for i in range(m):
                z[i] = t0 * x0[i] + t1 * x1[i]
            for d in range(2, n):
                t2, x2 = turns[k, d, c], X[d]
                for i in range(m):
                    z[i] += t2 * x2[i]
        for c in range(n):
            for d in range(n):
                z, same, other = Z[c], Z[d], Y[d]
                total, cross = 0.0, 0.0
                for i in range(m):
                    total += z[i] * same[i]
                    cross += z[i] * other[i]
                turned[k, c, d], crossed[k, c, d] = total, cross
        X, Y = Y, X
