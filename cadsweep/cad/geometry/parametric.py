"""Curves by their parameter: the kinds that OpenCASCADE has, in numpy alone.

Place in the flow: ``convert`` turns the curves of OpenCASCADE into these; :class:`~.curves.EdgeCurve` is a piece of one
by arc length, and surfaces are drawn along some.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from .nurbs import BSpline


class Parametric(Protocol):
    """A curve in its own parameter."""

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order` (0, 1 or 2), each (m, d)."""
        ...


@dataclass(frozen=True, kw_only=True, eq=False)
class Line:
    """``origin + t * direction``."""

    origin: FloatArray
    direction: FloatArray

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order`."""
        points = self.origin + parameters[:, None] * self.direction
        if order == 0:
            return [points]
        out = [points, np.broadcast_to(self.direction, points.shape), np.zeros_like(points)]
        return out[: order + 1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Ellipse:
    """``center + cos t * x_axis + sin t * y_axis``; the axes carry the radii."""

    center: FloatArray
    x_axis: FloatArray
    y_axis: FloatArray

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order`."""
        cos, sin = np.cos(parameters)[:, None], np.sin(parameters)[:, None]
        radius = cos * self.x_axis + sin * self.y_axis
        if order == 0:
            return [self.center + radius]
        out = [self.center + radius, cos * self.y_axis - sin * self.x_axis, -radius]
        return out[: order + 1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Hyperbola:
    """``center + cosh t * x_axis + sinh t * y_axis``."""

    center: FloatArray
    x_axis: FloatArray
    y_axis: FloatArray

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order`."""
        cosh, sinh = np.cosh(parameters)[:, None], np.sinh(parameters)[:, None]
        arm = cosh * self.x_axis + sinh * self.y_axis
        return [self.center + arm, cosh * self.y_axis + sinh * self.x_axis, arm][: order + 1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Parabola:
    """``vertex + t * t * x_axis + t * y_axis``."""

    vertex: FloatArray
    x_axis: FloatArray
    y_axis: FloatArray

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order`."""
        t = parameters[:, None]
        slope = 2.0 * t * self.x_axis + self.y_axis
        curvature = np.broadcast_to(2.0 * self.x_axis, slope.shape)
        return [self.vertex + t * t * self.x_axis + t * self.y_axis, slope, curvature][: order + 1]


@dataclass(frozen=True, kw_only=True, eq=False)
class Periodic:
    """A B-spline that goes on beyond its knots with a period."""

    spline: BSpline
    period: float

    @property
    def breaks(self) -> FloatArray:
        """Distinct knots of one period."""
        return self.spline.breaks

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order`."""
        return self.spline.derivatives(parameters, order, period=self.period)


@dataclass(frozen=True, kw_only=True, eq=False)
class Reparametrised:
    """``curve(offset + rate * t)``: a parameter curve whose range is not that of its edge."""

    curve: Parametric
    offset: float
    rate: float

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order`."""
        found = self.curve.derivatives(self.offset + self.rate * parameters, order)
        return [values * self.rate**k for k, values in enumerate(found)]


@dataclass(frozen=True, kw_only=True, eq=False)
class Called:
    """A curve known only through a function of one parameter (any other kind of OpenCASCADE curve)."""

    function: Callable[[float, int], tuple[tuple[float, ...], ...]]

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order`."""
        rows = np.array([self.function(float(t), order) for t in parameters], dtype=float)
        return [np.ascontiguousarray(rows[:, k]) for k in range(order + 1)]
