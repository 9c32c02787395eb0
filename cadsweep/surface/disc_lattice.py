r"""Quads of a round face with holes and no bore: circles and rays around a core, with the holes taken out of them.

Place in the flow: one of the ways of :mod:`.filling`.

Method: as :mod:`.ring_lattice`, with a core of quads where the bore would be. The core is a polygon of k kites that
meet in its middle, with k of the turns that carry the holes to each other, or else a rectangle: where four of six turns
are kept, the mesh has fewer mirrors than its outline. Circles are so many that the innermost passes within all holes;
how far out each will be, the disc without its holes tells::

      o---o---o            k = 3: a node of three quads in the middle,
     / \  |  / \           and three more at the corners
    o   o-o-o   o
     \  |  |  |/

Where the holes are in the core, it is a rectangle of as many cells as it takes, and they are taken out of its lattice.

Not handled: holes in the middle, or so near to it that the core's quads would be much finer than the rim.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..polygons import signed_area
from .chart import Chart
from .embedding import embedded
from .kites import ROUNDEST, kites
from .lattice import every_cell, quads_of, rectangle
from .outline import SMOOTH, FaceQuads, Outline
from .pierced import pierce
from .relax import corner_sines
from .ring_lattice import Ring, pierced, with_mirrors
from .round_core import core_corners
from .symmetric import is_carried
from .symmetry import Wedge, find_wedges

_INNERMOST = 0.02
"""Where rays begin, as a part of the way from the middle to the rim."""
_ROUND = 1.5
"""Farthest over nearest node of a rim, from its middle, up to which circles and rays are a choice for its holes."""
_RINGS = (2, 1, 3, 5)
"""Rings around a core that has the holes in it."""
_MORE = (0, 1, 2, -1)
"""Circles more than the holes ask for that are tried."""
_ACROSS = (0, 2, -2)
"""Cells more across a hole than along its outline that are tried."""
_ENOUGH = 0.75
"""Worst corner sine from which on no other number of circles is tried."""
_FINEST = 0.25
"""Least edge inside over the typical one of the outline: below it the core is too fine to be worth its regularity."""
_ROOM = 0.2
"""Least part of the area within the rim that the face is: of less, holes are nearly all, and a core is laid in vain."""
_KEPT = 3
"""Best tries, as they lie in the plane, that are brought onto the surface and relaxed."""


def fill_disc(outline: Outline) -> FaceQuads | None:
    """Circles and rays around a core, and around the holes of a round face; None where these do not fit."""
    if len(outline.loops) < 2 or outline.grows():
        return None
    if any(abs(angle - np.pi) > SMOOTH for angle in outline.angles(outline.loops[0])):
        return None
    chart = next(outline.charts(outline.nodes), None)
    if chart is None or len(chart.boundary[0]) % 2:
        return None
    within, *holes = (abs(signed_area(loop)) for loop in chart.boundary)
    if within - sum(holes) < _ROOM * within:
        return None
    rim = np.concatenate(chart.boundary)
    wedges = find_wedges(chart.boundary) if chart.isometric else []
    typical = float(np.median(_edges(chart.boundary[0])))
    tries: list[tuple[float, int, IntArray]] = []
    for n_inner, quads in _lattices(outline, chart, wedges):
        places = embedded(rim, n_inner, quads)
        if wedges and not is_carried(wedges[0], chart, places):
            continue  # a symmetric cap gets symmetric quads, if not these
        corners = places[quads]
        if np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min() < _FINEST * typical:
            continue
        flat = np.pad(places, ((0, 0), (0, 1)))
        worst = float(corner_sines(flat, quads, np.broadcast_to([0.0, 0.0, 1.0], flat.shape)).min())
        tries.append((worst, n_inner, quads))
        if worst >= _ENOUGH:
            break
    best: FaceQuads | None = None
    for _, n_inner, quads in sorted(tries, key=lambda one: -one[0])[:_KEPT]:
        made = with_mirrors(outline, chart, n_inner, quads)
        if made is not None and (best is None or made.better_than(best)):
            best = made
        if best is not None and best.enough(_ENOUGH):
            break
    return best


def _edges(rim: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(np.roll(rim, -1, axis=0) - rim, axis=1))


def _lattices(outline: Outline, chart: Chart, wedges: Sequence[Wedge]) -> Iterator[tuple[int, IntArray]]:
    """Numbers of inner nodes, and quads in ids of the outline's nodes and then of these."""
    rim = chart.boundary[0]
    centre = wedges[0].centre if wedges else _middle(rim)
    farthest = np.linalg.norm(rim - centre, axis=1)
    if farthest.max() < _ROUND * farthest.min():
        yield from _with_holes_in_rings(chart, wedges, centre)
    yield from _with_holes_in_core(outline, chart, wedges)


def _with_holes_in_rings(chart: Chart, wedges: Sequence[Wedge], centre: FloatArray) -> Iterator[tuple[int, IntArray]]:
    rim = chart.boundary[0]
    n, n_outline = len(rim), sum(map(len, chart.boundary))
    ring = _ring_about(chart, centre)
    innermost = min(float(_parts(hole, rim, centre).min()) for hole in chart.boundary[1:])
    if innermost < 2.0 * _INNERMOST:
        return
    least = int(np.ceil(n / (2.0 * np.pi) * np.log(1.0 / innermost))) + 1
    for k, turn in [*_kites_of(rim, wedges), (0, 0)]:
        n_core, core = kites(n, k, turn) if k else _rectangle(n, *core_corners(rim))
        for more in _MORE:
            rows = max(3, least + more)
            heights = _heights(rim, centre, rows, n_core, core)
            if heights is None or heights[0] < _FINEST:
                continue
            for across in _ACROSS:
                found = pierced(ring, rows, across, heights, first=n_outline + n)
                if found is None:
                    continue
                n_rings, quads = found
                # The core's ids: its rim's nodes, then its own.
                number = np.concatenate([ring.bore_ids, n_outline + n + n_rings + np.arange(n_core)])
                yield n + n_rings + n_core, np.concatenate([quads, number[core]])


