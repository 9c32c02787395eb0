"""Edges' curves by arc length, in numpy alone.

Place in the flow: ``extract`` turns the curves of OpenCASCADE into these, and ``brep.Edge.curve``
holds an :class:`EdgeCurve`.

Method: lines and circles have constant speed. For other curves the arc length is integrated by
Gauss-Legendre quadrature on intervals that are halved until two orders agree to 1e-13 of the
length, and inverted by Newton's method from a table.

Not handled: curves whose speed vanishes over an interval.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from ...arrays import FloatArray
from .nearest_kernels import nearest_rows
from .nurbs import BSpline
from .parametric import Ellipse, Line, Parametric, Periodic
from .records import curve_record

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_NODES, _WEIGHTS = (_NODES + 1) / 2, _WEIGHTS / 2
_RULE: FloatArray = np.stack([_NODES, _WEIGHTS])
_RECENT = 4
"""Questions for parameters that a curve keeps the answers of."""
_MAX_HALVINGS = 12
"""Halvings of an interval: a speed that 4,096 pieces do not resolve is not smooth."""
_MOST_STEPS = 20
"""Newton steps to the parameter at an arc length."""
_SAME = 1e-13
"""Share of the length up to which an interval's is the sum of its halves'."""
_FEW = 200_000
"""Pairs of a point and a sample up to which all are compared: a tree would take longer to be made."""
_HOOK = 1e-3
"""Share of an edge's length at its ends in which a turn is no feature of the part."""
_STRAIGHT = 0.05
"""Radians by which the edge may turn beside a hook."""


