"""An injective map of a quad mesh with a fixed boundary: unfold it, then even it out.

Place in the flow: :mod:`.target` calls it where the carried cap has poor or folded quads.

Method. Every corner of every quad is a small linear map J from an ideal rectangle, with the edge lengths of the
source's quad, to the cap. The energy ``sum (tr(J^T J) / 2 + w (1 + det^2) / 2) / chi(det)`` is least for
right angles and even sizes; ``chi = (det + sqrt(eps^2 + det^2)) / 2`` tends to det from above zero, so a folded
mesh has a finite energy, which grows without bound as eps falls (Garanzha, Kaporin, Kudryavtseva, Protais, Ray,
Sokolov, "Foldover-free maps in 50 lines of code", 2021). Once nothing is folded, p-norms of the corner energies, with p
rising and most of the weight on the angles alone (``|a| |b|`` for ``tr(J^T J) / 2``), lift the worst corners until they
are good enough. On a curved surface J is taken in the surface's own metric, quad by quad.

Not handled: a boundary that is itself folded, or crosses itself.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import scipy

from ..arrays import FloatArray, IntArray
from ..compiled import compiled
from .descent import Energy, minimise

AREA_WEIGHT = 0.1
"""w above while unfolding: how much even sizes count against right angles."""
POLISH = (0.02, 0.9)
"""w and the weight of the angles while the worst corners are lifted."""
SQUARINGS = (2, 3, 4, 5)
"""The p-norms, one after the other: p is 4, 8, 16, 32."""
WANTED = 0.6
"""Sine of a corner, of 37 degrees, that is left alone."""
_LARGE = 4000
"""Meshes of more quads are first relaxed near their bad quads alone."""
_PATIENCE = 6
"""Rounds of a tenth's gain in all, after which unfolding is given up: below that it creeps."""


def rectangles(points: FloatArray, quads: IntArray) -> FloatArray:
    """Edge lengths (q, 2) of each quad's ideal rectangle: means of its opposite edges."""
    edges = np.linalg.norm(np.roll(points[quads], -1, axis=1) - points[quads], axis=2)
    lengths = 0.5 * (edges[:, :2] + edges[:, 2:])
    return np.maximum(lengths, 1e-3 * lengths.mean())


def relax_plane(
    y: FloatArray,
    quads: IntArray,
    fixed: IntArray,
    *,
    lengths: FloatArray,
    metric: FloatArray | None = None,
    wanted: float = WANTED,
    n_rounds: int = 40,
) -> FloatArray:
    """Move the nodes that are not `fixed` until no quad is folded and the worst corners are as good as they get.

    Parameters
    ----------
    y : (n, 2) float64
        Plane coordinates.
    quads : (q, 4) int64
        Counter-clockwise.
    fixed : int64 array
    lengths : (q, 2) float64
        Edge lengths of the ideal rectangles, in any unit.
    metric : (q, 2, 2) float64, optional
        Per quad the matrix that takes plane steps to steps on the surface.
    wanted : float
        Sine of the worst corner (between nodes of which one may move) that is good enough.
    n_rounds : int
        Rounds of unfolding, at most.

    Returns
    -------
    (n, 2) float64
    """
    free = np.zeros(len(y), dtype=bool)
    free[quads] = True
    free[fixed] = False
    metrics = np.broadcast_to(np.eye(2), (len(quads), 2, 2)) if metric is None else metric
    metrics = np.ascontiguousarray(metrics)
    # Areas of ideal rectangles add up to the area there is, whatever the unit.
    area = abs(float(_signed_areas(y, quads, metrics).sum()))
    ideal = lengths * np.sqrt(area / np.prod(lengths, axis=1).sum()) if area > 0.0 else lengths
    ideal = np.ascontiguousarray(ideal)
    best, sines = y, _sines(y, quads, metrics, ~free)
    for reach in (8, 32, None) if len(quads) > _LARGE else (None,):
        if not free.any() or float(np.min(sines)) >= wanted:
            break
        near = free if reach is None else free & _within(sines < wanted, quads, len(y), reach)
        touched = near[quads].any(axis=1)
        nodes, local = np.unique(quads[touched], return_inverse=True)
        trial = best.copy()
        trial[nodes] = _relax_all(
            best[nodes],
            np.ascontiguousarray(local.reshape(-1, 4)),
            np.flatnonzero(near[nodes]),
            ideal=ideal[touched],
            metrics=metrics[touched],
            wanted=wanted,
            n_rounds=n_rounds,
        )
        found = _sines(trial, quads, metrics, ~free)
        if float(np.min(found)) > float(np.min(sines)):
            best, sines = trial, found
    return best


