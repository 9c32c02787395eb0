"""A patch of hexahedra whose inner nodes may move, and the two optimisations that move them.

Place in the flow: :mod:`cadsweep.smoothing.ladder` cuts patches out of a swept mesh and decides
what is kept.

Each hexahedron has wanted edge lengths, and being as long as wanted counts as undistorted: what is put
right are its angles, so graded layers stay graded.

Not handled: a patch whose fixed nodes leave no valid position; the energy then has no finite
minimum, the steps end after their iterations, and the caller keeps what is better.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..quality import measure_hexes, positive_inside
from ..quality.threads import n_threads
from ..topology import FloatArray, IntArray
from .descent import descended
from .energy import hex_energy

BoolArray = npt.NDArray[np.bool_]

LEAST_GAIN = 0.01
"""Share of the goal by which two powers in a row must bring a patch nearer, or polishing ends."""

EDGES = np.array(
    [
        [[0, 1], [3, 2], [4, 5], [7, 6]],
        [[0, 3], [1, 2], [4, 7], [5, 6]],
        [[0, 4], [1, 5], [2, 6], [3, 7]],
    ]
)
"""Edges of a hexahedron along xi, eta, zeta."""


@dataclass(frozen=True, kw_only=True)
class Score:
    """Worst scaled Jacobian of a patch, and the least share of its goal that a hexahedron reaches.

    They differ where a hexahedron has a bad corner of fixed nodes: its goal is what that corner allows.
    """

    worst: float
    reached: float

    def beats(self, other: Score) -> bool:
        """Whether something got better, and the worst hexahedron not worse."""
        return self.reached > other.reached and self.worst >= other.worst


def proven_values(points: FloatArray, hexes: IntArray) -> FloatArray:
    """Scaled Jacobians (m,), but not above 0 where the Jacobian is not positive everywhere inside."""
    measured = measure_hexes(points, hexes)
    values = measured.scaled_jacobian.copy()
    open_ones = np.flatnonzero((values > 0) & ~(measured.bound > 0))
    if len(open_ones):
        values[open_ones[~positive_inside(points, hexes[open_ones])[0]]] = 0.0
    return values


@dataclass(frozen=True, kw_only=True, eq=False)
class Patch:
    """Hexahedra with local node numbers.

    Attributes
    ----------
    points : (n, 3) float64
    hexes : (m, 8) int64
    free : (n,) bool
        Nodes that may move.
    lengths : (m, 3) float64
        Wanted edge lengths along xi, eta, zeta.
    goals : (m,) float64
        Scaled Jacobian that each hexahedron should reach, positive.
    """

    points: FloatArray
    hexes: IntArray
    free: BoolArray
    lengths: FloatArray
    goals: FloatArray

    def score(self, points: FloatArray) -> Score:
        """How good the patch is with its nodes at `points` (n, 3)."""
        values = proven_values(points, self.hexes)
        return Score(worst=float(np.min(values)), reached=float(np.min(values / self.goals)))


def edge_lengths(points: FloatArray, hexes: IntArray) -> FloatArray:
    """Mean edge length (m, 3) of every hexahedron along xi, eta and zeta."""
    result = np.empty((len(hexes), 3))
    for axis in range(3):
        total = np.zeros(len(hexes))
        for a, b in EDGES[axis]:
            total += np.linalg.norm(points[hexes[:, b]] - points[hexes[:, a]], axis=1)
        result[:, axis] = total / 4
    return result


class _Energy:
    """Energy and gradient of a patch as a function of its free coordinates, in units of the mean length."""

    def __init__(self, patch: Patch, points: FloatArray) -> None:
        self.unit = float(np.exp(np.mean(np.log(np.maximum(patch.lengths, 1e-300)))))
        self.centre = points[patch.free].mean(axis=0)
        self.x = (points - self.centre) / self.unit
        self.free = patch.free
        self.inverse = self.unit / np.maximum(patch.lengths, 1e-12 * np.max(patch.lengths))
        # Neighbours in different threads would write to the same nodes: every thread has its own gradient.
        threads = n_threads() if len(patch.hexes) > 4000 else 1
        self.pieces = np.array_split(np.arange(len(patch.hexes)), threads)
        self.hexes = patch.hexes
        self.eps, self.volume_weight, self.power, self.shape_weight = 1e-3, 0.05, 0.0, 1.0
        self.least = -np.inf

    def __call__(self, free: FloatArray) -> tuple[float, FloatArray]:
        self.x[self.free] = free.reshape(-1, 3)

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

        if len(self.pieces) == 1:
            parts = [piece(self.pieces[0])]
        else:
            with ThreadPoolExecutor(len(self.pieces)) as pool:
                parts = list(pool.map(piece, self.pieces))
        energy = sum(p[0] for p in parts)
        self.least = min(p[1] for p in parts)
        gradient = parts[0][2]
        for part in parts[1:]:
            gradient += part[2]
        if not np.isfinite(energy):
            return np.inf, gradient[self.free].ravel()
        flat = gradient[self.free].ravel()
        if self.power > 0:
            # A smooth maximum: the sum of high powers itself would span many orders of magnitude.
            return float(np.log(energy)) / self.power, flat / (energy * self.power)
        return energy, flat

    def positions(self, free: FloatArray) -> FloatArray:
        points = self.x * self.unit + self.centre
        points[self.free] = free.reshape(-1, 3) * self.unit + self.centre
        return points


def untangled(patch: Patch, points: FloatArray, *, rounds: int = 12, iterations: int = 60) -> FloatArray:
    """Minimise the regularised shape energy, with a regularisation that fades as inversion does.

    Returns
    -------
    (n, 3) float64
        New positions; those of nodes that are not free are the given ones, bit for bit.
    """
    energy = _Energy(patch, points)
    free = energy.x[patch.free].ravel()
    energy(free)
    best, best_score = points, patch.score(points)
    settled = 0
    for _ in range(rounds):
        energy.eps = np.sqrt(1e-6 + 0.04 * min(energy.least, 0.0) ** 2)
        before = energy(free)[0]
        free = descended(energy, free, iterations=iterations)
        after = energy(free)[0]
        moved = _kept(patch, points, energy.positions(free))
        score = patch.score(moved)
        if score.beats(best_score):
            best, best_score = moved, score
        settled = settled + 1 if after > before * (1 - 1e-3) else 0
        if settled >= 2 or (score.worst > 0 and settled):
            break
    return best


def polished(patch: Patch, points: FloatArray, *, iterations: int = 60) -> FloatArray:
    """Raise the worst corner of a valid patch: minimise a high power of one over the scaled Jacobian.

    Returns
    -------
    (n, 3) float64
        As for :func:`untangled`.
    """
    best, best_score = points, patch.score(points)
    energy = _Energy(patch, points)
    energy.eps = 1e-9
    free = energy.x[patch.free].ravel()
    energy.shape_weight = 0.05
    idle = 0
    for energy.power in (4.0, 8.0, 16.0, 32.0, 64.0):
        free = descended(energy, free, iterations=iterations)
        moved = _kept(patch, points, energy.positions(free))
        score = patch.score(moved)
        idle = 0 if score.reached > best_score.reached + LEAST_GAIN else idle + 1
        if score.beats(best_score):
            best, best_score = moved, score
        if best_score.reached >= 1 or idle == 2:
            break
    return best


def _kept(patch: Patch, points: FloatArray, moved: FloatArray) -> FloatArray:
    """Scaling there and back rounds: nodes that are not free take their given coordinates."""
    moved[~patch.free] = points[~patch.free]
    return moved