_HOOK_SHARES = _HOOK * np.array([1.0, 3.0, 10.0])
END_FRACTIONS = np.concatenate([[0.0, 1.0], _HOOK_SHARES, 1.0 - _HOOK_SHARES])
"""Both ends of an edge, and three places near each that :func:`unhooked` looks at."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeCurve:
    """A parametric curve between two parameters, run through by arc length.

    Attributes
    ----------
    geometry : Parametric
    first, last : float
        Parameters at the edge's start and end, ``first < last``.
    breaks : float64 array
        Parameters where the curve may be less than smooth.
    constant_speed : bool
        Arc length is proportional to the parameter (lines and circles).
    """

    geometry: Parametric
    first: float
    last: float
    breaks: FloatArray = field(default_factory=lambda: np.empty(0))
    constant_speed: bool = False

    @cached_property
    def record(self) -> FloatArray | None:
        """The curve as compiled loops take it (:mod:`.records`); None where it has no record."""
        return curve_record(self.geometry)

    @cached_property
    def _table(self) -> tuple[FloatArray, FloatArray]:
        """Interval ends, and the arc length from the start to each of them."""
        inner = self.breaks[(self.breaks > self.first) & (self.breaks < self.last)]
        ends = np.concatenate([[self.first], inner, [self.last]])
        if self._spline is not None:
            spline, period = self._spline
            return spline.arc_table(ends, _RULE, halvings=_MAX_HALVINGS, same=_SAME, period=period)
        ends = np.concatenate([np.linspace(a, b, 3)[:-1] for a, b in pairwise(ends)] + [[ends[-1]]])
        for _ in range(_MAX_HALVINGS):
            middles = (ends[:-1] + ends[1:]) / 2
            whole = self._integrate(ends[:-1], ends[1:])
            halves = self._integrate(ends[:-1], middles) + self._integrate(middles, ends[1:])
            coarse = np.abs(whole - halves) > _SAME * halves.sum()
            if not coarse.any():
                break
            ends = np.sort(np.concatenate([ends, middles[coarse]]))
        lengths = self._integrate(ends[:-1], ends[1:])
        return ends, np.concatenate([[0.0], np.cumsum(lengths)])

    def _speed(self, parameters: FloatArray) -> FloatArray:
        return np.linalg.norm(self.geometry.derivatives(parameters, 1)[1], axis=1)

    @cached_property
    def _spline(self) -> tuple[BSpline, float] | None:
        """The spline whose arc length compiled loops know, and its period (0: none)."""
        if isinstance(self.geometry, Periodic):
            return self.geometry.spline, self.geometry.period
        return (self.geometry, 0.0) if isinstance(self.geometry, BSpline) else None

    def _integrate(self, lower: FloatArray, upper: FloatArray) -> FloatArray:
        if self._spline is not None:
            spline, period = self._spline
            return spline.arc_lengths(lower, upper, _RULE, period=period)
        width = upper - lower
        at = lower[:, None] + width[:, None] * _NODES
        speed = self._speed(at.ravel()).reshape(at.shape)
        return width * (speed @ _WEIGHTS)

    @cached_property
    def length(self) -> float:
        """Arc length."""
        if self.constant_speed:
            return float(self._speed(np.array([self.first]))[0]) * (self.last - self.first)
        return float(self._table[1][-1])

    def parameters(self, fractions: FloatArray) -> FloatArray:
        """The curve's own parameters (m,) at arc-length fractions (m,)."""
        fractions = np.atleast_1d(np.asarray(fractions, dtype=float))
        if self.constant_speed:
            # Written so that 0 and 1 give the ends exactly.
            return self.first * (1.0 - fractions) + self.last * fractions
        # Both faces of an edge, and the edge itself, are asked for the same nodes one after the other.
        key = fractions.tobytes()
        found = self._recent.get(key)
        if found is None:
            while len(self._recent) >= _RECENT:
                del self._recent[next(iter(self._recent))]
            found = self._recent[key] = self._parameters(fractions)
            found.setflags(write=False)
        return found

    @cached_property
    def _recent(self) -> dict[bytes, FloatArray]:
        """Parameters by fractions, of the last few questions."""
        return {}

    def _parameters(self, fractions: FloatArray) -> FloatArray:
        """:meth:`parameters` of a curve that is not of constant speed."""
        ends, lengths = self._table
        total = lengths[-1]
        wanted = fractions * total
        if self._spline is not None:
            spline, period = self._spline
            t = spline.arc_parameters((ends, lengths), wanted, _RULE, period=period)
            return np.where(fractions >= 1, self.last, np.where(fractions <= 0, self.first, t))
        k = np.clip(np.searchsorted(lengths, wanted, side="right") - 1, 0, len(ends) - 2)
        width = lengths[k + 1] - lengths[k]
        width = np.where(width > 0, width, 1.0)
        t = ends[k] + (ends[k + 1] - ends[k]) * (wanted - lengths[k]) / width
        earlier = t
        for step in range(_MOST_STEPS):
            miss = lengths[k] + self._integrate(ends[k], t) - wanted
            if np.abs(miss).max(initial=0.0) <= 4e-16 * total:
                break
            speed = self._speed(t)
            speed = np.where(speed > 0, speed, total / (self.last - self.first))
            moved = np.clip(t - miss / speed, ends[k], ends[k + 1])
            if np.array_equal(moved, earlier):  # rounding goes back and forth between these two until the last step
                t = t if (_MOST_STEPS - step) % 2 == 0 else moved
                break
            earlier, t = t, moved
        t = np.where(fractions <= 0, self.first, t)
        return np.where(fractions >= 1, self.last, t)

    def fractions(self, parameters: FloatArray) -> FloatArray:
        """Arc-length fractions (m,) at the curve's own parameters (m,)."""
        if self.constant_speed:
            return (parameters - self.first) / (self.last - self.first)
        ends, lengths = self._table
        k = np.clip(np.searchsorted(ends, parameters, side="right") - 1, 0, len(ends) - 2)
        return (lengths[k] + self._integrate(ends[k], parameters)) / lengths[-1]

    def evaluate(self, fractions: FloatArray) -> FloatArray:
        """Points (m, 3) at arc-length fractions (m,)."""
        return self.geometry.derivatives(self.parameters(fractions))[0]

    def tangents(self, fractions: FloatArray) -> FloatArray:
        """Unit tangents (m, 3) at arc-length fractions (m,), in the direction start to end."""
        return self.frames(fractions)[2]

    def frames(self, fractions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The curve's own parameters (m,), points and unit tangents, each (m, 3), at arc-length fractions (m,).

        Where the speed vanishes (a cusp of the parametrisation) the chord to a point nearby stands in.
        """
        fractions = np.atleast_1d(np.asarray(fractions, dtype=float))
        parameters = self.parameters(fractions)
        points, tangents = self.geometry.derivatives(parameters, 1)
        norms = np.linalg.norm(tangents, axis=1)
        mean_speed = self.length / (self.last - self.first)
        for j in np.flatnonzero(norms <= 1e-9 * mean_speed):
            pair = self.evaluate(np.clip([fractions[j] - 1e-4, fractions[j] + 1e-4], 0.0, 1.0))
            tangents = np.array(tangents)
            tangents[j] = pair[1] - pair[0]
            norms[j] = np.linalg.norm(tangents[j])
        return parameters, points, tangents / np.where(norms > 0, norms, 1.0)[:, None]

    @cached_property
    def end_tangents(self) -> FloatArray:
        """Unit tangents (2, 3) at the start and the end, in the direction start to end.

        Intersection curves may end in hooks much smaller than any detail of the part, which are left out.
        """
        _, points, tangents = self.frames(END_FRACTIONS)
        return unhooked([self], tangents[None, :2], points[None, 2:])[0]

    @cached_property
    def _samples(self) -> tuple[FloatArray, FloatArray]:
        """Parameters about evenly along the edge, and the places there: where a search for the nearest point begins."""
        if self.constant_speed:
            parameters = np.linspace(self.first, self.last, 65)
        else:
            ends, lengths = self._table
            n = min(max(65, 8 * len(ends)), 2049)
            parameters = np.interp(np.linspace(0.0, lengths[-1], n), lengths, ends)
        return parameters, self.geometry.derivatives(parameters)[0]

    @cached_property
    def _tree(self) -> Any:
        """A tree of the samples' places."""
        from scipy.spatial import cKDTree  # half a second, which a part of straight edges need not wait for

        return cKDTree(self._samples[1])

    def project(self, points: FloatArray) -> FloatArray:
        """Arc-length fractions (m,) of the points of the edge nearest to `points` (m, 3)."""
        return np.clip(self.fractions(self._nearest_parameters(points)), 0.0, 1.0)

    def nearest(self, points: FloatArray) -> FloatArray:
        """Places (m, 3) of the edge nearest to `points` (m, 3)."""
        return self.geometry.derivatives(self._nearest_parameters(points))[0]

    def distance(self, points: FloatArray) -> FloatArray:
        """Distances (m,) of `points` (m, 3) from the edge, its ends included."""
        return np.linalg.norm(self.nearest(points) - points, axis=1)

    def _nearest_parameters(self, points: FloatArray) -> FloatArray:
        """The curve's own parameters (m,) nearest to `points` (m, 3)."""
        points = np.atleast_2d(np.asarray(points, dtype=float))
        if isinstance(self.geometry, Line):
            d = self.geometry.direction
            t = (points - self.geometry.origin) @ d / (d @ d)
            return np.clip(t, self.first, self.last)
        if isinstance(self.geometry, Ellipse) and self.constant_speed:
            arm = points - self.geometry.center
            t = np.arctan2(arm @ self.geometry.y_axis, arm @ self.geometry.x_axis)
            # Into the turn around the middle of the arc: beyond its ends the nearer end is nearest.
            t -= 2.0 * np.pi * np.round((t - (self.first + self.last) / 2.0) / (2.0 * np.pi))
            return np.clip(t, self.first, self.last)
        samples, places = self._samples
        enough = 1e-15 * (abs(self.first) + abs(self.last))
        if len(points) * len(places) <= _FEW:
            if self._spline is not None:
                spline, period = self._spline
                return spline.nearest((samples, places), points, enough=enough, period=period)
            nearest = np.empty(len(points), dtype=np.int64)
            nearest_rows(places, np.ascontiguousarray(points), nearest)
        else:
            nearest = self._tree.query(np.where(np.isfinite(points), points, 0.0))[1]
        t = samples[nearest]
        lower, upper = samples[np.maximum(nearest - 1, 0)], samples[np.minimum(nearest + 1, len(samples) - 1)]
        for _ in range(30):
            place, first, second = self.geometry.derivatives(t, 2)
            off = place - points
            slope = np.einsum("md,md->m", off, first)
            # The Gauss-Newton term stands in where the full second derivative is not positive.
            gauss = np.einsum("md,md->m", first, first)
            curvature = gauss + np.einsum("md,md->m", off, second)
            curvature = np.where(curvature > 0.1 * gauss, curvature, np.maximum(gauss, 1e-300))
            new = np.clip(t - slope / curvature, lower, upper)
            moved = np.abs(new - t).max(initial=0.0)
            t = new
            if moved <= enough:
                break
        return t


def unhooked(curves: Sequence[EdgeCurve], tangents: FloatArray, near: FloatArray) -> FloatArray:
    """Unit tangents (n, 2, 3) at both ends of edges, without hooks much smaller than any detail of the part.

    Parameters
    ----------
    curves : sequence of n EdgeCurve
    tangents : (n, 2, 3) float64
        At the very ends.
    near : (n, 6, 3) float64
        Points at the fractions of :data:`END_FRACTIONS` beside the ends.
    """
    steps = np.diff(near.reshape(-1, 2, 3, 3), axis=2) * [[[1.0]], [[-1.0]]]
    steps /= np.maximum(np.linalg.norm(steps, axis=3, keepdims=True), 1e-300)
    first, second = steps[:, :, 0], steps[:, :, 1]
    straight = np.linalg.norm(first - second, axis=2) < _STRAIGHT
    hooked = np.linalg.norm(tangents - first, axis=2) > 4 * _STRAIGHT
    may_hook = np.array([not isinstance(curve.geometry, Line | Ellipse) for curve in curves], dtype=bool)
    return np.where((straight & hooked & may_hook[:, None])[..., None], first, tangents)
