"""Holes in a lattice of quads: each takes a rectangle of as many cells around as it has segments.

Place in the flow: for :mod:`.structured` and :mod:`.disc_lattice`.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from ..brep import quarter_turns
from .background import triangulated
from .chart import Chart
from .lattice import CELL, numbered, places_around
from .outline import SMOOTH, Outline

_AROUND = 4.0
"""Nodes of the lattice around a hole, in its longest segments, that tell where in the lattice its own nodes lie."""
_FEWEST = 100
"""Nodes, the nearest ones, that are asked where fewer are so near; all are where the hole reaches out of these."""
_LEAST = 4
"""Segments of a hole that can take a rectangle, of one cell."""
_MOST = 2000
"""Nodes up to which all those inside a hole are asked, too: triangles of more take longer than the rest."""
_CELLS_AT = 4
"""Nodes of the lattice next to a point whose cells are looked at for it."""
_AT_ONCE = 100_000
"""Nodes that are held against others at once."""
_EVEN = 1e-9
"""Steps of a lattice by which its nodes may be off equal ones: no triangles are needed to look for holes there."""
_TIE = 1e-6
"""Cells of the lattice by which a place is nearer than another only by rounding."""


def pierce(
    outline: Outline, chart: Chart, number: IntArray, cells: IntArray, whole: FloatArray
) -> tuple[IntArray, IntArray] | None:
    """Numbers and cells once the holes have taken their places; None where one has none.

    Each hole takes a rectangle of the lattice, as many cells around as it has segments, about where its middle lies
    among the nodes of the lattice without it, at `whole` (n, 2).
    """
    n_outer = len(outline.nodes[0])
    places = np.argwhere(number >= 0)
    order = number[places[:, 0], places[:, 1]]
    even = _even_lattice(whole[order], places)
    lattice = scipy.spatial.cKDTree(whole[order]) if even is None else None
    is_cell = np.zeros(number.shape, dtype=np.bool_)
    is_cell[cells[:, 0], cells[:, 1]] = True
    taken = np.where((number >= 0) & (number < n_outer), number, -1)
    first = n_outer
    for j in range(1, len(outline.loops)):
        hole = chart.boundary[j]
        own = (hole - even[0]) @ even[1] if even is not None else _places_in_lattice(hole, lattice, places)
        corners = _hole_corners(outline, j, own)
        if not np.isfinite(own).all() or corners is None or len(own) < _LEAST:
            return None
        begin, q, p, low = _placed(own, *corners, np.array(number.shape) - 1, may_differ=_is_round(outline, j))
        around = low + places_around(p, q)
        x, y = around.T
        # A cell more on each side: quads with all their nodes on outlines could give way to nothing.
        beside = (slice(low[0] - 1, low[0] + p + 2), slice(low[1] - 1, low[1] + q + 2))
        if low.min() < 1 or taken[beside].size < (p + 3) * (q + 3) or (taken[beside] >= 0).any():
            return None
        within = (slice(low[0], low[0] + p), slice(low[1], low[1] + q))
        if (number[beside] < 0).any() or not is_cell[within].all():
            return None
        taken[x, y] = first + (begin + np.arange(len(own))) % len(own)
        is_cell[within] = False
        first += len(own)
    cells = np.argwhere(is_cell)
    return numbered(taken, cells, first), cells


def _even_lattice(nodes: FloatArray, places: IntArray) -> tuple[FloatArray, FloatArray] | None:
    """Origin (2,) and inverse of the steps (2, 2) of a lattice whose nodes (n, 2) are all equally apart; else None."""
    columns = np.column_stack([np.ones(len(places)), places])
    found = np.linalg.lstsq(columns, nodes, rcond=None)[0]
    step = float(np.linalg.norm(found[1:], axis=1).min())
    if np.abs(columns @ found - nodes).max() > _EVEN * step or np.linalg.matrix_rank(found[1:]) < 2:
        return None
    return found[0], np.linalg.inv(found[1:])


def _places_in_lattice(hole: FloatArray, lattice: scipy.spatial.cKDTree, places: IntArray) -> FloatArray:
    """Lattice places (m, 2) of the nodes of a hole, between those (n, 2) of the nodes around it; NaN outside of all."""
    middle = hole.mean(axis=0)
    segment = float(np.linalg.norm(np.roll(hole, -1, axis=0) - hole, axis=1).max())
    reach = float(np.linalg.norm(hole - middle, axis=1).max()) + _AROUND * segment
    # Triangles of all nodes take longer than all the rest where a face has ten thousands.
    near = np.array(lattice.query_ball_point(middle, reach, return_sorted=True), dtype=np.int64)
    if len(near) > _MOST:
        found = _in_cells(hole, lattice, places)
        if np.isfinite(found).all():
            return found
        # Those along its outline: what the others inside of it are is not asked.
        beside = lattice.query_ball_point(hole, _AROUND * segment)
        near = distinct(np.concatenate([np.asarray(own, dtype=np.int64) for own in beside]))
    if len(near) < _FEWEST:
        near = np.sort(lattice.query(middle, min(_FEWEST, lattice.n))[1])
    found = _interpolated(hole, lattice.data[near], places[near])
    return found if np.isfinite(found).all() else _interpolated(hole, lattice.data, places)


def _interpolated(at: FloatArray, nodes: FloatArray, places: IntArray) -> FloatArray:
    """Lattice places (m, 2) at points (m, 2), linear in the triangles of nodes (n, 2); NaN outside of these.

    scipy's own interpolation asks LAPACK once for every triangle: on a busy machine its threads wait for each other
    for seconds.
    """
    triangles = triangulated(nodes)
    a, b, c = (nodes[triangles[:, j]] for j in range(3))
    along, across = b - a, c - a
    twice = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    found = np.full((len(at), 2), np.nan)
    for j, point in enumerate(at):
        to = point - a
        with np.errstate(divide="ignore", invalid="ignore"):
            second = (to[:, 0] * across[:, 1] - to[:, 1] * across[:, 0]) / twice
            third = (along[:, 0] * to[:, 1] - along[:, 1] * to[:, 0]) / twice
            least = np.nan_to_num(np.minimum(np.minimum(second, third), 1.0 - second - third), nan=-np.inf)
        k = int(least.argmax())
        if least[k] >= -_TIE:
            weights = np.array([1.0 - second[k] - third[k], second[k], third[k]])
            found[j] = weights @ places[triangles[k]]
    return found


def _in_cells(at: FloatArray, lattice: scipy.spatial.cKDTree, places: IntArray) -> FloatArray:
    """Lattice places (m, 2) at points (m, 2), linear in the two triangles of each cell; NaN where none was found.

    Only cells at the nodes next to a point are looked at: triangles of all nodes would be made first.
    """
    number = np.full(places.max(axis=0) + 2, -1, dtype=np.int64)
    number[places[:, 0], places[:, 1]] = np.arange(len(places))
    near = places[lattice.query(at, _CELLS_AT)[1]]
    lows = (near[:, :, None] - CELL).reshape(len(at), -1, 2)
    corners = number[tuple(np.moveaxis(lows[:, :, None] + CELL, -1, 0))]
    found = np.full((len(at), 2), np.nan)
    for triangle in ([0, 1, 2], [0, 2, 3]):
        nodes = corners[:, :, triangle]
        a, b, c = np.moveaxis(lattice.data[nodes], 2, 0)
        along, across, to = b - a, c - a, at[:, None] - a
        twice = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            second = (to[..., 0] * across[..., 1] - to[..., 1] * across[..., 0]) / twice
            third = (along[..., 0] * to[..., 1] - along[..., 1] * to[..., 0]) / twice
            least = np.minimum(np.minimum(second, third), 1.0 - second - third)
        inside = (nodes >= 0).all(axis=2) & (least >= -_TIE)
        rows = np.flatnonzero(inside.any(axis=1) & np.isnan(found[:, 0]))
        which = np.argmax(inside[rows], axis=1)
        steps = CELL[triangle[1:]] - CELL[0]
        weights = np.stack([second[rows, which], third[rows, which]], axis=1)
        found[rows] = lows[rows, which] + weights @ steps
    return found


def _placed(
    own: FloatArray, begin: int, q: int, p: int, size: IntArray, *, may_differ: bool
) -> tuple[int, int, int, IntArray]:
    """Where a hole's rectangle begins among its nodes, its cells up and across, and its lower left place.

    Of a round hole (`may_differ`) a cell more or less up, and other corners, are tried: its nodes shall lie as those
    of the rectangle do, and in the middle of the lattice of `size` cells the rectangle, too. What is half way between
    two places lies at the one nearer to the lattice's middle: what is symmetric stays so.
    """
    middle = own.mean(axis=0)
    off = own - middle
    n = len(own)
    best: tuple[float, float, int, int, IntArray] | None = None
    extents = np.abs(off).max(axis=0)
    # Holes that are alike have the same choice, whatever rounding made of their corners.
    wanted = n / 2.0 * float(extents[1] / extents.sum()) if may_differ else float(q)
    first, last = int(np.ceil(wanted - 1.0 - _TIE)), int(np.floor(wanted + 1.0 + _TIE))
    for up in range(first, last + 1) if may_differ else (q,):
        across = n // 2 - up
        if min(up, across) < 1:
            continue
        half = np.array([across, up]) / 2.0
        square = places_around(across, up) - half
        # As seen from its middle, in the shape of the rectangle.
        seen = off / extents * half
        shift = middle - half
        low = np.where(
            np.abs(shift - np.floor(shift) - 0.5) < _TIE,
            np.where(middle > size / 2.0 + _TIE, np.floor(shift), np.ceil(shift)),
            np.round(shift),
        )
        aside = float(np.count_nonzero((np.abs(middle - size / 2.0) < _TIE) & (np.abs(low - shift) > _TIE)))
        starts = np.arange(n) if may_differ else np.array([begin])
        apart = _apart(seen, square, starts)
        for k, far in zip(starts.tolist(), apart.tolist(), strict=True):
            found = (round(far + aside, 6), round(abs(up - wanted), 6), up, k, low.astype(np.int64))
            if best is None or found[:4] < best[:4]:
                best = found
    assert best is not None
    return best[3], best[2], n // 2 - best[2], best[4]


def _apart(ring: FloatArray, other: FloatArray, starts: IntArray) -> FloatArray:
    """Mean squared distances of the nodes (n, 2) of two rings, for each node of the first that the second begins at."""
    n = len(ring)
    found = np.empty(len(starts))
    step = max(1, _AT_ONCE // n)
    for low in range(0, len(starts), step):
        rolled = ring[(starts[low : low + step, None] + np.arange(n)) % n]
        found[low : low + step] = ((rolled - other) ** 2).sum(axis=2).mean(axis=1)
    return found


def _is_round(outline: Outline, loop: int) -> bool:
    return all(abs(angle - np.pi) <= SMOOTH for angle in outline.angles(outline.loops[loop]))


def _hole_corners(outline: Outline, loop: int, places: FloatArray) -> tuple[int, int, int] | None:
    """The hole's node at the lower left of its rectangle, and the segments up and across from there."""
    n, angles = len(places), outline.angles(outline.loops[loop])
    if n % 2:
        return None
    if _is_round(outline, loop):
        off = places - places.mean(axis=0)
        x, y = (off / np.abs(off).max(axis=0)).T
        corners = [int(np.argmax(a * x + b * y)) for a, b in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
        sides = [(b - a) % n for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)]
        up = int(np.clip(round((sides[0] + sides[2]) / 2.0), 1, n // 2 - 1))
        return corners[0], up, n // 2 - up
    turns = quarter_turns(angles)
    if turns is None or sum(turns) != -4 or turns.count(-1) != 4:
        return None
    at = np.concatenate([[0], np.cumsum([int(outline.counts[e]) for e, _ in outline.loops[loop]])])[:-1]
    found = at[np.array(turns) == -1]
    start = int(np.argmin(places[found].sum(axis=1)))
    found = np.roll(found, -start)
    sides = [int((b - a) % n) for a, b in zip(found, np.roll(found, -1), strict=True)]
    return (int(found[0]), sides[0], sides[1]) if sides[:2] == sides[2:] else None