def _within(bad: npt.NDArray[np.bool_], quads: IntArray, n_nodes: int, reach: int) -> npt.NDArray[np.bool_]:
    """Nodes (n,) at most `reach` quads away from the `bad` ones (q,)."""
    near = np.zeros(n_nodes, dtype=bool)
    near[quads[bad]] = True
    for _ in range(reach):
        near[quads[near[quads].any(axis=1)]] = True
    return near


def _relax_all(
    y: FloatArray,
    quads: IntArray,
    free: IntArray,
    *,
    ideal: FloatArray,
    metrics: FloatArray,
    wanted: float,
    n_rounds: int,
) -> FloatArray:
    """Unfold where something is folded, then lift the worst corners until they are `wanted`."""
    solve = _laplacian_solver(quads, free, len(y))
    moved = y.copy()
    fixed_mask = np.ones(len(y), dtype=bool)
    fixed_mask[free] = False

    def unfolding(eps: float) -> Energy:
        def energy(x: FloatArray) -> tuple[float, FloatArray]:
            moved[free] = x
            gradient = np.zeros_like(moved)
            value = _corner_energies(moved, quads, ideal, metrics, eps, AREA_WEIGHT, 0.0, 0, gradient)
            return value, gradient[free]

        return energy

    def lifting(squarings: int) -> Energy:
        power = 2.0**squarings

        def energy(x: FloatArray) -> tuple[float, FloatArray]:
            moved[free] = x
            gradient = np.zeros_like(moved)
            value = _corner_energies(moved, quads, ideal, metrics, 0.0, *POLISH, squarings, gradient)
            norm = value ** (1.0 / power)
            return norm, gradient[free] * (norm / (value * power) if np.isfinite(value) else 0.0)

        return energy

    x = y[free].copy()
    worst = _worst_determinant(moved, quads, ideal, metrics)
    history = [worst]
    for _ in range(n_rounds):
        if worst > 0.0 or is_stuck(history):
            break
        x, _ = minimise(unfolding(float(np.sqrt(1e-12 + 0.04 * worst**2))), x, solve, n_steps=30)
        moved[free] = x
        worst = _worst_determinant(moved, quads, ideal, metrics)
        history.append(worst)
    result, best = y.copy(), -np.inf
    for squarings in (None, *SQUARINGS):
        if squarings is not None:
            x, _ = minimise(lifting(squarings), x, solve, n_steps=60)
        moved[free] = x
        sine = float(np.min(_sines(moved, quads, metrics, fixed_mask)))
        if sine > best:
            result[free], best = x, sine
        if sine >= wanted or sine <= 0.0:
            break
    return result


def is_stuck(history: Sequence[float]) -> bool:
    """Whether the worst determinant, below zero, has hardly risen in the last rounds of unfolding."""
    return len(history) > _PATIENCE and history[-1] < 0.9 * history[-1 - _PATIENCE]


def _laplacian_solver(quads: IntArray, free: IntArray, n_nodes: int):  # type: ignore[no-untyped-def]
    starts, ends = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    pairs = scipy.sparse.coo_matrix((np.ones(len(starts)), (starts, ends)), shape=(n_nodes, n_nodes)).tocsr()
    pairs = pairs + pairs.T
    laplacian = (scipy.sparse.diags(np.asarray(pairs.sum(axis=1)).ravel()) - pairs).tocsr()
    system = laplacian[free][:, free].tocsc()
    factor = scipy.sparse.linalg.splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return lambda rhs: factor.solve(np.ascontiguousarray(rhs))


def _signed_areas(y: FloatArray, quads: IntArray, metrics: FloatArray) -> FloatArray:
    p = y[quads]
    a, b = p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]
    return np.asarray(0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) * np.linalg.det(metrics))


@compiled(cache=True, nogil=True, error_model="numpy")
def _worst_determinant(y, quads, ideal, metrics):  # type: ignore[no-untyped-def]  # pragma: no cover
    worst = np.inf
    for q in range(quads.shape[0]):
        det_metric = metrics[q, 0, 0] * metrics[q, 1, 1] - metrics[q, 0, 1] * metrics[q, 1, 0]
        scale = det_metric / (ideal[q, 0] * ideal[q, 1])
        for c in range(4):
            i, j, k = quads[q, c], quads[q, (c + 1) % 4], quads[q, (c + 3) % 4]
            det = (y[j, 0] - y[i, 0]) * (y[k, 1] - y[i, 1]) - (y[j, 1] - y[i, 1]) * (y[k, 0] - y[i, 0])
            worst = min(worst, det * scale)
    return worst


