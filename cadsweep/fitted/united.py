"""Surfaces and curves of several faces and edges that run smoothly into each other, taken as one.

A point belongs to the piece whose facets, or whose curve, are nearest, and is put on that piece exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Curve, Surface
from .facets import Facets, Nearest


class UnitedSurface:
    """Several faces as one surface; parameters (m, 3) are a piece's own two and the number of the piece."""

    def __init__(self, surfaces: Sequence[Surface], curves: Mapping[int, Curve], facets: Facets, sag: float) -> None:
        """`curves`: of the edges around, by id; `facets`: of the surfaces, by their places, off them by a `sag`."""
        self.surfaces, self.curves = surfaces, curves
        self.nearest = Nearest(facets)
        corners = [facets.points[facets.triangles[facets.faces == j]].reshape(-1, 3) for j in range(len(surfaces))]
        self.boxes = [(own.min(axis=0) - sag, own.max(axis=0) + sag) if len(own) else None for own in corners]

    @property
    def periods(self) -> tuple[float | None, float | None]:
        """None: what closes is in the pieces."""
        return None, None

    def pieces(self, points: FloatArray) -> IntArray:
        """The piece (m,) nearest to points (m, 3)."""
        return self.nearest.faces[self.nearest(points)[1]]

    def evaluate(self, uv: FloatArray) -> FloatArray:
        return self._each(uv, lambda surface, own: surface.evaluate(own))

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        both = self._each(uv, lambda surface, own: np.hstack(surface.derivatives(own)), width=6)
        return both[:, :3], both[:, 3:]

    def normals(self, uv: FloatArray) -> FloatArray:
        return self._each(uv, lambda surface, own: surface.normals(own))

    def project(self, points: FloatArray) -> FloatArray:
        numbers = self.pieces(points)
        found = np.empty((len(points), 3))
        found[:, 2] = numbers
        for piece in np.unique(numbers).tolist():
            own = numbers == piece
            found[own, :2] = self.surfaces[piece].project(points[own])
        return found

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        return self.project(self.curves[edge].evaluate(fractions))

    def distance(self, points: FloatArray, *, close: float = -1.0) -> FloatArray:
        numbers = self.pieces(points)
        ways = {} if close < 0.0 else {"close": close}
        found = np.empty(len(points))
        for piece in np.unique(numbers).tolist():
            own = numbers == piece
            found[own] = self.surfaces[piece].distance(points[own], **ways)
        # A node that lies on the piece beside its own is on the face all the same.
        for surface, box in zip(self.surfaces, self.boxes, strict=True):
            if box is not None and (found > max(close, 0.0)).any():
                beyond = np.linalg.norm(points - np.clip(points, *box), axis=1)
                off = np.flatnonzero(found > np.maximum(beyond, max(close, 0.0)))
                found[off] = np.minimum(found[off], surface.distance(points[off], **ways))
        return found

    def _each(self, uv: FloatArray, ask: Callable[[Surface, FloatArray], FloatArray], width: int = 3) -> FloatArray:
        numbers = uv[:, 2].astype(np.int64)
        found = np.empty((len(uv), width))
        for piece in np.unique(numbers).tolist():
            own = numbers == piece
            found[own] = ask(self.surfaces[piece], uv[own, :2])
        return found


class UnitedCurve:
    """Several edges, head to tail, as one curve."""

    def __init__(self, curves: Sequence[tuple[Curve, bool]], lengths: Sequence[float]) -> None:
        """Curves, and whether each is run from its start to its end."""
        self.curves = curves
        self.ends = np.concatenate([[0.0], np.cumsum(lengths) / np.sum(lengths)])

    def evaluate(self, fractions: FloatArray) -> FloatArray:
        number = np.clip(np.searchsorted(self.ends, fractions, side="right") - 1, 0, len(self.curves) - 1)
        own = (fractions - self.ends[number]) / (self.ends[number + 1] - self.ends[number])
        found = np.empty((len(fractions), 3))
        for j, (curve, forward) in enumerate(self.curves):
            at = number == j
            if at.any():
                found[at] = curve.evaluate(own[at] if forward else 1.0 - own[at])
        return found

    def project(self, points: FloatArray) -> FloatArray:
        best, found = np.full(len(points), np.inf), np.zeros(len(points))
        for j, (curve, forward) in enumerate(self.curves):
            away = curve.distance(points)
            closer = away < best
            if closer.any():
                own = curve.project(points[closer])
                share = own if forward else 1.0 - own
                found[closer] = self.ends[j] + share * (self.ends[j + 1] - self.ends[j])
                best[closer] = away[closer]
        return found

    def nearest(self, points: FloatArray) -> FloatArray:
        return self.evaluate(self.project(points))

    def distance(self, points: FloatArray) -> FloatArray:
        return np.asarray(np.min([curve.distance(points) for curve, _ in self.curves], axis=0))
