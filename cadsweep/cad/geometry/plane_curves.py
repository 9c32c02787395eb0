"""Edges dropped on a plane: which of them keep apart, and what lies inside of which, for certain.

Place in the flow: the arrangement of a stack's outlines asks here, so that OpenCASCADE is left with those that may
touch.

Method: a piece of a curve keeps within ``h M / 2`` and within ``h^2 K / 8`` of its chord, where h is its range of the
parameter and M and K bound the first and the second derivative: lines, conics and splines have such bounds. What is
farther from the chord than that is off the piece, and sees it turn by the angle between its ends; pieces are halved
until that is so. Nothing here is judged by samples.

Not handled: curves known only through a function have no bounds; they may be anywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Literal

import numpy as np

from ...arrays import BoolArray, FloatArray, IntArray
from .curves import EdgeCurve
from .nurbs import BSpline
from .parametric import Ellipse, Hyperbola, Line, Parabola, Periodic

_DEEPEST = 12
"""Halvings of curves after which they count as touching."""
_LONG = 128
"""Pairs of pieces of two curves from which on these run along each other, and count as touching."""
_HALVINGS = 40
"""Halvings of a curve after which a point counts as lying on it."""
_CHUNK = 1_000_000
"""Pairs of boxes that are compared at once."""
_FIRST = 8
"""Pieces of a curve by which its box is found."""
_QUARTERS = np.array([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]])
"""Which halves of two pieces are compared, for each of the four pairs."""


class PlaneCurves:
    """Edges' curves dropped on a plane, in its coordinates.

    Parameters
    ----------
    curves : sequence of EdgeCurve
        Other descriptions of an edge's course count as without bounds, and have no points.
    axes : (2, 3) float64
        Of the plane.
    origin : (3,) float64
    """

    def __init__(self, curves: Sequence[Any], axes: FloatArray, origin: FloatArray) -> None:
        self.curves, self.axes, self.origin = curves, axes, origin
        n = len(curves)
        self.first, self.last = np.zeros(n), np.ones(n)
        self.slopes, self.bends = np.full(n, np.inf), np.full(n, np.inf)
        kinds: dict[type, list[int]] = {}
        for j, curve in enumerate(curves):
            if not isinstance(curve, EdgeCurve):
                continue
            self.first[j], self.last[j] = curve.first, curve.last
            kinds.setdefault(type(curve.geometry), []).append(j)
        self._vectors = np.zeros((n, 3, 2))
        self._round = np.zeros(n, dtype=np.bool_)
        self._plain = np.zeros(n, dtype=np.bool_)
        for kind, names in ((Line, ("origin", "direction")), (Ellipse, ("center", "x_axis", "y_axis"))):
            own = kinds.pop(kind, [])
            if not own:
                continue
            self._plain[own], self._round[own] = True, kind is Ellipse
            for k, name in enumerate(names):
                vectors = np.array([getattr(curves[j].geometry, name) for j in own])
                self._vectors[own, k] = (vectors - origin if k == 0 else vectors) @ axes.T
            lengths = np.linalg.norm(self._vectors[own, 1:], axis=2)
            self.slopes[own] = np.hypot(*lengths.T)
            self.bends[own] = self.slopes[own] if kind is Ellipse else 0.0
        for j in (j for own in kinds.values() for j in own):
            self.slopes[j], self.bends[j] = _derivative_bounds(curves[j], axes)

    def bounded(self) -> BoolArray:
        """Which of the curves are known well enough to be told from others."""
        return np.isfinite(np.minimum(self.slopes, self.bends))

    def points(self, own: IntArray, shares: FloatArray) -> FloatArray:
        """Points (m, k, 2) of curves `own` (m,) at `shares` (m, k) of their ranges."""
        at = self.first[own, None] * (1.0 - shares) + self.last[own, None] * shares
        base, x, y = (self._vectors[own, k][:, None] for k in range(3))
        turn = self._round[own, None]
        out = np.where(turn, np.cos(at), at)[..., None] * x
        out += np.where(turn, np.sin(at), 0.0)[..., None] * y
        out += base
        rest = np.flatnonzero(~self._plain[own])
        order = rest[np.argsort(own[rest], kind="stable")]
        for rows in np.split(order, np.flatnonzero(np.diff(own[order])) + 1):
            if len(rows) and isinstance(self.curves[own[rows[0]]], EdgeCurve):
                places = self.curves[own[rows[0]]].geometry.derivatives(at[rows].ravel())[0]
                out[rows] = ((places - self.origin) @ self.axes.T).reshape(len(rows), -1, 2)
        return out

    def _pieces(self, own: IntArray, start: FloatArray, width: float) -> tuple[FloatArray, FloatArray]:
        """Ends (m, 2, 2) of pieces, and how far each may keep from its chord."""
        ends = self.points(own, np.stack([start, start + width], axis=1))
        h = (self.last[own] - self.first[own]) * width
        # What is not known is far, whatever the range.
        return ends, np.minimum(h * self.slopes[own] / 2.0, h * h * self.bends[own] / 8.0)

    @cached_property
    def boxes(self) -> FloatArray:
        """Least and greatest coordinates (n, 2, 2), which no curve exceeds."""
        every = np.arange(len(self.curves))
        parts = [self._boxes(every, np.full(len(every), k / _FIRST), 1.0 / _FIRST) for k in range(_FIRST)]
        low, high = np.min([part[:, 0] for part in parts], axis=0), np.max([part[:, 1] for part in parts], axis=0)
        return np.stack([low, high], axis=1)

    def _boxes(self, own: IntArray, start: FloatArray, width: float) -> FloatArray:
        ends, away = self._pieces(own, start, width)
        return np.stack([ends.min(axis=1) - away[:, None], ends.max(axis=1) + away[:, None]], axis=1)

    def touching(self, pairs: IntArray, reach: float) -> BoolArray:
        """Which pairs (m, 2) of curves are not sure to keep farther from each other than `reach`."""
        found = np.zeros(len(pairs), dtype=np.bool_)
        pair, shares = np.arange(len(pairs)), np.zeros((len(pairs), 2))
        width = 1.0
        for depth in range(_DEEPEST + 1):
            boxes = [self._boxes(pairs[pair, side], shares[:, side], width) for side in (0, 1)]
            near = np.all(
                (boxes[0][:, 0] <= boxes[1][:, 1] + reach) & (boxes[1][:, 0] <= boxes[0][:, 1] + reach), axis=1
            )
            pair, shares = pair[near], shares[near]
            if depth < _DEEPEST:
                found |= np.bincount(pair, minlength=len(pairs)) > _LONG
                left = ~found[pair]
                pair, shares = np.repeat(pair[left], 4), np.repeat(shares[left], 4, axis=0)
                width /= 2.0
                shares += np.tile(width * _QUARTERS, (len(shares) // 4, 1))
        found[pair] = True
        return found

    def turns(self, points: FloatArray, owner: IntArray, own: IntArray, senses: FloatArray) -> FloatArray:
        """How often closed chains of curves turn round points.

        Parameters
        ----------
        points : (k, 2) float64
        owner : (m,) int64
            Point that each use of a curve is asked for.
        own : (m,) int64
            Curves of the chains.
        senses : (m,) float64
            1 where they are run forward, -1 where backward.

        Returns
        -------
        (k,) float64
            Whole numbers where the chains close; NaN where a point lies on a curve, or one without bounds is near it.
        """
        sums = np.zeros(len(points))
        start, width = np.zeros(len(own)), 1.0
        for _ in range(_HALVINGS):
            ends, away = self._pieces(own, start, width)
            arms = ends - points[owner, None]
            chord = arms[:, 1] - arms[:, 0]
            square = np.maximum(np.einsum("md,md->m", chord, chord), 1e-300)
            at = np.clip(-np.einsum("md,md->m", arms[:, 0], chord) / square, 0.0, 1.0)
            # Off what is round the chord, the piece is seen to turn as its chord does.
            off = np.linalg.norm(arms[:, 0] + at[:, None] * chord, axis=1) > away
            seen = arms[off]
            crossed = seen[:, 0, 0] * seen[:, 1, 1] - seen[:, 0, 1] * seen[:, 1, 0]
            angles = np.arctan2(crossed, np.einsum("md,md->m", seen[:, 0], seen[:, 1])) * senses[off]
            sums += np.bincount(owner[off], angles, len(points))
            if off.all():
                return np.round(sums / (2.0 * np.pi))
            width /= 2.0
            owner, own, senses = (np.repeat(values[~off], 2) for values in (owner, own, senses))
            start = np.repeat(start[~off], 2)
            start[1::2] += width
        sums[owner] = np.nan
        return np.round(sums / (2.0 * np.pi))


def near_pairs(first: FloatArray, second: FloatArray, reach: float) -> IntArray:
    """Pairs (m, 2) of boxes (n, 2, 2) and others (k, 2, 2) that come nearer than `reach`."""
    # Of two that meet, one begins where the other is; a wide box costs no more than what lies beside it.
    ahead = _beginning(first, second, reach, side="left")
    behind = _beginning(second, first, reach, side="right")[:, ::-1]
    return np.concatenate([ahead, behind])


def _beginning(first: FloatArray, second: FloatArray, reach: float, *, side: Literal["left", "right"]) -> IntArray:
    """Those pairs of near boxes whose second begins where the first is; on the right not at its begin."""
    order = np.argsort(second[:, 0, 0], kind="stable")
    low = second[order, 0, 0]
    begin = np.searchsorted(low, first[:, 0, 0], side=side)
    counts = np.maximum(np.searchsorted(low, first[:, 1, 0] + reach, side="right") - begin, 0)
    total = np.cumsum(counts)
    found = [np.empty((0, 2), dtype=np.int64)]
    for rows in np.split(np.arange(len(first)), np.searchsorted(total, np.arange(_CHUNK, total[-1:].sum(), _CHUNK))):
        row = np.repeat(rows, counts[rows])
        offset = np.arange(len(row)) - np.repeat(np.cumsum(counts[rows]) - counts[rows], counts[rows])
        other = order[begin[row] + offset]
        near = (first[row, 0, 1] <= second[other, 1, 1] + reach) & (second[other, 0, 1] <= first[row, 1, 1] + reach)
        found.append(np.stack([row[near], other[near]], axis=1))
    return np.concatenate(found)


def _derivative_bounds(curve: EdgeCurve, axes: FloatArray) -> tuple[float, float]:
    """Bounds of the first and the second derivative of a curve on the plane; infinite where none is known."""
    geometry = curve.geometry
    if isinstance(geometry, Parabola):
        x, y = (float(np.linalg.norm(axes @ axis)) for axis in (geometry.x_axis, geometry.y_axis))
        return 2.0 * max(abs(curve.first), abs(curve.last)) * x + y, 2.0 * x
    if isinstance(geometry, Hyperbola):
        x, y = (float(np.linalg.norm(axes @ axis)) for axis in (geometry.x_axis, geometry.y_axis))
        most = float(np.cosh(max(abs(curve.first), abs(curve.last)))) * (x + y)
        return most, most
    spline = geometry.spline if isinstance(geometry, Periodic) else geometry
    if not isinstance(spline, BSpline):
        return float("inf"), float("inf")
    poles = spline.poles @ axes.T
    if spline.weights is None:
        slope, inner = _differences(poles, spline.knots, spline.degree)
        bend, _ = _differences(slope, inner, spline.degree - 1)
        return _longest(slope), _longest(bend)
    # c = A / w, and the poles about one of them are what |c| cannot exceed.
    poles = poles - poles[0]
    weighted, _ = _differences(poles * spline.weights[:, None], spline.knots, spline.degree)
    weights, _ = _differences(spline.weights[:, None], spline.knots, spline.degree)
    least = float(spline.weights.min())
    if least <= 0.0:
        return float("inf"), float("inf")
    return (_longest(weighted) + _longest(poles) * _longest(weights)) / least, float("inf")


def _differences(poles: FloatArray, knots: FloatArray, degree: int) -> tuple[FloatArray, FloatArray]:
    """Poles and knots of the derivative of a spline; infinite poles where it breaks."""
    if degree < 1:
        return np.zeros((1, poles.shape[1])) if len(poles) == 1 else np.full_like(poles, np.inf), knots
    widths = knots[degree + 1 : len(poles) + degree] - knots[1 : len(poles)]
    steps = np.diff(poles, axis=0)
    found = np.full_like(steps, np.inf)
    found[widths > 0.0] = degree * steps[widths > 0.0] / widths[widths > 0.0, None]
    return found, knots[1:-1]


def _longest(vectors: FloatArray) -> float:
    # A pole that is infinite belongs to a break: what was differenced from it is none.
    lengths = np.linalg.norm(vectors, axis=1)
    return float(np.where(np.isnan(lengths), np.inf, lengths).max(initial=0.0))


__all__ = ["PlaneCurves", "near_pairs"]