def _sines(y: FloatArray, quads: IntArray, metrics: FloatArray, fixed: npt.NDArray[np.bool_]) -> FloatArray:
    """Least sine (q,) of each quad's corners between three nodes of which one may move; 1 where none is."""
    sines = np.ones(len(quads))
    _quad_sines(y, quads, metrics, fixed, sines)
    return sines


@compiled(cache=True, nogil=True, error_model="numpy")
def _quad_sines(y, quads, metrics, fixed, sines):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Lower `sines` (q,) to what :func:`_sines` says."""
    for q in range(quads.shape[0]):
        m00, m01, m10, m11 = metrics[q, 0, 0], metrics[q, 0, 1], metrics[q, 1, 0], metrics[q, 1, 1]
        for c in range(4):
            i, j, k = quads[q, c], quads[q, (c + 1) % 4], quads[q, (c + 3) % 4]
            if fixed[i] and fixed[j] and fixed[k]:
                continue
            u, v = y[j, 0] - y[i, 0], y[j, 1] - y[i, 1]
            a0, a1 = m00 * u + m01 * v, m10 * u + m11 * v
            u, v = y[k, 0] - y[i, 0], y[k, 1] - y[i, 1]
            b0, b1 = m00 * u + m01 * v, m10 * u + m11 * v
            squares = (a0 * a0 + a1 * a1) * (b0 * b0 + b1 * b1)
            sine = (a0 * b1 - a1 * b0) / np.sqrt(squares) if squares > 0.0 else -1.0
            sines[q] = min(sines[q], sine)


@compiled(cache=True, nogil=True, error_model="numpy")
def _corner_energies(y, quads, ideal, metrics, eps, area_weight, angles, squarings, gradient):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Sum of the ``2**squarings``-th powers of all corner energies; adds its gradient to `gradient`.

    With a = M (y_next - y) / l_next, b = M (y_previous - y) / l_previous: J = [a b], det = a x b.
    """
    total, power = 0.0, 2.0**squarings
    for q in range(quads.shape[0]):
        m00, m01, m10, m11 = metrics[q, 0, 0], metrics[q, 0, 1], metrics[q, 1, 0], metrics[q, 1, 1]
        for c in range(4):
            i, j, k = quads[q, c], quads[q, (c + 1) % 4], quads[q, (c + 3) % 4]
            s, t = 1.0 / ideal[q, c % 2], 1.0 / ideal[q, (c + 1) % 2]
            u, v = y[j, 0] - y[i, 0], y[j, 1] - y[i, 1]
            a0, a1 = (m00 * u + m01 * v) * s, (m10 * u + m11 * v) * s
            u, v = y[k, 0] - y[i, 0], y[k, 1] - y[i, 1]
            b0, b1 = (m00 * u + m01 * v) * t, (m10 * u + m11 * v) * t
            det = a0 * b1 - a1 * b0
            root = np.sqrt(eps * eps + det * det)
            if root == 0.0 or (eps == 0.0 and det <= 0.0):
                return np.inf
            chi = 0.5 * (det + root) if det > 0.0 else 0.5 * eps * eps / (root - det)
            aa, bb = a0 * a0 + a1 * a1, b0 * b0 + b1 * b1
            product = np.sqrt(aa * bb)
            top = (1.0 - angles) * 0.5 * (aa + bb) + angles * product + area_weight * 0.5 * (1.0 + det * det)
            f = top / chi
            powered = f
            for _ in range(squarings):
                powered *= powered
            total += powered
            outer = power * powered / f
            # d chi / d det = chi / root
            d_det = outer * (area_weight * det / chi - top / (chi * root))
            d_a = outer / chi * (1.0 - angles + angles * np.sqrt(bb / aa))
            d_b = outer / chi * (1.0 - angles + angles * np.sqrt(aa / bb))
            d_a0, d_a1 = d_a * a0 + d_det * b1, d_a * a1 - d_det * b0
            d_b0, d_b1 = d_b * b0 - d_det * a1, d_b * b1 + d_det * a0
            gj0, gj1 = (m00 * d_a0 + m10 * d_a1) * s, (m01 * d_a0 + m11 * d_a1) * s
            gk0, gk1 = (m00 * d_b0 + m10 * d_b1) * t, (m01 * d_b0 + m11 * d_b1) * t
            gradient[j, 0] += gj0
            gradient[j, 1] += gj1
            gradient[k, 0] += gk0
            gradient[k, 1] += gk1
            gradient[i, 0] -= gj0 + gk0
            gradient[i, 1] -= gj1 + gk1
    return total
