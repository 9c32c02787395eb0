"""A surface over the box of a face, with its outward side: places, derivatives and normals.

Place in the flow: what :mod:`.feet` looks for nearest points on, and :mod:`.face_surface` adds a face's edges to.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...arrays import FloatArray
from .record_kernels import surface_normals, surface_points
from .records import surface_record
from .surfaces import Geometry, Periods, Plane
from .vectors import cross_rows


@dataclass(frozen=True, kw_only=True, eq=False)
class Patch:
    """A surface with the box of a face and its outward side.

    Attributes
    ----------
    geometry : Geometry
    outward : float
        1 where the cross product of the partial derivatives points out of the solid, else -1.
    box : (2, 2) float64
        Least and greatest u and v of the face.
    limits : (2, 2) float64
        Where the surface is defined; infinite where it goes on.
    """

    geometry: Geometry
    outward: float
    box: FloatArray
    limits: FloatArray

    @property
    def periods(self) -> Periods:
        """Periods in u and v, None where the surface is not periodic."""
        return self.geometry.periods

    @cached_property
    def record(self) -> FloatArray | None:
        """The surface as compiled loops take it; None where it has no record."""
        return surface_record(self.geometry)

    @cached_property
    def curved(self) -> FloatArray | None:
        """The record; None for a plane, too, which numpy evaluates as fast."""
        return None if isinstance(self.geometry, Plane) else self.record

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3) at the parameters (m, 2)."""
        if self.curved is None:
            return self.geometry.evaluate(rows_of(uv, 2))
        return self._evaluated(uv, 1)[0]

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Partial derivatives by u and by v, each (m, 3)."""
        if self.curved is None:
            _, by_u, by_v = self.geometry.derivatives(rows_of(uv, 2))
        else:
            _, by_u, by_v = self._evaluated(uv, 3)
        return by_u, by_v

    def _evaluated(self, uv: FloatArray, n: int) -> FloatArray:
        uv = packed(uv, 2)
        out = np.empty((n, len(uv), 3))
        surface_points(self.curved, uv, out)
        return out

    def normals(self, uv: FloatArray) -> FloatArray:
        """Unit normals (m, 3) out of the solid; at a singular point the one of a point nearby, inside."""
        if self.curved is not None:
            uv = packed(uv, 2)
            out = np.empty((len(uv), 3))
            surface_normals(self.curved, self.outward, self.box, uv, out)
            return out
        uv = rows_of(uv, 2)
        exact = getattr(self.geometry, "unit_normals", None)
        if exact is not None:
            return self.outward * exact(uv)
        middle = self.box.mean(axis=0)
        inside = uv
        normals = np.empty((len(uv), 3))
        todo = np.arange(len(uv))
        for share in (0.0, 1e-6, 1e-4, 1e-2):
            inside = uv[todo] + share * (middle - uv[todo])
            _, by_u, by_v = self.geometry.derivatives(inside)
            cross = cross_rows(by_u, by_v)
            norm = np.linalg.norm(cross, axis=1)
            scale = np.linalg.norm(by_u, axis=1) * np.linalg.norm(by_v, axis=1)
            normals[todo] = cross / np.where(norm > 0, norm, 1.0)[:, None]
            singular = norm <= 1e-9 * np.maximum(scale, self._scale)
            todo = todo[singular]
            if not len(todo):
                break
        return self.outward * normals

    @cached_property
    def _scale(self) -> float:
        """Size of the product of the partial derivatives over the face, to know a vanishing one by."""
        shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 5)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
        grid = self.box[0] + shares * (self.box[1] - self.box[0])
        _, by_u, by_v = self.geometry.derivatives(grid)
        return float(np.median(np.linalg.norm(by_u, axis=1)) * np.median(np.linalg.norm(by_v, axis=1)))

    def in_branch(self, uv: FloatArray) -> FloatArray:
        """Shift parameters (m, 2) by periods into the branch around the middle of the face."""
        uv = np.array(rows_of(uv, 2), dtype=float)
        for j, period in enumerate(self.periods):
            if period is not None:
                middle = self.box[:, j].mean()
                uv[:, j] -= period * np.round((uv[:, j] - middle) / period)
        return uv


def rows_of(values: FloatArray, width: int) -> FloatArray:
    return np.asarray(values, dtype=float).reshape(-1, width)


def packed(values: FloatArray, width: int) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1, width)
