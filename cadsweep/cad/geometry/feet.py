"""Nearest points of a surface over the box of a face.

Where there is no closed form: the nearest of a grid of points over the box, finer where the surface turns, then
Gauss-Newton with halved steps (compiled where the surface has a record, :mod:`.records`; every point at once where it
has none). The result may leave the face (by a margin of its box), as the *surface* is asked for, not the trimmed face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from ...arrays import FloatArray, IntArray
from .feet_kernels import descended_feet, exact_feet, grid_places, turning_stops
from .nearest_kernels import block_boxes, near_on_lines, nearest_rows, other_walls
from .patch import Patch, packed
from .surfaces import ELEMENTARY, Cone, Offset, Plane, Torus, grid_points, knots_of

_GRID = 33
"""Places of the grid along each parameter, at least."""
_LARGEST_TURN = np.pi / 18
"""Turn of the surface between two places of the grid, at most, up to `_MOST_GRID` of them."""
_MOST_GRID = 1024
"""Places in each direction for first guesses: a helix of a hundred turns has ten a turn."""
_PLACES = 8
"""Places of the grid from which a doubtful point is looked for."""
_BLOCK = 4
"""Cells of the grid along either side of a block, of which whole ones are too far away to be looked at."""
_DOUBTFUL = 0.1
"""Distance of a foot over that of the place of the grid it was looked for from, beyond which it is looked for anew."""
_TURNED = 0.5
"""Cosine between normals beyond which they are of another wall, or of the tip between two."""
_MOST_STEPS = 40
"""Places of the grid along a line among which another wall is looked for: more are far away."""
_SAME_PLACE = 1e-9
"""Part of a box's width within which a knot is its end: trimmed there, the end is the knot but for its last digits, and
a whole interval of places between the two would be one place."""
_FEW = 200_000
"""Pairs of a point and a place of the grid up to which all are compared: a tree would take longer to be made."""


@dataclass(frozen=True, eq=False)
class Feet:
    """Looks for nearest points; what it learns of the surface on the way is kept.

    Attributes
    ----------
    patch : Patch
    """

    patch: Patch

    @property
    def is_exact(self) -> bool:
        """Whether nearest parameters have a closed form."""
        return isinstance(self.patch.geometry, ELEMENTARY)

    def nearest(self, points: FloatArray, *, close: float = np.inf) -> tuple[FloatArray, FloatArray]:
        """Nearest parameters (m, 2), and the distances there (m,).

        Where Newton's method hardly comes nearer than the place of the grid that it begins at, that may be on another
        coil than the nearest point is, or on the other wall of a thin tip; there, and where it ends farther away than
        `close`, it begins anew from other places of the grid.
        """
        if self.is_exact:
            if isinstance(self.patch.geometry, Plane):
                uv = self.patch.geometry.project(points)
            else:
                points = packed(points, 3)
                uv = np.empty((len(points), 2))
                exact_feet(self.patch.curved, self.patch.box, points, self.patch.box.mean(axis=0)[None], False, uv)
            return uv, np.linalg.norm(self.patch.evaluate(uv) - points, axis=1)
        grid, places = self._grid
        start = self._starts(points)
        uv, found = self._descended(points, grid[start])
        away = np.linalg.norm(places[start] - points, axis=1)
        doubtful = (found > np.minimum(close, _DOUBTFUL * away)) | (2.0 * found > self._walls_at(uv))
        again = np.flatnonzero(doubtful & (away > 0.0) & np.isfinite(away))
        if len(again):
            which, other, distances = self._from_many_places(points[again], uv[again], found[again])
            which = again[which]
            nearer = distances < found[which]
            uv[which[nearer]], found[which[nearer]] = other[nearer], distances[nearer]
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
        corners, normals = places.reshape(-1, n, 3), self._normals.reshape(-1, n, 3)
        far = np.full(corners.shape[:2], np.inf)
        other_walls(corners, normals, _MOST_STEPS, _TURNED, far)
        return grid[::n, 0], grid[:n, 1], far

    @property
    def _n_across(self) -> int:
        """Places of the grid with one u."""
        return self._placed[3]

    def _starts(self, points: FloatArray) -> IntArray:
        """Rows (m,) of the grid: the place nearest to each point."""
        grid, places = self._grid
        if len(points) * len(grid) <= _FEW:
            nearest = np.empty(len(points), dtype=np.int64)
            nearest_rows(places, packed(points, 3), nearest)
            return nearest
        return np.asarray(self._tree.query(np.where(np.isfinite(points), points, 0.0))[1], dtype=np.int64)

    def _from_many_places(
        self, points: FloatArray, uv: FloatArray, found: FloatArray
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """The best of descents from several places on the lines of the grid that may come nearer than what was found.

        Its places alone would not do: of both walls of a thin tip that is twisted, those of one wall may be nearer all
        around. Nor would the nearest: they may all be on one coil, where the grid is fine.

        Parameters
        ----------
        points : (m, 3) float64
        uv : (m, 2) float64
            Their feet that were found before.
        found : (m,) float64
            Their distances there.

        Returns
        -------
        rows : (k,) int64
            The points that there is another place for.
        uv : (k, 2) float64
        distances : (k,) float64
        """
        grid, places = self._grid
        n = self._n_across
        rows = np.empty((len(points), 2, _PLACES), dtype=np.int64)
        shares = np.empty(rows.shape)
        points = packed(points, 3)
        lines = grid[::n, 0], grid[:n, 1]
        cells = np.stack([np.searchsorted(line, at) - 1 for line, at in zip(lines, uv.T, strict=True)], axis=1)
        for axis in (0, 1):
            near_on_lines(places, n, axis, self._blocks, points, found, cells, rows[:, axis], shares[:, axis])
        which = np.nonzero(rows >= 0)
        begin = rows[which]
        start = grid[begin]
        start += shares[which][:, None] * (grid[begin + np.where(which[1] == 0, n, 1)] - start)
        feet, distances = self._descended(points[which[0]], start)
        order = np.lexsort((distances, which[0]))
        first = order[np.flatnonzero(np.diff(which[0][order], prepend=-1))]
        return which[0][first], feet[first], distances[first]

    @cached_property
    def _blocks(self) -> tuple[FloatArray, FloatArray, int]:
        """Boxes of blocks of the grid, the widest cell in each, and how many cells wide they are."""
        grid, places = self._grid
        n = self._n_across
        shape = tuple(max(1, -(-(count - 1) // _BLOCK)) for count in (len(grid) // n, n))
        boxes, widest = np.empty((*shape, 2, 3)), np.empty(shape)
        block_boxes(places, n, _BLOCK, boxes, widest)
        return boxes, widest, _BLOCK

    def _descended(self, points: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Nearest parameters and distances near start values (m, 2)."""
        lower, upper = self._reach
        if self.patch.curved is not None:
            uv, distances = np.array(start, dtype=np.float64, order="C"), np.empty(len(points))
            descended_feet(self.patch.curved, lower, upper, packed(points, 3), uv, distances)
            return uv, distances
        if isinstance(self.patch.geometry, Offset):
            # A surface and its offset have the same feet.
            uv = self._basis._descended(points, start)[0]
        else:
            uv = self._refine(points, start)
        return uv, np.linalg.norm(self.patch.geometry.evaluate(uv) - points, axis=1)

    @cached_property
    def _basis(self) -> Feet:
        """The same face of the surface that this one is an offset of."""
        assert isinstance(self.patch.geometry, Offset)
        return Feet(replace(self.patch, geometry=self.patch.geometry.basis))

    @cached_property
    def _reach(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest parameters that are looked at: the face's box with a margin, within the limits."""
        width = self.patch.box[1] - self.patch.box[0]
        return np.maximum(self.patch.limits[0], self.patch.box[0] - 0.5 * width), np.minimum(
            self.patch.limits[1], self.patch.box[1] + 0.5 * width
        )

    @cached_property
    def _tree(self) -> scipy.spatial.cKDTree:
        """A tree of the places of the grid."""
        return scipy.spatial.cKDTree(self._grid[1])

    @property
    def _grid(self) -> tuple[FloatArray, FloatArray]:
        """Parameters (g, 2) over the face's box, and the places (g, 3) there."""
        return self._placed[:2]

    @cached_property
    def _normals(self) -> FloatArray:
        """Unit normals (g, 3) at the grid's places, all to one side."""
        grid, _, normals, _ = self._placed
        if normals is None:
            return self.patch.normals(grid)
        singular = np.flatnonzero(~normals.any(axis=1))
        if len(singular):
            # Of a point nearby, which knows the sides of the solid: those of the others are the parameters'.
            normals[singular] = self.patch.outward * self.patch.normals(grid[singular])
        return normals

    @cached_property
    def _placed(self) -> tuple[FloatArray, FloatArray, FloatArray | None, int]:
        """The grid; normals (g, 3), 0 where it is singular, where the same loop gives them; its places with one u."""
        stops = []
        for low, high, knots in zip(*self.patch.box, knots_of(self.patch.geometry), strict=True):
            margin = _SAME_PLACE * (high - low)
            inner = knots[(knots > low + margin) & (knots < high - margin)]
            stops.append(np.concatenate([[low], inner[:: 1 + len(inner) // _MOST_GRID], [high]]))
        if self.patch.curved is not None:
            u, v = (
                turning_stops(self.patch.curved, own, other[[0, -1]], axis, _GRID - 1, _MOST_GRID, _LARGEST_TURN)
                for axis, (own, other) in enumerate((stops, stops[::-1]))
            )
            grid, places, normals = (np.empty((len(u) * len(v), width)) for width in (2, 3, 3))
            grid_places(self.patch.curved, u, v, grid, places, normals)
            return grid, places, normals, len(v)
        axes = [self._divided(stops[0], stops[1], 0), self._divided(stops[1], stops[0], 1)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        return grid, grid_points(self.patch.geometry, *axes), None, len(axes[1])

    def _divided(self, stops: FloatArray, across: FloatArray, axis: int) -> FloatArray:
        """Parameters along one axis, between which the surface hardly turns: no coil of a spring is missed."""
        fine = np.interp(np.arange(16 * (len(stops) - 1) + 1) / 16, np.arange(len(stops)), stops)
        lines = np.linspace(across[0], across[-1], 5)
        if axis == 0:
            places = grid_points(self.patch.geometry, fine, lines).reshape(len(fine), 5, 3)
        else:
            places = grid_points(self.patch.geometry, lines, fine).reshape(5, len(fine), 3).swapaxes(0, 1)
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
        enough = 1e-13 * np.abs(self.patch.box[1] - self.patch.box[0]).max()
        uv = np.array(uv, dtype=float)
        active = np.arange(len(uv))
        for _ in range(n_steps):
            place, by_u, by_v = self.patch.geometry.derivatives(uv[active])
            off = points[active] - place
            distance = np.einsum("md,md->m", off, off)
            step = _least_squares_step(by_u, by_v, off)
            new = np.clip(uv[active] + step, lower, upper)
            worse = np.arange(len(active))
            for _halving in range(8):
                off = points[active[worse]] - self.patch.geometry.evaluate(new[worse])
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

    def near(self, points: FloatArray, guess: FloatArray) -> FloatArray:
        """Parameters (m, 2) of points (m, 3) of the surface in the branch of a guess."""
        if not isinstance(self.patch.geometry, Cone | Torus):
            return self._descended(points, guess)[0]
        # At an apex or a pole the angle is free, and only the parameter curve knows it.
        uv = np.empty((len(points), 2))
        exact_feet(self.patch.curved, self.patch.box, packed(points, 3), packed(guess, 2), True, uv)
        return uv


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
