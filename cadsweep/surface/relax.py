"""Relaxing quads on a surface: the worst corner goes up, or nothing moves.

Place in the flow: ``quads`` calls it on every unstructured cap.

Method: sweeps of Laplacian smoothing with the area-free mean of the neighbours, in the tangent
plane, brought onto the surface through its parameters. A node keeps its new place only where the
worst corner of the quads around it does not fall below a floor and below what it was; two
neighbours never move on each other's account, as moves that spoil a quad together are all undone.
"""

from __future__ import annotations

import numpy as np

from ..topology import FloatArray, IntArray, Surface

_GOOD_CORNER = 0.7
"""Corner sine above which a node may lose quality for the sake of smoothness."""
_N_SWEEPS = 12


def corner_sines(points: FloatArray, quads: IntArray, normals: FloatArray) -> FloatArray:
    """Sines (q, 4) of the corner angles of quads, seen along the nodes' normals (n, 3)."""
    corners = points[quads]
    step = np.roll(corners, -1, axis=1) - corners
    step /= np.maximum(np.linalg.norm(step, axis=2, keepdims=True), 1e-300)
    cross = np.cross(np.roll(step, 1, axis=1), step)
    return np.asarray(np.einsum("qcd,qcd->qc", cross, normals[quads]))


def relax_quads(
    surface: Surface, points: FloatArray, uv: FloatArray, quads: IntArray, *, n_fixed: int
) -> tuple[FloatArray, float]:
    """Relax quads on a surface, seen along the sweep (against the surface's outward normals).

    Parameters
    ----------
    points, uv : (n, 3), (n, 2) float64
        Nodes and their parameters; the first `n_fixed` stay.
    quads : (q, 4) int64

    Returns
    -------
    points : (n, 3) float64
    worst : float
        Least corner sine.
    """
    normals = -surface.normals(uv)
    sines = corner_sines(points, quads, normals)
    if n_fixed == len(points):
        return points, float(np.min(sines))
    neighbours = _mean_matrix(quads, len(points))
    node_worst = _least_at_nodes(sines, quads, len(points))
    for _ in range(_N_SWEEPS):
        moved = points + 0.7 * (neighbours @ points - points)
        off = moved - points
        off -= np.einsum("nd,nd->n", off, normals)[:, None] * normals
        active = np.flatnonzero(np.linalg.norm(off, axis=1) > 1e-3 * _node_sizes(points, quads))
        active = active[active >= n_fixed]
        if not len(active):
            break
        new_uv, new_points, new_normals = uv.copy(), points.copy(), normals.copy()
        new_uv[active] = _follow(surface, uv[active], off[active])
        new_points[active] = surface.evaluate(new_uv[active])
        new_normals[active] = -surface.normals(new_uv[active])
        moving = np.zeros(len(points), dtype=bool)
        moving[active] = True
        for _undo in range(20):
            trial = np.where(moving[:, None], new_points, points)
            trial_normals = np.where(moving[:, None], new_normals, normals)
            trial_sines = corner_sines(trial, quads, trial_normals)
            quad_worst = trial_sines.min(axis=1)
            before = sines.min(axis=1)
            bad = quad_worst < np.minimum(before, _GOOD_CORNER) - 1e-12
            # A quad may only fall as far as the worst of its surroundings stood before.
            bad &= quad_worst < node_worst[quads].min(axis=1) + 1e-9
            guilty = np.zeros(len(points), dtype=bool)
            guilty[quads[bad].ravel()] = True
            if not (guilty & moving).any():
                break
            moving &= ~guilty
        else:
            break
        points, normals, sines = trial, trial_normals, trial_sines
        uv = np.where(moving[:, None], new_uv, uv)
        node_worst = _least_at_nodes(sines, quads, len(points))
        if not moving.any():
            break
    return points, float(np.min(sines))


def _mean_matrix(quads: IntArray, n: int):  # type: ignore[no-untyped-def]
    """Sparse matrix of the mean over the neighbours along quad edges."""
    from scipy import sparse

    i = np.concatenate([quads.ravel(), np.roll(quads, -1, axis=1).ravel()])
    j = np.concatenate([np.roll(quads, -1, axis=1).ravel(), quads.ravel()])
    matrix = sparse.csr_matrix((np.ones(len(i)), (i, j)), shape=(n, n))
    matrix.data[:] = 1.0
    degree = np.asarray(matrix.sum(axis=1)).ravel()
    return sparse.diags(1.0 / np.maximum(degree, 1.0)) @ matrix


def _least_at_nodes(sines: FloatArray, quads: IntArray, n: int) -> FloatArray:
    worst = np.full(n, np.inf)
    np.minimum.at(worst, quads, np.broadcast_to(sines.min(axis=1)[:, None], quads.shape))
    return worst


def _node_sizes(points: FloatArray, quads: IntArray) -> FloatArray:
    sizes = np.zeros(len(points))
    step = np.linalg.norm(points[quads] - points[np.roll(quads, -1, axis=1)], axis=2)
    np.maximum.at(sizes, quads, step)
    return sizes


def _follow(surface: Surface, uv: FloatArray, off: FloatArray) -> FloatArray:
    """Parameters after a step `off` in the tangent plane, to first order."""
    by_u, by_v = surface.derivatives(uv)
    e, f, g = ((by_u**2).sum(1), (by_u * by_v).sum(1), (by_v**2).sum(1))
    a, b = (by_u * off).sum(1), (by_v * off).sum(1)
    det = e * g - f * f
    safe = det > 1e-12 * e * g
    det = np.where(safe, det, 1.0)
    step = np.stack([(a * g - b * f) / det, (b * e - a * f) / det], axis=1)
    return uv + np.where(safe[:, None], step, 0.0)
