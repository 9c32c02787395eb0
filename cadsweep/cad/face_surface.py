"""The bounded, oriented surface of one face: what ``topology.Face.surface`` holds.

Place in the flow: ``extract`` makes one per face from a geometry of :mod:`cadsweep.cad.surfaces` and
the parameter curves of the face's edges.

Method of ``project`` where there is no closed form: the nearest of a grid of points over the face's
parameter box, then Gauss-Newton with halved steps, every point at once. The result may leave the
face (by a margin of its box), as the *surface* is asked for, not the trimmed face.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from ..topology import FloatArray
from .curves import EdgeCurve, Parametric
from .surfaces import Geometry, Periods

_GRID = 33


@dataclass(frozen=True, kw_only=True, eq=False)
class FaceSurface:
    """A surface with the box of a face, its outward side and its edges' parameter curves.

    Attributes
    ----------
    geometry : Geometry
    outward : float
        1 where the cross product of the partial derivatives points out of the solid, else -1.
    box : (2, 2) float64
        Least and greatest u and v of the face.
    limits : (2, 2) float64
        Where the surface is defined; infinite where it goes on.
    curves : mapping of int to (EdgeCurve, Parametric or None, (2,) float64)
        For each edge: its curve in space, its curve in the parameters (None: not known), and the
        shift that brings the latter into the face's branch.
    """

    geometry: Geometry
    outward: float
    box: FloatArray
    limits: FloatArray
    curves: Mapping[int, tuple[EdgeCurve, Parametric | None, FloatArray]] = field(default_factory=dict)

    @property
    def periods(self) -> Periods:
        """Periods in u and v, None where the surface is not periodic."""
        return self.geometry.periods

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3) at the parameters (m, 2)."""
        return self.geometry.evaluate(_rows(uv, 2))

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Partial derivatives by u and by v, each (m, 3)."""
        _, by_u, by_v = self.geometry.derivatives(_rows(uv, 2))
        return by_u, by_v

    def normals(self, uv: FloatArray) -> FloatArray:
        """Unit normals (m, 3) out of the solid; at a singular point the one of a point nearby, inside."""
        uv = _rows(uv, 2)
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
            cross = np.cross(by_u, by_v)
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
        grid = self._box_grid(5)
        _, by_u, by_v = self.geometry.derivatives(grid)
        return float(np.median(np.linalg.norm(by_u, axis=1)) * np.median(np.linalg.norm(by_v, axis=1)))

    def in_branch(self, uv: FloatArray) -> FloatArray:
        """Shift parameters (m, 2) by periods into the branch around the middle of the face."""
        uv = np.array(_rows(uv, 2), dtype=float)
        for j, period in enumerate(self.periods):
            if period is not None:
                middle = self.box[:, j].mean()
                uv[:, j] -= period * np.round((uv[:, j] - middle) / period)
        return uv

    def project(self, points: FloatArray) -> FloatArray:
        """Parameters (m, 2) of the points of the surface nearest to `points` (m, 3)."""
        points = _rows(points, 3)
        exact = getattr(self.geometry, "project", None)
        if exact is not None:
            return self.in_branch(exact(points))
        grid, tree = self._grid
        start = grid[tree.query(points)[1]]
        return self._refine(points, start)

    @cached_property
    def _grid(self) -> tuple[FloatArray, cKDTree]:
        grid = self._box_grid(_GRID)
        return grid, cKDTree(self.geometry.evaluate(grid))

    def _box_grid(self, n: int) -> FloatArray:
        shares = np.linspace(0.0, 1.0, n)
        grid = np.stack(np.meshgrid(shares, shares, indexing="ij"), axis=-1).reshape(-1, 2)
        return self.box[0] + grid * (self.box[1] - self.box[0])

    def _refine(self, points: FloatArray, uv: FloatArray, n_steps: int = 50) -> FloatArray:
        """Gauss-Newton for the nearest points from `uv`; a step that does not come nearer is halved."""
        width = self.box[1] - self.box[0]
        lower = np.maximum(self.limits[0], self.box[0] - 0.5 * width)
        upper = np.minimum(self.limits[1], self.box[1] + 0.5 * width)
        uv = np.array(uv, dtype=float)
        active = np.arange(len(uv))
        for _ in range(n_steps):
            place, by_u, by_v = self.geometry.derivatives(uv[active])
            off = points[active] - place
            distance = np.einsum("md,md->m", off, off)
            step = _least_squares_step(by_u, by_v, off)
            new = np.clip(uv[active] + step, lower, upper)
            worse = np.arange(len(active))
            for _halving in range(8):
                off = points[active[worse]] - self.geometry.evaluate(new[worse])
                still = np.einsum("md,md->m", off, off) > distance[worse] * (1 + 1e-14) + 1e-300
                worse = worse[still]
                if not len(worse):
                    break
                new[worse] = 0.5 * (new[worse] + uv[active[worse]])
            new[worse] = uv[active[worse]]
            moved = np.abs(new - uv[active]).max(axis=1) > 1e-13 * np.abs(width).max()
            uv[active] = new
            active = active[moved]
            if not len(active):
                break
        return uv

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        """Parameters (m, 2) of an edge of this face at arc-length fractions (m,).

        Raises
        ------
        KeyError
            The edge does not bound the face.
        """
        fractions = np.atleast_1d(np.asarray(fractions, dtype=float))
        curve, in_parameters, shift = self.curves[edge]
        parameters = curve.parameters(fractions)
        points = curve.geometry.derivatives(parameters)[0]
        exact = getattr(self.geometry, "project", None)
        if in_parameters is None:
            uv = self.in_branch(self.project(points))
            return self._unrolled(uv)
        guess = in_parameters.derivatives(parameters)[0] + shift
        if exact is None:
            return self._refine(points, guess, n_steps=4)
        uv = exact(points)
        for j, period in enumerate(self.periods):
            if period is not None:
                uv[:, j] += period * np.round((guess[:, j] - uv[:, j]) / period)
        # At an apex or a pole the angle is free, and only the parameter curve knows it.
        _, by_u, by_v = self.geometry.derivatives(guess)
        for j, partial in enumerate((by_u, by_v)):
            if self.periods[j] is not None:
                norm = np.linalg.norm(partial, axis=1)
                singular = norm <= 1e-7 * max(norm.max(initial=0.0), np.abs(self.box).max(initial=1.0) * 1e-3)
                uv[singular, j] = guess[singular, j]
        return uv

    def _unrolled(self, uv: FloatArray) -> FloatArray:
        for j, period in enumerate(self.periods):
            if period is not None:
                uv[:, j] = np.unwrap(uv[:, j], period=period)
        return uv


def _rows(values: FloatArray, width: int) -> FloatArray:
    return np.asarray(values, dtype=float).reshape(-1, width)


def _least_squares_step(by_u: FloatArray, by_v: FloatArray, off: FloatArray) -> FloatArray:
    """Solve the 2 x 2 normal equations of every point; a singular direction gets no step."""
    a = np.einsum("md,md->m", by_u, by_u)
    b = np.einsum("md,md->m", by_u, by_v)
    c = np.einsum("md,md->m", by_v, by_v)
    e = np.einsum("md,md->m", by_u, off)
    f = np.einsum("md,md->m", by_v, off)
    determinant = a * c - b * b
    regular = determinant > 1e-14 * np.maximum(a * c, 1e-300)
    safe = np.where(regular, determinant, 1.0)
    step = np.column_stack([(c * e - b * f) / safe, (a * f - b * e) / safe])
    along_u = np.column_stack([e / np.where(a > 0, a, 1.0), np.zeros_like(e)])
    along_v = np.column_stack([np.zeros_like(f), f / np.where(c > 0, c, 1.0)])
    single = np.where((a >= c)[:, None], along_u, along_v)
    return np.where(regular[:, None], step, single)
