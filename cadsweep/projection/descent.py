"""Minimise a smooth energy of many unknowns: limited-memory BFGS on top of a Laplacian.

Place in the flow: the minimiser under :mod:`.injective` and under ``smoothing``.

Method: the two-loop recursion with the inverse of a fixed sparse matrix as its first guess of the inverse Hessian. With
a Laplacian of the mesh there, a step moves all nodes together, and their number hardly grows with the mesh. Steps are
halved until the energy falls enough (Armijo); a step into an infinite energy is halved like any other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..compiled import compiled

_compiled = compiled(cache=True, nogil=True, error_model="numpy")

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
    steps: list[_Step] = []
    step = 1.0
    for _ in range(n_steps):
        direction = -_inverse_hessian_times(gradient, steps, solve)
        slope = _dot(direction, gradient)
        if not slope < 0.0:
            if not steps:
                break
            steps = []
            continue
        step = 1.0 if steps else min(1.0, 2.0 * step)
        trial, trial_value, trial_gradient = x, np.inf, gradient
        while step > 1e-10:
            trial = x + step * direction
            trial_value, trial_gradient = energy(trial)
            if trial_value <= value + _ARMIJO * step * slope:
                break
            step *= 0.5
        else:
            if not steps:
                break
            steps, step = [], 1.0
            continue
        move, turn = trial - x, trial_gradient - gradient
        product = _dot(move, turn)
        if product > 1e-12 * np.sqrt(_dot(move, move) * _dot(turn, turn)):
            steps = [*steps[1 - _MEMORY :], _Step(move, turn, product)]
        fallen = value - trial_value
        x, value, gradient = trial, trial_value, trial_gradient
        if fallen <= tolerance * abs(value):
            break
    return x, value


class _Step(NamedTuple):
    """How far a step moved, how much the gradient turned, and the inner product of the two."""

    move: FloatArray
    turn: FloatArray
    product: float


def _inverse_hessian_times(
    gradient: FloatArray, steps: list[_Step], solve: Callable[[FloatArray], FloatArray]
) -> FloatArray:
    """Two-loop recursion; the first guess is scaled by the last step's curvature."""
    q = gradient.copy()
    shares = []
    for move, turn, product in reversed(steps):
        share = _dot(move, q) / product
        _add_times(q, -share, turn)
        shares.append(share)
    result = np.ascontiguousarray(solve(q))
    if steps:
        last = steps[-1]
        result *= last.product / _dot(last.turn, np.ascontiguousarray(solve(last.turn)))
    for (move, turn, product), share in zip(steps, reversed(shares), strict=True):
        _add_times(result, share - _dot(turn, result) / product, move)
    return result


@_compiled
def _dot(a, b):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Inner product without BLAS, whose threads wait for each other on a busy machine (measured: 0.8 s a step)."""
    total = 0.0
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            total += a[i, j] * b[i, j]
    return total


@_compiled
def _add_times(out, factor, a):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Add `factor` times `a` in place, without an array between."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            out[i, j] += factor * a[i, j]
