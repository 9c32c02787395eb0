"""The grid: planes on the part's own planes, vertices and extremes, cells kept where they are inside, made manifold.

What is inside is told by rays along the three axes through facets of the faces, two of three agreeing: facets of two
faces need not meet along a curved edge, and a ray may slip through there.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Solid
from ..cells import HEX_FACES
from ..compiled import compiled
from ..errors import SurfaceMeshError
from .facets import Facets, sampled

_ALIGNED = 1e-6
"""Sine of the angle up to which a plane face is normal to an axis."""
_CLOSEST = (0.35, 0.6, 0.75)
"""Distance of two planes of the grid over the size: of those on plane faces, on vertices, on extremes of edges."""
_ACROSS = 2.0
"""Cells across what is narrow."""
_FINEST = 0.2
"""Least distance of two planes over the size; what is narrower than that has no two cells across."""
_GROWTH = 0.3
"""By how much the distance of planes grows over the way."""
_FACING = 0.8
"""Cosine of the angle with an axis up to which a facet bounds what is narrow along it."""
_SAMPLED, _BIN = 0.2, 0.05
"""Distance of samples of a facet, and the step in which places along an axis are told apart, over the size."""
_MOST_MENDED = 200
"""Rounds of mending until the skin is manifold; each adds or takes away a cell at every bad place."""


class Grid(NamedTuple):
    """Hexahedra (m, 8) of points (n, 3), and the quads (q, 4) of their skin, outward."""

    points: FloatArray
    hexes: IntArray
    quads: IntArray


def choose_planes(
    solid: Solid,
    facets: Facets,
    axes: FloatArray,
    size: float,
    *,
    narrow: bool = False,
    finer: tuple[FloatArray, FloatArray] | None = None,
) -> list[FloatArray]:
    """Coordinates of the grid's planes along each of its axes, one more on either side of the part.

    Parameters
    ----------
    solid : Solid
    facets : Facets
        Of its faces.
    axes : (3, 3) float
        The grid's, each a row.
    size : float
        Distance of two planes.
    narrow : bool
        Lay planes closer where the part is narrow along their axis.
    finer : (k, 3) and (k,) float64, optional
        Places, and how far apart planes may be there.
    """
    planes: list[FloatArray] = []
    for n, axis in enumerate(axes):
        own = facets.points @ axis
        low, high = float(own.min()), float(own.max())
        spans = narrow_spans(solid, facets, axes, n, size) if narrow else np.empty((0, 2))
        steps = np.maximum(np.ptp(spans, axis=1) / _ACROSS, _FINEST * size)
        if finer is not None:
            spans = np.concatenate([spans, np.repeat(finer[0] @ axis, 2).reshape(-1, 2)])
            steps = np.concatenate([steps, finer[1]])
        apart_at = _Steps(low, high, spans, steps, size)
        flat = [
            (face.area, float(face.center @ axis))
            for face in solid.faces
            if face.kind == "plane" and 1.0 - abs(face.normal @ axis) < _ALIGNED
        ]
        wanted: list[tuple[float, float]] = [(x, _CLOSEST[0]) for _, x in sorted(flat, reverse=True)]
        wanted += [(low, _CLOSEST[1]), (high, _CLOSEST[1])]
        wanted += [(float(x), _CLOSEST[1]) for x in solid.vertices @ axis]
        along = np.linspace(0.0, 1.0, 17)
        for edge in solid.edges:
            if edge.kind != "line":
                own = edge.curve.evaluate(along) @ axis
                wanted += [(float(own.min()), _CLOSEST[2]), (float(own.max()), _CLOSEST[2])]
        kept: list[float] = []
        for x, apart in wanted:
            near = apart * apart_at.at(x)
            if all(abs(x - other) > near for other in kept):
                kept.append(x)
        kept.sort()
        laid = [kept[0] - apart_at.at(kept[0])]
        for start, end in itertools.pairwise(kept):
            laid += apart_at.between(start, end).tolist()
        planes.append(np.array([*laid, kept[-1], kept[-1] + apart_at.at(kept[-1])]))
    return planes


class _Steps:
    """Distance of planes along an axis: the size, less in spans (s, 2) of less each, and growing slowly from there."""

    def __init__(self, low: float, high: float, spans: FloatArray, steps: FloatArray, size: float) -> None:
        n = max(1, int(np.ceil((high - low) / (_BIN * size))))
        self.ends = np.linspace(low, high, n + 1)
        width = (high - low) / n
        own = np.full(n, size)
        at = np.clip(((spans - low) / width).astype(np.int64), 0, n - 1)
        places, which = np.unique(at, axis=0, return_inverse=True)
        least = np.full(len(places), size)
        np.minimum.at(least, which.ravel(), steps)
        for (first, last), step in zip(places, least, strict=True):
            np.minimum(own[first : last + 1], step, out=own[first : last + 1])
        rise = _GROWTH * width * np.arange(n)
        for _ in range(2):
            own = (np.minimum.accumulate(own - rise) + rise)[::-1]
        self.own, self.sum = own, np.append(0.0, np.cumsum(width / own))

    def at(self, x: float) -> float:
        return float(self.own[np.clip(np.searchsorted(self.ends, x, "right") - 1, 0, len(self.own) - 1)])

    def between(self, low: float, high: float) -> FloatArray:
        """Planes from one to before the next."""
        first, last = np.interp([low, high], self.ends, self.sum)
        n = max(
            1, round(round(last - first, 9))
        )  # halves, which coordinates often make, as without an error of addition
        return np.append(low, np.interp(np.linspace(first, last, n + 1)[1:-1], self.sum, self.ends))


def narrow_spans(solid: Solid, facets: Facets, axes: FloatArray, axis: int, size: float) -> FloatArray:
    """From and to (s, 2) along an axis: edges, walls and gaps between faces across it, shorter than two cells.

    Samples of the facets that look along the axis are sorted into columns; neighbours in one that look opposite ways
    are the two sides of a wall or of a gap.
    """
    facets = facets.along(axes)
    heights = solid.vertices @ axes[axis]
    ends = heights[np.array([(edge.start, edge.end) for edge in solid.edges], dtype=np.int64).reshape(-1, 2)]
    ends = np.sort(ends[[edge.length < _ACROSS * size for edge in solid.edges]], axis=1)
    corners = facets.points[facets.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    across = np.abs(normals[:, axis]) > _FACING * np.maximum(lengths, 1e-300)
    apart = _SAMPLED * size
    samples, owners = sampled(corners[across], apart)
    upward = normals[across][owners, axis] > 0
    at = np.floor(np.delete(samples, axis, axis=1) / apart).astype(np.int64)
    order = np.lexsort((samples[:, axis], at[:, 1], at[:, 0]))
    at, height, upward = at[order], samples[order, axis], upward[order]
    pair = (at[1:] == at[:-1]).all(axis=1) & (upward[1:] != upward[:-1])
    spans = np.concatenate([np.stack([height[:-1][pair], height[1:][pair]], axis=1), ends])
    length = spans[:, 1] - spans[:, 0]
    fits = (length < _ACROSS * size) & (length > _FINEST * size)
    return np.unique(np.round(spans[fits] / (_BIN * size)), axis=0) * _BIN * size


def keep_inside(planes: list[FloatArray], facets: Facets, axes: FloatArray) -> Grid:
    """Keep cells between planes across some axes whose middle is inside, and mend where the skin is not manifold.

    Raises
    ------
    SurfaceMeshError
        No cell is inside, or the skin cannot be made manifold.
    """
    facets = facets.along(axes)
    middles = [0.5 * (own[1:] + own[:-1]) for own in planes]
    votes = np.zeros([len(own) for own in middles], dtype=np.int64)
    for axis in range(3):
        turned = [(axis + 1) % 3, (axis + 2) % 3, axis]
        corners = facets.points[facets.triangles][:, :, turned]
        inside = np.zeros([len(middles[d]) for d in turned], dtype=np.bool_)
        # A hair beside the middle: facets' own vertices often lie on it, and a ray through one may be counted twice.
        hair = [1.37e-7, 2.41e-7]
        rays = [middles[d] + h * np.ptp(planes[d]) for d, h in zip(turned, hair, strict=False)]
        _cross(corners, rays[0], rays[1], middles[axis], inside)
        votes += np.transpose(inside, np.argsort(turned))
    kept = _manifold(votes >= 2)
    if not kept.any():
        raise SurfaceMeshError("no cell of the grid is inside")
    points, hexes, quads = _grid(planes, kept)
    return Grid(points @ axes, hexes, quads)


@compiled(cache=True)
def _cross(corners, xs, ys, zs, inside):  # type: ignore[no-untyped-def]
    """Flip what lies above each triangle, ray by ray."""
    for t in range(corners.shape[0]):
        ax, ay, az = corners[t, 0]
        bx, by, bz = corners[t, 1]
        cx, cy, cz = corners[t, 2]
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0.0:
            continue
        i0, i1 = np.searchsorted(xs, min(ax, bx, cx)), np.searchsorted(xs, max(ax, bx, cx))
        j0, j1 = np.searchsorted(ys, min(ay, by, cy)), np.searchsorted(ys, max(ay, by, cy))
        for i in range(i0, i1):
            for j in range(j0, j1):
                u = ((bx - xs[i]) * (cy - ys[j]) - (by - ys[j]) * (cx - xs[i])) / area
                v = ((cx - xs[i]) * (ay - ys[j]) - (cy - ys[j]) * (ax - xs[i])) / area
                w = 1.0 - u - v
                if u >= 0.0 and v >= 0.0 and w >= 0.0:
                    z = u * az + v * bz + w * cz
                    for k in range(np.searchsorted(zs, z), len(zs)):
                        inside[i, j, k] = not inside[i, j, k]


def _manifold(kept: np.ndarray) -> np.ndarray:
    """The largest connected piece, cells added where two touch along an edge or at a corner alone."""
    from scipy.ndimage import label

    kept = kept.copy()
    for _ in range(_MOST_MENDED):
        pieces, n = label(kept)
        if n > 1:
            kept = pieces == 1 + int(np.argmax(np.bincount(pieces.ravel())[1:]))
        bad = _bad_corner(kept)
        if bad is None:
            return kept
        kept[bad] = True
    raise SurfaceMeshError("the skin of the grid cannot be made manifold")


def _bad_corner(kept: np.ndarray) -> tuple[IntArray, IntArray, IntArray] | None:
    """A missing cell at every corner around which the cells inside, or those outside, do not hang together."""
    nx, ny, nz = kept.shape
    around = np.stack(
        [kept[i : nx - 1 + i, j : ny - 1 + j, k : nz - 1 + k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    )
    code = np.tensordot(1 << np.arange(8), around.astype(np.int64), axes=1)
    at = np.argwhere(_FILL[code] >= 0)
    if not len(at):
        return None
    rows: dict[tuple[int, int, int], None] = {}
    touched: set[tuple[int, int, int]] = set()
    for i, j, k in at.tolist():
        if any((i + a, j + b, k + c) in touched for a in (0, 1) for b in (0, 1) for c in (0, 1)):
            continue  # the cell that is added beside it may have mended it
        fill = int(_FILL[code[i, j, k]])
        cell = (i + (fill >> 2 & 1), j + (fill >> 1 & 1), k + (fill & 1))
        rows[cell] = None
        touched |= {(i + a, j + b, k + c) for a in (0, 1) for b in (0, 1) for c in (0, 1)}
    found = np.array(list(rows), dtype=np.int64)
    return found[:, 0], found[:, 1], found[:, 2]


def _hangs_together(cells: set[int]) -> bool:
    left, front = set(cells), [next(iter(cells))] if cells else []
    while front:
        one = front.pop()
        if one in left:
            left.discard(one)
            front += [one ^ bit for bit in (1, 2, 4) if one ^ bit in left]
    return not left


def _fills() -> IntArray:
    """For each of 256 ways to have cells around a corner: which one to add, -1 where the skin is manifold there."""
    good = [
        _hangs_together({c for c in range(8) if code >> c & 1})
        and _hangs_together({c for c in range(8) if not code >> c & 1})
        for code in range(256)
    ]
    fills = np.full(256, -1, dtype=np.int64)
    for code in range(256):
        if not good[code]:
            missing = [c for c in range(8) if not code >> c & 1]
            mended = [c for c in missing if good[code | 1 << c]]
            # Where one does not do, the one with most neighbours: another round adds the next.
            fills[code] = (
                mended[0] if mended else max(missing, key=lambda c: sum(code >> (c ^ b) & 1 for b in (1, 2, 4)))
            )
    return fills


_FILL = _fills()


def _grid(planes: list[FloatArray], kept: np.ndarray) -> Grid:
    """Nodes and hexahedra of the cells that are kept, and their skin."""
    shape = tuple(len(own) for own in planes)
    i, j, k = np.nonzero(kept)
    steps = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    hexes = np.stack([np.ravel_multi_index((i + a, j + b, k + c), shape) for a, b, c in steps], axis=1)
    is_used = np.zeros(shape, dtype=bool)
    is_used.ravel()[hexes] = True
    hexes = (np.cumsum(is_used) - 1)[hexes]
    points = np.stack([own[index] for own, index in zip(planes, np.nonzero(is_used), strict=True)], axis=1)
    beyond = np.rint(2.0 * np.array(steps)[np.array(HEX_FACES)].mean(axis=1) - 1.0).astype(np.int64)
    around = np.pad(kept, 1)
    bare = np.stack([~around[i + 1 + a, j + 1 + b, k + 1 + c] for a, b, c in beyond.tolist()], axis=1)
    return Grid(points, hexes, hexes[:, HEX_FACES][bare])
