"""How an edge divides itself into unequal segments, and which other edges do so with it.

Place in the flow: ``pipeline`` finds the edges that are to be graded; before nodes are placed, what is asked of them
is carried to the edges that answer them, through logical rectangles and along the layers.

Method: a graded edge is a row of weights, one a segment. Opposite chains of a rectangle have as many segments, so a
chain gets the weights of the one across; where several reach an edge at once, their mean. Rails are graded by the
places of the layers, which are one for all rails of a loop.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..brep import Solid
from ..errors import SurfaceMeshError
from ..sweep import DirectedEdge, Intervals, LinkingSide, Sweep
from .outline import four_sides, reversed_loop
from .spacing import rescaled
from .sweep_grid import SweepGrid, build_grid

Division = Callable[[int], FloatArray]
"""``division(n)``: arc-length fractions (n + 1,) of the nodes of an edge of n segments, from its start to its end."""

Answer = tuple[Sequence[DirectedEdge], ...]
"""Two chains of directed edges that have equally many segments, node by node."""

_EVEN = 1e-12
_MOST_LEANING = 1.0
"""Segments by which nodes of an even edge may be from those of the chain across."""
_MOST_LOG_RATIO = np.log(1e6)


def graded_fractions(n: int, *, start: float = 1.0, end: float = 1.0) -> FloatArray:
    """Fractions (n + 1,) of n segments whose lengths change by equal factors from either end to the middle.

    Parameters
    ----------
    start, end : float
        Length of the longest segment over that at the start, and at the end. With one of them 1 the row is geometric
        from end to end; with neither, an even number of segments has two longest ones in the middle.
    """
    at = np.linspace(0.0, 1.0, n) if n > 1 else np.zeros(1)
    knots, logs = ([0.0, 1.0], [-np.log(start), -np.log(end)])
    if start != 1.0 and end != 1.0:
        middle = 0.5 if n % 2 or n < 4 else (n / 2 - 1) / (n - 1)
        knots, logs = [0.0, middle, 1.0 - middle, 1.0], [logs[0], 0.0, 0.0, logs[1]]
    return _fractions(np.exp(np.interp(at, knots, logs)))


def fractions_from(n: int, first: float, *, both: bool = False) -> FloatArray:
    """Fractions (n + 1,) of a geometric row whose first segment has the share `first`; or of one from `both` ends.

    Raises
    ------
    SurfaceMeshError
        No row of n segments has such a first one.
    """
    if n < (3 if both else 2) or not 0.0 < first < (0.5 if both else 1.0):
        raise SurfaceMeshError(f"{n} segments cannot begin with {first:.3g} of the edge")

    def share(log_ratio: float) -> float:
        ratio = float(np.exp(log_ratio))
        return float(graded_fractions(n, start=ratio, end=ratio if both else 1.0)[1])

    low, high = -_MOST_LOG_RATIO, _MOST_LOG_RATIO
    if not share(high) <= first <= share(low):
        raise SurfaceMeshError(f"{n} segments that begin with {first:.3g} of the edge would grow too fast")
    ratio = float(np.exp(scipy.optimize.brentq(lambda x: share(x) - first, low, high, xtol=1e-12)))
    return graded_fractions(n, start=ratio, end=ratio if both else 1.0)


def turned_round(fractions: FloatArray) -> FloatArray:
    """The same division, seen from the other end."""
    return np.asarray(1.0 - fractions[::-1])


def _fractions(weights: FloatArray) -> FloatArray:
    places = np.concatenate([[0.0], np.cumsum(weights)]) / weights.sum()
    places[-1] = 1.0
    return places


def answering_chains(sweep: Sweep, counts: IntArray) -> list[Answer]:
    """Chains around the loops that divide themselves alike: across sides, across rectangular caps, and cap to cap."""
    pairs: list[Answer] = [(side.bottom, side.top) for side in sweep.linking_sides]
    pairs += [([(e, True)], [(t, same)]) for e, (t, same) in sweep.target_edges.items()]
    for f in sweep.source:
        face = sweep.solid.faces[f]
        if len(face.loops) == 1:
            sides = four_sides(face, reversed_loop(face.loops[0].directed), counts)
            if sides is not None:
                a, b, c, d = sides
                pairs += [(a, _turned(c)), (b, _turned(d))]
    return pairs


def _turned(chain: Sequence[DirectedEdge]) -> list[DirectedEdge]:
    return [(e, not forward) for e, forward in reversed(chain)]


def graded_together(  # noqa: PLR0917
    solids: Sequence[Solid],
    sweeps: Sequence[tuple[Sweep, Intervals]],
    grids: Sequence[tuple[Solid, LinkingSide]],
    counts: Mapping[int, int],
    asked: Mapping[int, FloatArray],
    alike: Iterable[tuple[int, int, bool]] = (),
) -> dict[int, FloatArray]:
    """Fractions of the edges of several cells that are graded, or answer one that is, or would lean (:func:`leaning`).

    Parameters
    ----------
    solids : sequence of Solid
        All cells.
    sweeps : sequence of (Sweep, Intervals)
        Of the cells that are swept.
    grids : sequence of (Solid, LinkingSide)
        The logical rectangles among the cells' faces.
    counts : mapping of int to int
        Segments of every edge, by key.
    asked : mapping of int to (n + 1,) float64
        By key, from an edge's start to its end, which are the same in all cells.
    alike : iterable of (int, int, bool)
        Edges that divide themselves alike besides, by key, and whether they run alike.
    """
    lengths = {int(solid.edge_keys[edge.id]): edge.length for solid in solids for edge in solid.edges}
    pairs = [(sweep.solid, pair) for sweep, own in sweeps for pair in answering_chains(sweep, own.counts)]
    pairs += [(solid, pair) for solid, grid in grids for pair in ((grid.bottom, grid.top), (grid.left, grid.right))]
    answers = [tuple([(int(s.edge_keys[e]), f) for e, f in chain] for chain in pair) for s, pair in pairs]
    answers += [([(a, True)], [(b, same)]) for a, b, same in alike]
    found: dict[int, FloatArray] = {**leaning(answers, counts, lengths), **asked}
    if not found:
        return {}
    layouts = [(sweep.solid.edge_keys.tolist(), build_grid(sweep, own)) for sweep, own in sweeps]
    n = -1
    while n != len(found):
        n = len(found)
        found = spread(answers, counts, lengths, found)
        for keys, layout in layouts:
            graded = {e: found[keys[e]] for e in layout.edges if keys[e] in found}
            even = np.tile(np.linspace(0.0, 1.0, layout.n_layers + 1), (len(layout.loop_sizes), 1))
            places = grade_places(layout, even, graded)
            for e, placed in layout.edges.items():
                own_places = places[placed.loop, placed.layer : placed.layer + placed.n_segments + 1]
                if placed.along_loop or keys[e] in found or np.ptp(np.diff(own_places)) < _EVEN:
                    continue
                fractions = rescaled(own_places)
                found[keys[e]] = fractions if placed.forward else turned_round(fractions)
    return found


def leaning(
    answers: Iterable[Answer], counts: Mapping[int, int], lengths: Mapping[int, float]
) -> dict[int, FloatArray]:
    """Fractions of single edges across from chains of several, where even segments would be far from theirs.

    A chain whose edges need unlike sizes, as where a neighbour's cuts end at it, has nodes that are nowhere near even
    ones: the rectangle between them would lean by whole segments. Up to one it is left: the edge is even, then.
    """
    reached: dict[int, list[FloatArray]] = {}
    for pair in answers:
        for one, other in (pair, pair[::-1]):
            if len(one) == 1 or len(other) != 1 or sum(counts[e] for e, _ in one) != counts[other[0][0]]:
                continue
            (edge, forward) = other[0]
            places = _fractions(np.concatenate([_weights(e, way, counts, lengths, {}) for e, way in one]))
            n = counts[edge]
            if np.abs(places * n - np.arange(n + 1)).max() > _MOST_LEANING:
                reached.setdefault(edge, []).append(places if forward else turned_round(places))
    return {e: np.asarray(np.mean(rows, axis=0)) for e, rows in reached.items()}


def spread(
    answers: Iterable[Answer], counts: Mapping[int, int], lengths: Mapping[int, float], graded: Mapping[int, FloatArray]
) -> dict[int, FloatArray]:
    """Carry divisions to the edges that answer those that have one.

    Parameters
    ----------
    answers : iterable of Answer
    counts, lengths : mapping of int to int, float
        Segments and length of every edge, by the ids (or keys) that `answers` are in.
    graded : mapping of int to (n + 1,) float64
        Fractions of the edges that are graded, from start to end.

    Returns
    -------
    dict of int to (n + 1,) float64
        Those of `graded`, as they were, and of all edges that they reach.
    """
    found = dict(graded)
    pairs = [pair for one, other in answers for pair in ((one, other), (other, one))]
    while True:
        reached: dict[int, list[FloatArray]] = {}
        for one, other in pairs:
            open_ = [e for e, _ in other if e not in found]
            if not open_ or all(e not in found for e, _ in one):
                continue
            if sum(counts[e] for e, _ in one) != sum(counts[e] for e, _ in other):
                continue  # no rectangle after all: whoever meshes it refuses it
            weights = np.concatenate([_weights(e, forward, counts, lengths, found) for e, forward in one])
            begin = 0
            for e, forward in other:
                own = weights[begin : begin + counts[e]]
                begin += counts[e]
                if e not in found:
                    reached.setdefault(e, []).append((own if forward else own[::-1]) / own.sum())
        if not reached:
            return found
        found |= {e: _fractions(np.mean(rows, axis=0)) for e, rows in reached.items()}


def _weights(
    edge: int,
    forward: bool,
    counts: Mapping[int, int],
    lengths: Mapping[int, float],
    graded: Mapping[int, FloatArray],
) -> FloatArray:
    n = counts[edge]
    shares = np.diff(graded[edge]) if edge in graded else np.full(n, 1.0 / n)
    return np.asarray(lengths[edge] * (shares if forward else shares[::-1]))


def grade_places(layout: SweepGrid, places: FloatArray, graded: Mapping[int, FloatArray]) -> FloatArray:
    """Places (n_loops, n_layers + 1) of the layers that follow graded rails; loops without such follow the others."""
    rows: dict[tuple[int, int], dict[int, list[FloatArray]]] = {}
    for e, fractions in graded.items():
        placed = layout.edges[e]
        if not placed.along_loop:
            own = fractions if placed.forward else turned_round(fractions)
            rows.setdefault((placed.n_segments, placed.layer), {}).setdefault(placed.loop, []).append(own)
    out = places.copy()
    for n, layer in sorted(rows, key=lambda key: (-key[0], key[1])):  # a short rail beside a long one comes last
        by_loop = rows[n, layer]
        common = [row for loop_rows in by_loop.values() for row in loop_rows]
        for loop in range(len(out)):
            share = np.mean(by_loop.get(loop, common), axis=0)
            low, high = out[loop, layer], out[loop, layer + n]
            out[loop, layer : layer + n + 1] = low + (high - low) * share
    return out
