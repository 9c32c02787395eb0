"""A patch of hexahedra whose inner nodes may move, and how good it is.

Place in the flow: :mod:`cadsweep.smoothing.ladder` cuts patches out of a swept mesh and decides
what is kept; :mod:`.laplacian` and :mod:`.optimise` move their nodes.

Each hexahedron has wanted edge lengths, and being as long as wanted counts as undistorted: what is put
right are its angles, so graded layers stay graded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..cells import AXIS_EDGES
from ..quality import measure_hexes, positive_inside

BoolArray = npt.NDArray[np.bool_]


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
        Scaled Jacobian that each hexahedron should reach; not positive where nothing is asked of it.
    projectors : (f, 3, 3) float64 or None
        What of a movement each free node can follow, where some may move on faces alone.
    snap : callable or None
        Brings all points (n, 3) back to these faces.
    """

    points: FloatArray
    hexes: IntArray
    free: BoolArray
    lengths: FloatArray
    goals: FloatArray
    projectors: FloatArray | None = None
    snap: Callable[[FloatArray], FloatArray] | None = None

    def allowed(self, moves: FloatArray) -> FloatArray:
        """What of movements (f, 3) the free nodes can follow."""
        return moves if self.projectors is None else np.einsum("nij,nj->ni", self.projectors, moves)

    def score(self, points: FloatArray) -> Score:
        """How good the patch is with its nodes at `points` (n, 3)."""
        values = proven_values(points, self.hexes)
        asked = self.goals > 0
        reached = np.min(values[asked] / self.goals[asked], initial=np.inf)
        return Score(worst=float(np.min(values)), reached=float(reached))

    def is_below(self, points: FloatArray, score: Score) -> BoolArray:
        """Hexahedra (m,) on whose account the patch at `points` does not beat a score."""
        values = proven_values(points, self.hexes)
        return np.asarray((values < score.worst) | ((self.goals > 0) & (values <= score.reached * self.goals)))


def edge_lengths(points: FloatArray, hexes: IntArray) -> FloatArray:
    """Mean edge length (m, 3) of every hexahedron along xi, eta and zeta."""
    result = np.empty((len(hexes), 3))
    for axis in range(3):
        total = np.zeros(len(hexes))
        for a, b in AXIS_EDGES[axis]:
            total += np.linalg.norm(points[hexes[:, b]] - points[hexes[:, a]], axis=1)
        result[:, axis] = total / 4
    return result
