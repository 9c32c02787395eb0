r"""Quads of a ring with holes in it, as of a flange: a lattice that closes around the bore, with the holes taken out.

Place in the flow: one of the ways of :mod:`.filling`.

Method: where the bore has as many nodes as the rim, circles and rays between them are a lattice of n cells around.
Each hole takes a rectangle of as many cells around as it has segments, laid so that the hole's innermost node (or
segment) is in the middle of a side: what is alike about the middle of the ring is alike in the mesh, which has no
irregular node inside. Inner nodes stand at the mean of their neighbours, and keep the mirrors of the outline::

      o-----o-----o-----o      rim
      |    / \ _ / \    |
      o---o  (   )  o---o      a hole of 2 x 1 cells
      |    \_/ - \_/    |
      o-----o-----o-----o      bore

Not handled: holes that are as near to each other or to a circle as a cell is long, bores with corners.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..polygons import signed_area
from .chart import Chart
from .embedding import embedded, evened
from .lattice import places_around
from .outline import SMOOTH, FaceQuads, Outline
from .symmetric import carried_by_mirrors
from .symmetry import find_wedges

_TRIED = tuple((rows, across) for rows in (0, 1, -1, 2) for across in (0, 2, -2))
"""Rows more than the ring's width asks for, and cells more across a hole than along its outline, that are tried."""
_ENOUGH = 0.75
"""Worst corner sine from which on no other number of rows is tried."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ring:
    """A ring's nodes in its chart: `rim` and `bore` (n, 2), counter-clockwise and alike numbered, with their ids."""

    rim: FloatArray
    bore: FloatArray
    rim_ids: IntArray
    bore_ids: IntArray
    holes: list[tuple[FloatArray, IntArray]]


def fill_ring(outline: Outline) -> FaceQuads | None:
    """A lattice around the bore of a face with more holes; None where it has none, or the holes do not fit."""
    if len(outline.loops) < 3 or outline.grows():
        return None
    chart = next(outline.charts(outline.nodes), None)
    ring = None if chart is None else _ring_of(outline, chart)
    if chart is None or ring is None:
        return None
    segment = float(np.mean([np.linalg.norm(np.roll(p, -1, axis=0) - p, axis=1).mean() for p in (ring.rim, ring.bore)]))
    width = (signed_area(ring.rim) - signed_area(ring.bore)) / (len(ring.rim) * segment)
    best: FaceQuads | None = None
    for more, across in _TRIED:
        found = pierced(ring, max(3, round(width / segment) + more), across)
        made = None if found is None else with_mirrors(outline, chart, *found)
        if made is not None and (best is None or made.better_than(best)):
            best = made
        if best is not None and best.enough(_ENOUGH):
            break
    return best


def _ring_of(outline: Outline, chart: Chart) -> Ring | None:
    """The ring between the outer loop and the largest hole; None where they are no circles of equally many nodes."""
    smooth = [all(abs(angle - np.pi) <= SMOOTH for angle in outline.angles(loop)) for loop in outline.loops]
    inner = range(1, len(outline.loops))
    bore = max(inner, key=lambda j: -signed_area(chart.boundary[j]))
    rim, hole = chart.boundary[0], chart.boundary[bore][::-1]
    if not smooth[0] or not smooth[bore] or len(rim) != len(hole):
        return None
    firsts = np.cumsum([0, *(len(loop) for loop in chart.boundary)])
    ids = [np.arange(firsts[j], firsts[j + 1]) for j in range(len(chart.boundary))]
    turn = int(np.argmin([np.linalg.norm(rim - np.roll(hole, -k, axis=0)) for k in range(len(rim))]))
    return Ring(
        rim=rim,
        bore=np.roll(hole, -turn, axis=0),
        rim_ids=ids[0],
        bore_ids=np.roll(ids[bore][::-1], -turn),
        # Around and outwards is the other way round than x and y: the holes run clockwise there.
        holes=[(chart.boundary[j][::-1], ids[j][::-1]) for j in inner if j != bore],
    )


def pierced(
    ring: Ring, rows: int, across: int, heights: FloatArray | None = None, *, first: int | None = None
) -> tuple[int, IntArray] | None:
    """Number of inner nodes, and quads in ids of the outline's nodes and then of these; None where a hole has no place.

    The lattice runs around (the first index, which closes) and from the bore to the rim (the second). `heights`
    (rows + 1,): where its circles are, as parts of the way from the bore to the rim; evenly without. `first`: the
    number of the first inner node, where the nodes of the outline are not the last ones before it.
    """
    n = len(ring.rim)
    number = np.full((n, rows + 1), -1, dtype=np.int64)
    number[:, 0], number[:, -1] = ring.bore_ids, ring.rim_ids
    is_cell = np.ones((n, rows), dtype=np.bool_)
    for hole, ids in ring.holes:
        own = _in_lattice(ring, hole)
        if own is None or len(ids) % 2:
            return None
        if heights is not None and own[:, 1].min() <= heights[0]:
            return None
        own[:, 1] = rows * own[:, 1] if heights is None else np.interp(own[:, 1], heights, np.arange(rows + 1.0))
        # A hole all beyond the last row has no extent there.
        begin, p, q = _rectangle(own, across) if np.ptp(own, axis=0).all() else (0, 0, 0)
        if min(p, q) < 1:
            return None
        low = np.rint((own.max(axis=0) + own.min(axis=0)) / 2.0 - np.array([p, q]) / 2.0).astype(np.int64)
        if low[1] < 1 or low[1] + q > rows - 1:
            return None
        beside = np.ix_(np.arange(low[0] - 1, low[0] + p + 2) % n, np.arange(low[1], low[1] + q + 1))
        within = np.ix_(np.arange(low[0], low[0] + p) % n, np.arange(low[1], low[1] + q))
        if (number[beside] >= 0).any() or not is_cell[within].all():
            return None
        corners = (low + places_around(p, q)) % np.array([n, rows + 1])
        number[corners[:, 0], corners[:, 1]] = ids[(begin + np.arange(len(ids))) % len(ids)]
        is_cell[within] = False
    return _numbered(number, is_cell, sum(len(ids) for _, ids in ring.holes) + 2 * n if first is None else first)


