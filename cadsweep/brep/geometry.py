"""Curves and surfaces as stages meet them, and what units coordinates are in."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import floor, log10
from typing import Protocol

import numpy as np

from ..arrays import FloatArray


class Curve(Protocol):
    """Geometry of an edge. ``fractions`` are fractions of arc length, 0 at its start, 1 at its end."""

    def evaluate(self, fractions: FloatArray) -> FloatArray:
        """Return the points (m, 3) at the given arc-length fractions (m,)."""
        ...

    def project(self, points: FloatArray) -> FloatArray:
        """Return the arc-length fractions (m,) of the points of the edge nearest to `points` (m, 3)."""
        ...

    def nearest(self, points: FloatArray) -> FloatArray:
        """Return the places (m, 3) of the edge nearest to `points` (m, 3)."""
        ...

    def distance(self, points: FloatArray) -> FloatArray:
        """Return the distances (m,) of `points` (m, 3) from the edge, its ends included."""
        ...


class Surface(Protocol):
    """Geometry of a face, in the surface's own parameters ``uv`` (m, 2)."""

    @property
    def periods(self) -> tuple[float | None, float | None]:
        """Periods in u and v, None where the surface is not periodic."""
        ...

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Return the points (m, 3) of the surface at `uv` (m, 2)."""
        ...

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the partial derivatives (m, 3), (m, 3) by u and by v."""
        ...

    def normals(self, uv: FloatArray) -> FloatArray:
        """Return unit normals (m, 3) that point out of the solid."""
        ...

    def project(self, points: FloatArray) -> FloatArray:
        """Return the parameters (m, 2) of the points of the *face's surface* nearest to `points`."""
        ...

    def distance(self, points: FloatArray, *, close: float = ...) -> FloatArray:
        """Return the distances (m,) of `points` (m, 3) from the *face's surface*.

        Distances up to `close` are found fast; larger ones are made sure of by slower ways.
        """
        ...

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        """Return the parameters (m, 2) of an edge of this face at arc-length fractions (m,).

        On a periodic surface the values of all edges lie in one consistent branch.
        """
        ...


@dataclass(frozen=True, eq=False)
class Units:
    """How working coordinates become the model's.

    Attributes
    ----------
    scale : float
        Model units per working unit, a power of two.
    offset : (3,) float64
        Model coordinates of the working origin.
    """

    scale: float = 1.0
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))

    def to_model(self, points: FloatArray) -> FloatArray:
        """Bring points (..., 3) from working to model units; exact where nothing was shifted."""
        if self.scale == 1.0 and not self.offset.any():
            return points
        return points * self.scale + self.offset

    def place(self, point: FloatArray) -> str:
        """Return how messages say where a working point is: its model coordinates, to four digits of the part."""
        # Centres are integrals: what is far below the digits shown is their noise, and would be read as a place.
        working = np.where(np.abs(point) > max(1e-9, 1e-7 * float(np.abs(point).max())), point, 0.0)
        if not self.offset.any():
            return ", ".join(f"{c:.4g}" for c in working * self.scale + 0.0)
        # Far from the origin, four digits of the coordinates themselves would be the same all over the part.
        step = self.scale * max(float(np.abs(working).max()), 1e-9) * 1e-4
        decimals = max(0, -floor(log10(step)))
        return ", ".join(f"{round(float(c), decimals) + 0.0:.15g}" for c in self.to_model(working))
