"""Rational B-splines as arrays: points and derivatives of any number of parameters.

Place in the flow: ``curves`` and ``surfaces`` use these evaluators, because a call into
OpenCASCADE for every point costs more than the mesh. The loops are in ``spline_kernels``.

A curve or surface with a period has clamped knots of one turn, and its parameters are brought into them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from .spline_kernels import (
    arc_lengths,
    arc_parameters,
    arc_table,
    curve_derivatives,
    nearest_parameters,
    surface_derivatives,
)

_MOST_ROUNDS = 30
"""Rounds of a search for the nearest point."""


@dataclass(frozen=True, kw_only=True, eq=False)
class BSpline:
    """A clamped, possibly rational B-spline curve in any dimension.

    Attributes
    ----------
    degree : int
    knots : (n + degree + 1,) float64
        With repetitions.
    poles : (n, d) float64
    weights : (n,) float64 or None
    """

    degree: int
    knots: FloatArray
    poles: FloatArray
    weights: FloatArray | None = None

    @property
    def breaks(self) -> FloatArray:
        """Distinct knots: between two of them the curve is smooth."""
        return self.knots[np.append(True, self.knots[1:] > self.knots[:-1])]

    @cached_property
    def arrays(self) -> tuple[FloatArray, FloatArray]:
        """Knots, and poles, homogeneous where there are weights."""
        poles = self.poles
        if self.weights is not None:
            poles = np.column_stack([poles * self.weights[:, None], self.weights])
        return _packed(self.knots), _packed(poles)

    def derivatives(self, parameters: FloatArray, order: int = 0, *, period: float = 0.0) -> list[FloatArray]:
        """Points and derivatives up to `order` (0, 1 or 2), each (m, d); with a `period` also beyond the knots."""
        knots, poles = self.arrays
        out = np.empty((order + 1, len(parameters), self.poles.shape[1]))
        curve_derivatives(knots, self.degree, poles, period, _packed(parameters), out)
        return list(out)

    def arc_lengths(self, lower: FloatArray, upper: FloatArray, rule: FloatArray, *, period: float = 0.0) -> FloatArray:
        """Arc lengths (m,) from `lower` to `upper`, by a quadrature `rule` (2, k): nodes and weights on 0 to 1."""
        knots, poles = self.arrays
        lower, upper = np.broadcast_arrays(lower, upper)
        out = np.empty(len(lower))
        arc_lengths(knots, self.degree, poles, period, self.poles.shape[1], rule, _packed(lower), _packed(upper), out)
        return out

    def arc_table(
        self, stops: FloatArray, rule: FloatArray, *, halvings: int, same: float, period: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Interval ends, and the arc length from the first to each of them; smooth between `stops`.

        Intervals are halved at most so many times, until the lengths of their halves add up to theirs but for a share
        `same` of the whole.
        """
        knots, poles = self.arrays
        limits = np.array([halvings, same])
        ends, lengths = arc_table(knots, self.degree, poles, period, self.poles.shape[1], rule, _packed(stops), limits)
        return ends, lengths

    def arc_parameters(
        self, table: tuple[FloatArray, FloatArray], wanted: FloatArray, rule: FloatArray, *, period: float = 0.0
    ) -> FloatArray:
        """Parameters (m,) at arc lengths (m,), by a table of interval ends and the lengths up to them."""
        knots, poles = self.arrays
        out = np.empty(len(wanted))
        arc_parameters(knots, self.degree, poles, period, self.poles.shape[1], rule, *table, _packed(wanted), out)
        return out

    def nearest(
        self, samples: tuple[FloatArray, FloatArray], points: FloatArray, *, enough: float, period: float = 0.0
    ) -> FloatArray:
        """Parameters (m,) nearest to points (m, d), looked for beside the nearest of samples: parameters and places.

        The search ends where it moves by no more than `enough`.
        """
        knots, poles = self.arrays
        out = np.empty(len(points))
        limits = np.array([_MOST_ROUNDS, enough])
        nearest_parameters(
            knots, self.degree, poles, period, self.poles.shape[1], *samples, _packed(points), limits, out
        )
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class BSplineSurface:
    """A clamped, possibly rational tensor-product B-spline surface in space.

    Attributes
    ----------
    degrees : (int, int)
    u_knots, v_knots : float64 arrays
        With repetitions.
    poles : (n_u, n_v, 3) float64
    weights : (n_u, n_v) float64 or None
    """

    degrees: tuple[int, int]
    u_knots: FloatArray
    v_knots: FloatArray
    poles: FloatArray
    weights: FloatArray | None = None

    @cached_property
    def arrays(self) -> tuple[FloatArray, FloatArray, int, int, FloatArray]:
        """Knots and degrees in u and v, and homogeneous poles (n_u, n_v, 4), as the compiled loops take them."""
        weights = np.ones(self.poles.shape[:2]) if self.weights is None else self.weights
        poles = np.concatenate([self.poles * weights[..., None], weights[..., None]], axis=2)
        return _packed(self.u_knots), _packed(self.v_knots), *self.degrees, _packed(poles)

    def evaluate(self, uv: FloatArray, *, periods: FloatArray | None = None) -> FloatArray:
        """Points (m, 3) at the parameters (m, 2); `periods` (2,) where the surface goes on beyond its knots, else 0."""
        return self._partials(uv, 1, periods)[0]

    def evaluate_grid(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Points (m, n, 3) at all pairs of parameters `u` (m,) and `v` (n,)."""
        uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)
        return self.evaluate(uv.reshape(-1, 2)).reshape(len(u), len(v), 3)

    def derivatives(
        self, uv: FloatArray, *, periods: FloatArray | None = None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives by u and v, each (m, 3)."""
        point, by_u, by_v = self._partials(uv, 3, periods)
        return point, by_u, by_v

    def _partials(self, uv: FloatArray, n: int, periods: FloatArray | None) -> FloatArray:
        out = np.empty((n, len(uv), 3))
        surface_derivatives(*self.arrays, _NO_PERIODS if periods is None else periods, _packed(uv), out)
        return out


_NO_PERIODS = np.zeros(2)


def _packed(values: FloatArray) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64)