def _in_lattice(ring: Ring, hole: FloatArray) -> FloatArray | None:
    """Where a hole's nodes (m, 2) lie among rays, running on through the last one, and on their way; None if outside.

    Exact but for rounding under whatever carries the ring to itself, as holes that are alike must lie alike.
    """
    n = len(ring.rim)
    way, off = ring.rim - ring.bore, hole[:, None] - ring.bore
    beside = way[:, 0] * off[..., 1] - way[:, 1] * off[..., 0]
    passed = (beside >= 0) & (np.roll(beside, -1, axis=1) < 0) & ((way * off).sum(axis=-1) > 0)
    if not (passed.sum(axis=1) == 1).all():
        return None
    rows_of, ray = np.arange(len(hole)), passed.argmax(axis=1)
    here, there = beside[rows_of, ray], beside[rows_of, (ray + 1) % n]
    part = (here / (here - there))[:, None]
    start = (1.0 - part) * ring.bore[ray] + part * ring.bore[(ray + 1) % n]
    along = (1.0 - part) * way[ray] + part * way[(ray + 1) % n]
    up = ((hole - start) * along).sum(axis=1) / (along**2).sum(axis=1)
    around = ray + part[:, 0]
    around -= n * np.round((around - around[0]) / n)
    return np.stack([around, up], axis=1)


def _rectangle(own: FloatArray, across: int) -> tuple[int, int, int]:
    """The hole's node at the lower left of its rectangle, and the cells across and up; the hole runs clockwise."""
    n = len(own)
    off = own - (own.max(axis=0) + own.min(axis=0)) / 2.0
    x, y = (off / np.abs(off).max(axis=0)).T
    middle_x, middle_y = (x + np.roll(x, -1)) / 2.0, (y + np.roll(y, -1)) / 2.0
    # A hair more than half a right angle: what lies between two sides by symmetry goes to one of them for all holes.
    flat = int(np.count_nonzero(np.abs(middle_y) > 1.01 * np.abs(middle_x)))
    # The lowest place of the hole is a node or the middle of a segment: it is the middle of the rectangle's side.
    turn = np.angle(np.exp(1j * (np.arctan2(y, x) + np.pi / 2.0)))
    nearest = int(np.argmin(np.abs(turn)))
    beside = int((nearest + (1 if turn[nearest] > 0 else -1)) % n)  # clockwise: the angle falls
    on_node = bool(abs(turn[nearest]) < abs(turn[beside]) / 3.0)
    p = 2 * max(1, round(flat / 4)) if on_node else 2 * max(0, round((flat - 2) / 4)) + 1
    p = min(p, n // 2 - 1) + across
    lowest = float(nearest) if on_node else min((nearest, beside)) + 0.5 if abs(nearest - beside) == 1 else n - 0.5
    return round(lowest + p / 2.0) % n, p, n // 2 - p


def _numbered(number: IntArray, is_cell: np.ndarray, first: int) -> tuple[int, IntArray]:
    """Inner nodes are numbered from `first` on; and the quads, counter-clockwise as seen along the sweep."""
    n = len(number)
    i, j = np.nonzero(is_cell)
    corners = np.stack([np.stack([(i + a) % n, j + b], axis=1) for a, b in ((0, 0), (0, 1), (1, 1), (1, 0))], axis=1)
    touched = np.zeros(number.shape, dtype=np.bool_)
    touched[corners[..., 0], corners[..., 1]] = True
    inner = touched & (number < 0)
    number[inner] = first + np.arange(int(inner.sum()))
    return int(inner.sum()), number[corners[..., 0], corners[..., 1]]


def with_mirrors(
    outline: Outline, chart: Chart, n_inner: int, quads: IntArray, *, even: bool = False
) -> FaceQuads | None:
    """Nodes at the mean of their neighbours, with the mirrors of the outline where it has some.

    `even`: long links pull harder, where many quads would crowd along the rim.
    """
    rim = np.concatenate(chart.boundary)
    places = embedded(rim, n_inner, quads)
    if even and n_inner:
        places = evened(outline, chart, places, quads)
    inner = places[len(rim) :]
    boundary = np.concatenate(outline.nodes)
    for wedge in find_wedges(chart.boundary, between=True) if chart.isometric else ():
        made = carried_by_mirrors(outline, chart, wedge, boundary, inner, quads)
        if made is not None:
            return made
    return outline.lift(chart, inner, quads, boundary)
