"""The bounded, oriented surface of one face: what ``brep.Face.surface`` holds.

Place in the flow: ``extract`` makes one per face from a geometry of :mod:`cadsweep.cad.surfaces` and
the parameter curves of the face's edges.

Method of ``project`` where there is no closed form: the nearest of a grid of points over the face's
parameter box, finer where the surface turns, then Gauss-Newton with halved steps (compiled where the surface has a
record, :mod:`.records`; every point at once where it has none). The result may leave the face (by a margin of its box),
as the *surface* is asked for, not the trimmed face.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from ...arrays import FloatArray, IntArray
from .curves import EdgeCurve, Parametric
from .feet_kernels import descended_feet, exact_feet, grid_places, turning_stops
from .nearest_kernels import near_on_lines, nearest_rows, other_walls
from .record_kernels import curve_points, surface_normals, surface_points
from .records import curve_record, surface_record
from .surfaces import Cone, Geometry, Offset, Periods, Plane, Torus, grid_points, knots_of
from .vectors import cross_rows

_GRID = 33
"""Places of the grid along each parameter, at least."""
_LARGEST_TURN = np.pi / 18
"""Turn of the surface between two places of the grid, at most, up to `_MOST_GRID` of them."""
_MOST_GRID = 1024
"""Places in each direction for first guesses: a helix of a hundred turns has ten a turn."""
_PLACES = 8
"""Places of the grid from which a doubtful point is looked for."""
_DOUBTFUL = 0.1
"""Distance of a foot over that of the place of the grid it was looked for from, beyond which it is looked for anew."""
_TURNED = 0.5
"""Cosine between normals beyond which they are of another wall, or of the tip between two."""
_MOST_STEPS = 40
"""Places of the grid along a line among which another wall is looked for: more are far away."""
_FEW = 200_000
"""Pairs of a point and a place of the grid up to which all are compared: a tree would take longer to be made."""


@dataclass(frozen=True, kw_only=True, eq=False)
class EdgeOnFace:
    """An edge of a face, in space and in the parameters of the surface.

    Attributes
    ----------
    curve : EdgeCurve
    read : callable
        Returns the curve in the parameters (None: not known), in the parameter of `curve`, and the shift (2,) that
        brings it into the face's branch. Called when it is first asked for: OpenCASCADE has to make it for a plane,
        and hardly anybody wants to know it there.
    """

    curve: EdgeCurve
    read: Callable[[], tuple[Parametric | None, FloatArray]]

    @cached_property
    def in_parameters(self) -> tuple[Parametric | None, FloatArray]:
        """What `read` returns."""
        return self.read()

    @cached_property
    def record(self) -> FloatArray | None:
        """The curve in the parameters as compiled loops take it; None where it has no record, or is not known."""
        known = self.in_parameters[0]
        return None if known is None else curve_record(known)


class EdgeRecords(NamedTuple):
    """The parameter curves of all edges of a face, as compiled loops take them.

    Attributes
    ----------
    row : mapping of int to int
        By edge id, its row in `starts` and `shifts`.
    values : float64 array
        All records.
    starts : (n,) int64
        Where each begins.
    shifts : (n, 2) float64
        Into the branch of the face.
    """

    row: Mapping[int, int]
    values: FloatArray
    starts: IntArray
    shifts: FloatArray


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
    curves : mapping of int to EdgeOnFace
        By edge id.
    second_opinion : callable or None
        Distances (m,) of points (m, 3) from the surface over the face's box, by OpenCASCADE: slow.
    """

    geometry: Geometry
    outward: float
    box: FloatArray
    limits: FloatArray
    curves: Mapping[int, EdgeOnFace] = field(default_factory=dict)
    second_opinion: Callable[[FloatArray], FloatArray] | None = None

    @property
    def periods(self) -> Periods:
        """Periods in u and v, None where the surface is not periodic."""
        return self.geometry.periods

    @cached_property
    def record(self) -> FloatArray | None:
        """The surface as compiled loops take it; None where it has no record."""
        return surface_record(self.geometry)

    @cached_property
    def _curved(self) -> FloatArray | None:
        """The record; None for a plane, too, which numpy evaluates as fast."""
        return None if isinstance(self.geometry, Plane) else self.record

    @cached_property
    def edge_records(self) -> EdgeRecords | None:
        """The parameter curves of all edges; None where one has no record."""
        records = [on_face.record for on_face in self.curves.values()]
        found = [record for record in records if record is not None]
        if len(found) < len(records) or not found:
            return None
        return EdgeRecords(
            row={edge: j for j, edge in enumerate(self.curves)},
            values=np.concatenate(found),
            starts=np.cumsum([0] + [len(record) for record in found[:-1]]),
            shifts=np.array([on_face.in_parameters[1] for on_face in self.curves.values()]),
        )

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3) at the parameters (m, 2)."""
        if self._curved is None:
            return self.geometry.evaluate(_rows(uv, 2))
        return self._evaluated(uv, 1)[0]

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Partial derivatives by u and by v, each (m, 3)."""
        if self._curved is None:
            _, by_u, by_v = self.geometry.derivatives(_rows(uv, 2))
        else:
            _, by_u, by_v = self._evaluated(uv, 3)
        return by_u, by_v

    def _evaluated(self, uv: FloatArray, n: int) -> FloatArray:
        uv = _packed(uv, 2)
        out = np.empty((n, len(uv), 3))
        surface_points(self._curved, uv, out)
        return out

    def normals(self, uv: FloatArray) -> FloatArray:
        """Unit normals (m, 3) out of the solid; at a singular point the one of a point nearby, inside."""
        if self._curved is not None:
            uv = _packed(uv, 2)
            out = np.empty((len(uv), 3))
            surface_normals(self._curved, self.outward, self.box, uv, out)
            return out
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
        uv = np.array(_rows(uv, 2), dtype=float)
        for j, period in enumerate(self.periods):
            if period is not None:
                middle = self.box[:, j].mean()
                uv[:, j] -= period * np.round((uv[:, j] - middle) / period)
        return uv

    def project(self, points: FloatArray) -> FloatArray:
        """Parameters (m, 2) of the points of the surface nearest to `points` (m, 3)."""
        return self._nearest(_rows(points, 3))[0]

    def distance(self, points: FloatArray, *, close: float = np.inf) -> FloatArray:
        """Distances (m,) of `points` (m, 3) from the surface.

        What is farther than `close` from the foot that is found is left to OpenCASCADE. The least distance counts.
        """
        points = _rows(points, 3)
        found = self._nearest(points, close=close)[1]
        if self._exact is not None:
            return found
        far = np.flatnonzero(found > close)
        if len(far) and self.second_opinion is not None:
            found[far] = np.minimum(found[far], self.second_opinion(points[far]))
        return found

    @property
    def _exact(self) -> Callable[[FloatArray], FloatArray] | None:
        """Nearest parameters in closed form, where the geometry knows them."""
        return getattr(self.geometry, "project", None)

    def _nearest(self, points: FloatArray, *, close: float = np.inf) -> tuple[FloatArray, FloatArray]:
        """Nearest parameters (m, 2), and the distances there (m,).

        Where Newton's method hardly comes nearer than the place of the grid that it begins at, that may be on another
        coil than the nearest point is, or on the other wall of a thin tip; there, and where it ends farther away than
        `close`, it begins anew from other places of the grid.
        """
        if self._exact is not None:
            if isinstance(self.geometry, Cone | Torus):
                points = _packed(points, 3)
                uv = np.empty((len(points), 2))
                exact_feet(self._curved, self.box, points, self.box.mean(axis=0)[None], False, uv)
            else:
                uv = self.in_branch(self._exact(points))
            return uv, np.linalg.norm(self.evaluate(uv) - points, axis=1)
        grid, places = self._grid
        start = self._starts(points)
        uv, found = self._descended(points, grid[start])
        away = np.linalg.norm(places[start] - points, axis=1)
        doubtful = (found > np.minimum(close, _DOUBTFUL * away)) | (2.0 * found > self._walls_at(uv))
        again = np.flatnonzero(doubtful & (away > 0.0) & np.isfinite(away))
        if len(again):
            other, distances = self._from_many_places(points[again])
            nearer = distances < found[again]
            uv[again[nearer]], found[again[nearer]] = other[nearer], distances[nearer]
        return uv, found

    def _walls_at(self, uv: FloatArray) -> FloatArray:
        """About how far (m,) the next wall is from places of this one: a point half as far away may be nearer to it."""
        u, v, far = self._walls
        i, j = (np.clip(np.searchsorted(line, at), 1, len(line) - 1) for line, at in zip((u, v), uv.T, strict=True))
        return np.asarray(np.minimum.reduce([far[i, j], far[i - 1, j], far[i, j - 1], far[i - 1, j - 1]]))

    @cached_property
    def _walls(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The grid's parameters (a,), (b,), and of each of its places (a, b) how far that is which faces elsewhere.

        Only what lies on one line of the grid is compared: across a thin tip it turns round.
        """
        grid, places = self._grid
        n = self._n_across
        corners, normals = places.reshape(-1, n, 3), self.normals(grid).reshape(-1, n, 3)
        far = np.full(corners.shape[:2], np.inf)
        other_walls(corners, normals, _MOST_STEPS, _TURNED, far)
        return grid[::n, 0], grid[:n, 1], far

    @property
    def _n_across(self) -> int:
        """Places of the grid with one u."""
        grid = self._grid[0]
        return int(np.count_nonzero(grid[:, 0] == grid[0, 0]))

    def _starts(self, points: FloatArray) -> IntArray:
        """Rows (m,) of the grid: the place nearest to each point."""
        grid, places = self._grid
        if len(points) * len(grid) <= _FEW:
            nearest = np.empty(len(points), dtype=np.int64)
            nearest_rows(places, _packed(points, 3), nearest)
            return nearest
        return np.asarray(self._tree.query(np.where(np.isfinite(points), points, 0.0))[1], dtype=np.int64)

    def _from_many_places(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Parameters (m, 2) and distances (m,) of the best of descents from several places on the lines of the grid.

        Its places alone would not do: of both walls of a thin tip that is twisted, those of one wall may be nearer all
        around. Nor would the nearest: they may all be on one coil, where the grid is fine.
        """
        grid, places = self._grid
        n = self._n_across
        rows = np.empty((len(points), 2, _PLACES), dtype=np.int64)
        shares = np.empty(rows.shape)
        points = _packed(points, 3)
        for axis in (0, 1):
            near_on_lines(places, n, axis, points, rows[:, axis], shares[:, axis])
        which = np.nonzero(rows >= 0)
        begin = rows[which]
        start = grid[begin]
        start += shares[which][:, None] * (grid[begin + np.where(which[1] == 0, n, 1)] - start)
        feet, distances = self._descended(points[which[0]], start)
        every, place = np.full(rows.shape, np.inf), np.zeros(rows.shape, dtype=np.int64)
        every[which], place[which] = distances, np.arange(len(begin))
        best = every.reshape(len(points), -1).argmin(axis=1)[:, None]
        best = np.take_along_axis(place.reshape(len(points), -1), best, axis=1)[:, 0]
        return feet[best], distances[best]

    def _descended(self, points: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest parameters and distances near start values (m, 2)."""
        lower, upper = self._reach
        if self._curved is not None:
            uv, distances = np.array(start, dtype=np.float64, order="C"), np.empty(len(points))
            descended_feet(self._curved, lower, upper, _packed(points, 3), uv, distances)
            return uv, distances
        if isinstance(self.geometry, Offset):
            # A surface and its offset have the same feet.
            uv = self._basis._descended(points, start)[0]
        else:
            uv = self._refine(points, start)
        return uv, np.linalg.norm(self.geometry.evaluate(uv) - points, axis=1)

    @cached_property
    def _basis(self) -> FaceSurface:
        """The same face of the surface that this one is an offset of."""
        assert isinstance(self.geometry, Offset)
        return replace(self, geometry=self.geometry.basis)

    @cached_property
    def _reach(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest parameters that are looked at: the face's box with a margin, within the limits."""
        width = self.box[1] - self.box[0]
        return np.maximum(self.limits[0], self.box[0] - 0.5 * width), np.minimum(
            self.limits[1], self.box[1] + 0.5 * width
        )

    @cached_property
    def _tree(self) -> scipy.spatial.cKDTree:
        """A tree of the places of the grid."""
        return scipy.spatial.cKDTree(self._grid[1])

    @cached_property
    def _grid(self) -> tuple[FloatArray, FloatArray]:
        """Parameters (g, 2) over the face's box, and the places (g, 3) there."""
        stops = []
        for low, high, knots in zip(*self.box, knots_of(self.geometry), strict=True):
            inner = knots[(knots > low) & (knots < high)]
            stops.append(np.concatenate([[low], inner[:: 1 + len(inner) // _MOST_GRID], [high]]))
        if self._curved is not None:
            u, v = (
                turning_stops(self._curved, own, other[[0, -1]], axis, _GRID - 1, _MOST_GRID, _LARGEST_TURN)
                for axis, (own, other) in enumerate((stops, stops[::-1]))
            )
            grid, places = np.empty((len(u) * len(v), 2)), np.empty((len(u) * len(v), 3))
            grid_places(self._curved, u, v, grid, places)
            return grid, places
        axes = [self._divided(stops[0], stops[1], 0), self._divided(stops[1], stops[0], 1)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        return grid, grid_points(self.geometry, *axes)

    def _divided(self, stops: FloatArray, across: FloatArray, axis: int) -> FloatArray:
        """Parameters along one axis, between which the surface hardly turns: no coil of a spring is missed."""
        fine = np.interp(np.arange(16 * (len(stops) - 1) + 1) / 16, np.arange(len(stops)), stops)
        lines = np.linspace(across[0], across[-1], 5)
        if axis == 0:
            places = grid_points(self.geometry, fine, lines).reshape(len(fine), 5, 3)
        else:
            places = grid_points(self.geometry, lines, fine).reshape(5, len(fine), 3).swapaxes(0, 1)
        steps = np.diff(places, axis=0)
        norms = np.linalg.norm(steps, axis=2)
        cosines = np.einsum("mld,mld->ml", steps[1:], steps[:-1]) / np.maximum(norms[1:] * norms[:-1], 1e-300)
        turns = np.arccos(np.clip(cosines, -1.0, 1.0)).max(axis=1, initial=0.0)
        total = float(turns.sum())
        n = int(np.clip(np.ceil(total / _LARGEST_TURN), _GRID - 1, _MOST_GRID))
        # Half of the parts go with the turns, half with the parameter.
        by_turn = np.concatenate([[0.0], np.cumsum(turns), [total]])
        share = np.linspace(0.0, 1.0, len(fine)) + (by_turn / total if total > 0 else 0.0)
        return np.interp(np.linspace(0.0, share[-1], n + 1), share, fine)

    def _refine(self, points: FloatArray, uv: FloatArray, n_steps: int = 50) -> FloatArray:
        """Gauss-Newton for the nearest points from `uv`; a step that does not come nearer is halved."""
        lower, upper = self._reach
        enough = 1e-13 * np.abs(self.box[1] - self.box[0]).max()
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
            moved = np.abs(new - uv[active]).max(axis=1) > enough
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
        curve = self.curves[edge].curve
        parameters = curve.parameters(np.atleast_1d(np.asarray(fractions, dtype=float)))
        points = curve.geometry.derivatives(parameters)[0]
        return self.edges_uv([edge], parameters[None], points[None])

    def edges_uv(self, edges: Sequence[int], parameters: FloatArray, points: FloatArray) -> FloatArray:
        """Parameters of several edges of this face, one after the other.

        Parameters
        ----------
        edges : sequence of n int
        parameters : (n, m) float64
            Each edge's own.
        points : (n, m, 3) float64
            The edge at these.

        Returns
        -------
        (n m, 2) float64
        """
        flat = points.reshape(-1, 3)
        if isinstance(self.geometry, Plane):
            return self.geometry.project(flat)
        records = self.edge_records
        if records is not None:
            rows = np.array([records.row[edge] for edge in edges])
            places = np.empty((*parameters.shape, 2))
            curve_points(
                records.values, records.starts[rows], records.shifts[rows], np.ascontiguousarray(parameters), places
            )
            return self._near(flat, places.reshape(-1, 2))
        known = [self.curves[edge].in_parameters for edge in edges]
        if any(curve is None for curve, _ in known):
            return np.concatenate(
                [
                    self._unrolled(self.in_branch(self.project(own)))
                    if curve is None
                    else self._near(own, curve.derivatives(at)[0] + shift)
                    for (curve, shift), at, own in zip(known, parameters, points, strict=True)
                ]
            )
        guess = np.concatenate(
            [
                curve.derivatives(at)[0] + shift
                for (curve, shift), at in zip(known, parameters, strict=True)
                if curve is not None
            ]
        )
        return self._near(flat, guess)

    def _near(self, points: FloatArray, guess: FloatArray) -> FloatArray:
        """Parameters (m, 2) of points (m, 3) of the surface in the branch of a guess."""
        if not isinstance(self.geometry, Cone | Torus):
            return self._descended(points, guess)[0]
        # At an apex or a pole the angle is free, and only the parameter curve knows it.
        uv = np.empty((len(points), 2))
        exact_feet(self._curved, self.box, _packed(points, 3), _packed(guess, 2), True, uv)
        return uv

    def _unrolled(self, uv: FloatArray) -> FloatArray:
        for j, period in enumerate(self.periods):
            if period is not None:
                uv[:, j] = np.unwrap(uv[:, j], period=period)
        return uv


def _rows(values: FloatArray, width: int) -> FloatArray:
    return np.asarray(values, dtype=float).reshape(-1, width)


def _packed(values: FloatArray, width: int) -> FloatArray:
    return np.ascontiguousarray(values, dtype=np.float64).reshape(-1, width)


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
