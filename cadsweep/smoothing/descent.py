"""Limited-memory BFGS with backtracking, for energies that are infinite beyond a barrier.

Place in the flow: the optimiser of :mod:`cadsweep.smoothing.patch`.

scipy's L-BFGS-B interpolates between the values at both ends of a step; where one end lies beyond
the barrier, the step shrinks to nothing and it reports convergence (measured: one iteration on every
polish). Halving the step until the energy falls needs no value there.

References
----------
Nocedal, Wright, "Numerical Optimization", algorithms 3.1 and 7.4.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from ..topology import FloatArray

MEMORY = 12
LEAST_DECREASE = 1e-4
MOST_HALVINGS = 30


def descended(
    energy: Callable[[FloatArray], tuple[float, FloatArray]],
    start: FloatArray,
    *,
    iterations: int,
    longest_step: float = 0.5,
    tolerance: float = 1e-5,
) -> FloatArray:
    """Lower an energy from a place where it is finite.

    Parameters
    ----------
    energy : callable
        Value (``inf`` where it has none) and gradient at x (n,).
    start : (n,) float64
    iterations : int
    longest_step : float
        Largest change of one coordinate in one step.
    tolerance : float
        Ends after three steps in a row that lower the energy by a smaller fraction.
    """
    x = start.copy()
    value, gradient = energy(x)
    history: deque[tuple[FloatArray, FloatArray, float]] = deque(maxlen=MEMORY)
    idle = 0
    for _ in range(iterations):
        direction = _direction(gradient, history)
        slope = _dot(direction, gradient)
        if not slope < 0:
            history.clear()
            direction, slope = -gradient, -_dot(gradient, gradient)
            if slope == 0:
                break
        largest = float(np.max(np.abs(direction)))
        step = min(1.0, longest_step / largest)
        if not history:
            step = min(step, 0.01 / largest)
        for _ in range(MOST_HALVINGS):
            trial = x + step * direction
            new_value, new_gradient = energy(trial)
            if new_value <= value + LEAST_DECREASE * step * slope:
                break
            step *= 0.5
        else:
            if not history:
                break
            history.clear()  # the model of the curvature has gone wrong: once more along the gradient
            continue
        change, turn = trial - x, new_gradient - gradient
        product = _dot(change, turn)
        if product > 1e-10 * np.sqrt(_dot(change, change) * _dot(turn, turn)):
            history.append((change, turn, product))
        idle = idle + 1 if value - new_value < tolerance * abs(value) else 0
        x, value, gradient = trial, new_value, new_gradient
        if idle >= 3:
            break
    return x


def _direction(gradient: FloatArray, history: deque[tuple[FloatArray, FloatArray, float]]) -> FloatArray:
    """The two-loop recursion: minus the inverse Hessian's model times the gradient."""
    q = gradient.copy()
    factors = []
    for change, turn, product in reversed(history):
        factor = _dot(change, q) / product
        factors.append(factor)
        q -= factor * turn
    if history:
        _, turn, product = history[-1]
        q *= product / _dot(turn, turn)
    for (change, turn, product), factor in zip(history, reversed(factors), strict=True):
        q += (factor - _dot(turn, q) / product) * change
    return -q


def _dot(a: FloatArray, b: FloatArray) -> float:
    """Inner product without BLAS, whose threads wait for each other on a busy machine."""
    return float(np.einsum("i,i->", a, b))
