"""Minimise a smooth energy of many unknowns: limited-memory BFGS on top of a Laplacian.

Place in the flow: the minimiser under :mod:`.injective` and under ``smoothing``.

Method: the two-loop recursion with the inverse of a fixed sparse matrix as its first guess of the inverse Hessian. With
a Laplacian of the mesh there, a step moves all nodes together, and their number hardly grows with the mesh. Steps are
halved until the energy falls enough (Armijo); a step into an infinite energy is halved like any other.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import FloatArray

Energy = Callable[[FloatArray], tuple[float, FloatArray]]
_MEMORY = 8
"""Steps that L-BFGS remembers; 5 to 10 are usual, more cost time and gain nothing here."""
_ARMIJO = 1e-4
"""Share of the expected descent that a step must reach; the textbook's value."""


def minimise(
    energy: Energy,
    x: FloatArray,
    solve: Callable[[FloatArray], FloatArray],
    *,
    n_steps: int,
    tolerance: float = 1e-5,
) -> tuple[FloatArray, float]:
    """Descend from `x` and return the best unknowns and their energy.

    Parameters
    ----------
    energy : callable
        Unknowns to (value, gradient).
    x : (m, d) float64
    solve : callable
        Applies the inverse of the preconditioner to an (m, d) array.
    n_steps : int
        At most.
    tolerance : float
        Stop where a step lowers the energy by less than this fraction.
    """
    value, gradient = energy(x)
    moves: list[FloatArray] = []
    turns: list[FloatArray] = []
    step = 1.0
    for _ in range(n_steps):
        direction = -_inverse_hessian_times(gradient, moves, turns, solve)
        slope = _dot(direction, gradient)
        if not slope < 0.0:
            if not moves:
                break
            moves, turns = [], []
            continue
        step = 1.0 if moves else min(1.0, 2.0 * step)
        trial, trial_value, trial_gradient = x, np.inf, gradient
        while step > 1e-10:
            trial = x + step * direction
            trial_value, trial_gradient = energy(trial)
            if trial_value <= value + _ARMIJO * step * slope:
                break
            step *= 0.5
        else:
            if not moves:
                break
            moves, turns, step = [], [], 1.0
            continue
        move, turn = trial - x, trial_gradient - gradient
        if _dot(move, turn) > 1e-12 * np.sqrt(_dot(move, move) * _dot(turn, turn)):
            moves, turns = [*moves[1 - _MEMORY :], move], [*turns[1 - _MEMORY :], turn]
        fallen = value - trial_value
        x, value, gradient = trial, trial_value, trial_gradient
        if fallen <= tolerance * abs(value):
            break
    return x, value


def _inverse_hessian_times(
    gradient: FloatArray, moves: list[FloatArray], turns: list[FloatArray], solve: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Two-loop recursion; the first guess is scaled by the last step's curvature."""
    q = gradient.copy()
    shares = []
    for move, turn in zip(reversed(moves), reversed(turns), strict=True):
        share = _dot(move, q) / _dot(move, turn)
        q -= share * turn
        shares.append(share)
    result = solve(q)
    if moves:
        result = result * (_dot(moves[-1], turns[-1]) / _dot(turns[-1], solve(turns[-1])))
    for move, turn, share in zip(moves, turns, reversed(shares), strict=True):
        result += (share - _dot(turn, result) / _dot(move, turn)) * move
    return result


def _dot(a: FloatArray, b: FloatArray) -> float:
    """Inner product without BLAS, whose threads wait for each other on a busy machine (measured: 0.8 s a step)."""
    return float(np.einsum("ij,ij->", a, b))