def _with_holes_in_core(outline: Outline, chart: Chart, wedges: Sequence[Wedge]) -> Iterator[tuple[int, IntArray]]:
    rim = chart.boundary[0]
    n, n_outline = len(rim), sum(map(len, chart.boundary))
    for first, p in _rectangles(rim, wedges):
        core = rectangle(n, first, p)
        n_core = core.size - n
        every = quads_of(core, every_cell(core))
        for rings in _RINGS:
            around = _rings_inwards(np.arange(n), n + np.arange(rings * n).reshape(rings, n))
            number = np.concatenate([n + (rings - 1) * n + np.arange(n), n + rings * n + np.arange(n_core)])
            places = embedded(rim, rings * n + n_core, np.concatenate([around, number[every]]))
            made = pierce(outline, chart, core, every_cell(core), places[number])
            if made is None:
                continue
            quads = quads_of(*made)
            # Nodes of the core's rim are the innermost ring's; those of holes come after the rim's, as in the outline.
            inside = n_outline + rings * n + np.arange(int(made[0].max()) + 1 - n_outline)
            number = np.concatenate([n_outline + (rings - 1) * n + np.arange(n), np.arange(n, n_outline), inside])
            around = _rings_inwards(np.arange(n), n_outline + np.arange(rings * n).reshape(rings, n))
            yield rings * n + len(inside), np.concatenate([around, number[quads]])


def _rings_inwards(rim: IntArray, rings: IntArray) -> IntArray:
    """Quads between a rim's nodes (n,) and rings (r, n) inside it, the outermost first."""
    every = np.concatenate([rim[None], rings])
    after = np.roll(every, -1, axis=1)
    return np.stack([every[:-1], after[:-1], after[1:], every[1:]], axis=-1).reshape(-1, 4)


def _rectangle(n: int, first: int, p: int) -> tuple[int, IntArray]:
    core = rectangle(n, first, p)
    return core.size - n, quads_of(core, every_cell(core))


def _rectangles(rim: FloatArray, wedges: Sequence[Wedge]) -> Iterator[tuple[int, int]]:
    """Corner and segments up to the next one of rectangles in a rim, the most symmetric first."""
    n = len(rim)
    first, p = core_corners(rim)
    for wedge in wedges:
        if wedge.n == 4 and n % 8 == 0:
            yield _node_at(rim, wedge), n // 4
            yield _node_at(rim, wedge) + n // 8, n // 4
    yield first, p


def _node_at(rim: FloatArray, wedge: Wedge) -> int:
    angles, _ = wedge.polar(rim)
    return int(np.argmin(np.abs(np.exp(1j * angles) - 1.0)))


def _middle(rim: FloatArray) -> FloatArray:
    """The centre of area of a polygon (n, 2)."""
    after = np.roll(rim, -1, axis=0)
    cross = rim[:, 0] * after[:, 1] - rim[:, 1] * after[:, 0]
    return np.asarray((cross[:, None] * (rim + after)).sum(axis=0) / (6.0 * signed_area(rim)))


def _ring_about(chart: Chart, centre: FloatArray) -> Ring:
    """The ring between the rim and a small image of it about the middle, whose nodes follow those of the outline."""
    rim = chart.boundary[0]
    n_outline = sum(map(len, chart.boundary))
    firsts = np.cumsum([0, *(len(loop) for loop in chart.boundary)])
    ids = [np.arange(a, a + len(loop)) for a, loop in zip(firsts, chart.boundary, strict=False)]
    return Ring(
        rim=rim,
        bore=centre + _INNERMOST * (rim - centre),
        rim_ids=ids[0],
        bore_ids=n_outline + np.arange(len(rim)),
        holes=[(loop[::-1], own[::-1]) for loop, own in zip(chart.boundary[1:], ids[1:], strict=True)],
    )


def _parts(places: FloatArray, rim: FloatArray, centre: FloatArray) -> FloatArray:
    """How far out places (m, 2) are between the middle (0) and the rim (1), by the rim's mean distance."""
    return np.asarray(np.linalg.norm(places - centre, axis=1) / np.linalg.norm(rim - centre, axis=1).mean())


def _kites_of(rim: FloatArray, wedges: Sequence[Wedge]) -> Iterator[tuple[int, int]]:
    """Kites of a core and the node over its first corner, the most symmetric first."""
    n = len(rim)
    order = wedges[0].n if wedges else 1
    for k in range(min(order, ROUNDEST), 2, -1):
        if not order % k and not n % (2 * k):
            first = _node_at(rim, wedges[0])
            yield k, first
            yield k, first + n // (2 * k)


def _heights(rim: FloatArray, centre: FloatArray, rows: int, n_core: int, core: IntArray) -> FloatArray | None:
    """Parts of the rays at which the circles of the disc without holes are; None where they are within its first."""
    n = len(rim)
    rings = n + np.arange(rows * n).reshape(rows, n)
    around = _rings_inwards(np.arange(n), rings[::-1])
    rings = np.concatenate([rings, np.arange(n)[None]])
    number = np.concatenate([rings[0], n + rows * n + np.arange(n_core)])
    places = embedded(rim, rows * n + n_core, np.concatenate([around, number[core]]))
    parts = np.array([_parts(places[ring], rim, centre).mean() for ring in rings])
    found = (parts - _INNERMOST) / (1.0 - _INNERMOST)
    return found if found[0] > 0 and (np.diff(found) > 0).all() else None
