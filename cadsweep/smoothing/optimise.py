"""The two optimisations of a patch: untangling, and lifting its worst corner.

Place in the flow: steps of :mod:`cadsweep.smoothing.ladder`. The energies are those of :mod:`.energy`, the minimiser
is that of :mod:`cadsweep.projection`, with a Laplacian of the patch as its first guess of the curvature.

Not handled: a patch whose fixed nodes leave no valid position; the energy then has no finite
minimum, the steps end after their iterations, and the caller keeps what is better.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..arrays import FloatArray, IntArray
from ..projection.descent import minimise
from ..threads import n_threads
from .energy import hex_energy
from .laplacian import laplacian_solver
from .patch import Patch, Score

HALVINGS = 6
"""How often the way of nodes is halved that are not good where they are brought back to faces."""

LEAST_GAIN = 0.01
"""Share of the goal by which two powers in a row must bring a patch nearer, or polishing ends."""


class MovedEnergy:
    """Energy and gradient of a patch as a function of its free coordinates, in units of the mean length."""

    def __init__(self, patch: Patch, points: FloatArray) -> None:
        self.unit = float(np.exp(np.mean(np.log(np.maximum(patch.lengths, 1e-300)))))
        self.centre = points[patch.free].mean(axis=0)
        self.x = (points - self.centre) / self.unit
        self.free = patch.free
        self.allowed = patch.allowed
        self.inverse = self.unit / np.maximum(patch.lengths, 1e-12 * np.max(patch.lengths))
        # Neighbours in different threads would write to the same nodes: every thread has its own gradient.
        threads = n_threads() if len(patch.hexes) > 4000 else 1
        self.pool = ThreadPoolExecutor(threads)  # starts its threads when they are needed, and ends them with itself
        self.pieces = np.array_split(np.arange(len(patch.hexes)), threads)
        self.hexes = patch.hexes
        self.eps, self.volume_weight, self.power, self.shape_weight = 1e-3, 0.05, 0.0, 1.0
        self.least = -np.inf

    def __call__(self, free: FloatArray) -> tuple[float, FloatArray]:
        self.x[self.free] = free

        def piece(ids: IntArray) -> tuple[float, float, FloatArray]:
            gradient = np.zeros_like(self.x)
            a, b = ids[0], ids[-1] + 1
            energy, least = hex_energy(
                self.x,
                self.hexes[a:b],
                self.free,
                self.inverse[a:b],
                gradient,
                self.eps,
                self.volume_weight,
                self.power,
                self.shape_weight,
            )
            return energy, least, gradient

        run = map if len(self.pieces) == 1 else self.pool.map
        parts = list(run(piece, self.pieces))
        energy = sum(p[0] for p in parts)
        self.least = min(p[1] for p in parts)
        gradient = parts[0][2]
        for part in parts[1:]:
            gradient += part[2]
        if not np.isfinite(energy):
            return np.inf, gradient[self.free]
        chosen = self.allowed(gradient[self.free])
        if self.power > 0:
            # A smooth maximum: the sum of high powers itself would span many orders of magnitude.
            return float(np.log(energy)) / self.power, chosen / (energy * self.power)
        return energy, chosen

    def coordinates(self, points: FloatArray) -> FloatArray:
        """Those of the free nodes at points (n, 3)."""
        return np.asarray((points[self.free] - self.centre) / self.unit)

    def positions(self, free: FloatArray) -> FloatArray:
        points = self.x * self.unit + self.centre
        points[self.free] = free * self.unit + self.centre
        return points


def untangled(patch: Patch, points: FloatArray, *, rounds: int = 12, iterations: int = 60) -> FloatArray:
    """Minimise the regularised shape energy, with a regularisation that fades as inversion does.

    Returns
    -------
    (n, 3) float64
        New positions; those of nodes that are not free are the given ones, bit for bit.
    """
    energy, solve = MovedEnergy(patch, points), solver_of(patch)
    free = energy.x[patch.free]
    energy(free)
    best, best_score = points, patch.score(points)
    settled = 0
    for _ in range(rounds):
        energy.eps = np.sqrt(1e-6 + 0.04 * min(energy.least, 0.0) ** 2)
        before = energy(free)[0]
        free, _ = minimise(energy, free, solve, n_steps=iterations)
        after = energy(free)[0]
        moved = kept(patch, points, energy.positions(free))
        score = patch.score(moved)
        free = energy.coordinates(moved)
        if score.beats(best_score):
            best, best_score = moved, score
        settled = settled + 1 if after > before * (1 - 1e-3) else 0
        if settled >= 2 or (score.worst > 0 and settled):
            break
    return best


def polished(
    patch: Patch, points: FloatArray, *, iterations: int = 120, is_over: Callable[[], bool] = lambda: False
) -> FloatArray:
    """Raise the worst corner of a valid patch: minimise a high power of one over the scaled Jacobian.

    `is_over` is asked before each power whether to end with what there is.

    Returns
    -------
    (n, 3) float64
        As for :func:`untangled`.
    """
    best, best_score = points, patch.score(points)
    energy, solve = MovedEnergy(patch, points), solver_of(patch)
    energy.eps = 1e-9
    free = energy.x[patch.free]
    energy.shape_weight = 0.05
    idle = 0
    for energy.power in (4.0, 8.0, 16.0, 32.0, 64.0):
        if is_over():
            break
        free, _ = minimise(energy, free, solve, n_steps=iterations)
        moved, score = _brought_back(patch, points, energy.positions(free), best, best_score)
        idle = 0 if score.reached > best_score.reached + LEAST_GAIN else idle + 1
        if score.worst > 0:  # brought back to curved faces, nodes may have gone too far
            free = energy.coordinates(moved)
        if score.beats(best_score):
            best, best_score = moved, score
        if best_score.reached >= 1 or idle == 2:
            break
    return best


def _brought_back(
    patch: Patch, points: FloatArray, wanted: FloatArray, best: FloatArray, best_score: Score
) -> tuple[FloatArray, Score]:
    """Wanted places with their nodes on their faces; less of the way from the best ones where hexahedra are poor so.

    Movements go along tangents: far ones leave a curved face, or pass the ends of edges, and nodes end upon each other.
    """
    moved = kept(patch, points, wanted.copy())
    score = patch.score(moved)
    if patch.snap is None or score.beats(best_score):
        return moved, score
    share, nearer = np.ones((len(points), 1)), moved
    for _ in range(HALVINGS):
        share[patch.hexes[patch.is_below(nearer, best_score)]] *= 0.5
        nearer = kept(patch, points, best + share * (wanted - best))
        value = patch.score(nearer)
        if value.beats(best_score):
            return nearer, value
    return moved, score


def solver_of(patch: Patch) -> Callable[[FloatArray], FloatArray]:
    """The Laplacian's inverse between movements that the free nodes can follow."""
    solve = laplacian_solver(patch)
    return solve if patch.projectors is None else lambda moves: patch.allowed(solve(patch.allowed(moves)))


def kept(patch: Patch, points: FloatArray, moved: FloatArray) -> FloatArray:
    """Scaling there and back rounds: nodes that are not free take their given coordinates, others go to their faces."""
    moved[~patch.free] = points[~patch.free]
    return moved if patch.snap is None else patch.snap(moved)
