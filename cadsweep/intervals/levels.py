"""Levels: which vertices of a sweep stand on one layer.

Place in the flow: used by :mod:`.equations`. All vertices that edges along the loops join lie on one *level*; the
source cap is level 0, the target cap the last. An edge along the sweep goes from one level to a higher one.

Where a linking side is one face beside columns that are divided (a mitre seen from its plane side), vertices that
answer each other on its left and right are put on one level too, if that can be; so are stations that answer each
other on the loops.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..brep import Solid
from ..disjoint import DisjointSets
from ..sweep import DirectedEdge, LinkingSide, Sweep
from .sizes import turns_back

SAME_PLACE = 0.25
"""Vertices on opposite rails are put on one level where their fractions of the rail differ by less."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Levels:
    """Levels of the vertices of a sweep.

    Attributes
    ----------
    n : int
        Number of levels; 0 is the source, ``n - 1`` the target.
    rails : dict of int to (int, int)
        Lower and upper level of every edge along the sweep.
    least : dict of (int, int) to int
        Fewest layers between two levels that a rail joins: two where all rails between them turn back, as in
        half a ring, because one layer there would be flat.
    """

    n: int
    rails: dict[int, tuple[int, int]]
    least: dict[tuple[int, int], int]


def directed_ends(solid: Solid, directed: DirectedEdge) -> tuple[int, int]:
    """First and last vertex of a directed edge."""
    edge = solid.edges[directed[0]]
    return (edge.start, edge.end) if directed[1] else (edge.end, edge.start)


def find_levels(sweep: Sweep) -> list[Levels]:
    """Group the vertices of a sweep into levels: all ways that no vertex contradicts, the most even one first."""
    choices = [_levels(sweep, stations=True, columns=columns) for columns in (True, False)]
    found = [levels for levels in choices if levels is not None]
    bare = None if found else _levels(sweep, stations=False, columns=False)
    return found if bare is None else [bare]


def _levels(sweep: Sweep, *, stations: bool, columns: bool) -> Levels | None:
    solid = sweep.solid
    sets = DisjointSets(range(len(solid.vertices)))
    find = sets.find
    for a, b in _joined(sweep, stations=stations, columns=columns):
        sets.merge(a, b)
    source = find(directed_ends(solid, sweep.source_loops[0][0])[0])
    target = find(directed_ends(solid, sweep.target_loops[0][0])[0])
    number = {source: 0}
    rails: dict[int, tuple[int, int]] = {}
    for side in sweep.linking_sides:
        for d in side.left + side.right:
            low, high = (find(v) for v in directed_ends(solid, d))
            for level in (low, high):
                if level != target:
                    number.setdefault(level, len(number))
            rails[d[0]] = (low, high)
    number[target] = len(number)
    if source == target or any(low == high for low, high in rails.values()):
        return None
    numbered = {e: (number[a], number[b]) for e, (a, b) in rails.items()}
    forth = {pair for e, pair in numbered.items() if not turns_back(sweep, solid.edges[e])}
    least = {pair: 1 if pair in forth else 2 for pair in numbered.values()}
    levels = Levels(n=len(number), rails=numbered, least=least)
    return levels if n_least(levels) else None


def _joined(sweep: Sweep, *, stations: bool, columns: bool) -> Iterator[tuple[int, int]]:
    """Pairs of vertices of one level; also of those that only answer each other on stations, and in columns."""
    solid = sweep.solid
    for loops in (sweep.source_loops, sweep.target_loops):
        first = directed_ends(solid, loops[0][0])[0]
        yield from ((first, directed_ends(solid, d)[0]) for loop in loops for d in loop)
    for side in sweep.linking_sides:
        yield from (directed_ends(solid, d) for d in side.bottom + side.top)
        if columns:
            yield from _answering(solid, side)
    if stations:
        yield from _answering_stations(sweep)


def _answering(solid: Solid, side: LinkingSide) -> list[tuple[int, int]]:
    """Pairs of inner vertices of the left and right chain at about the same place."""
    if len(side.left) == 1 or len(side.left) != len(side.right):
        return []
    pairs = []
    for k in range(1, len(side.left)):
        place = [_fraction(solid, chain, k) for chain in (side.left, side.right)]
        if abs(place[0] - place[1]) < SAME_PLACE:
            pairs.append((directed_ends(solid, side.left[k])[0], directed_ends(solid, side.right[k])[0]))
    return pairs


def _answering_stations(sweep: Sweep) -> list[tuple[int, int]]:
    """Pairs of vertices on stations of the outer loop and of another one at about the same place."""
    found = [_station_places(sweep, loop) for loop in range(len(sweep.spans))]
    pairs = []
    for other in found[1:]:
        # Next neighbours of each other, and much nearer than the stations before and after.
        for place, vertex in other:
            near = min(found[0], key=lambda s: abs(s[0] - place), default=None)
            if near is None or min(other, key=lambda s: abs(s[0] - near[0]))[1] != vertex:
                continue
            room = min(_room(found[0], near[0]), _room(other, place))
            if abs(near[0] - place) < SAME_PLACE * room:
                pairs.append((near[1], vertex))
    return pairs


def _room(stations: Sequence[tuple[float, int]], place: float) -> float:
    """Distance from a station to the next one, or to a cap."""
    return min(abs(place - other) for other in [0.0, 1.0, *(p for p, _ in stations)] if other != place)


def _station_places(sweep: Sweep, loop: int) -> list[tuple[float, int]]:
    """Place between 0 and 1, and a vertex, of every station of a loop."""
    edges = sweep.solid.edges
    ends = [{v for e in span for v in (edges[e].start, edges[e].end)} for span in sweep.spans[loop]]
    lengths = np.cumsum(sweep.span_lengths[loop]) / sum(sweep.span_lengths[loop])
    found = []
    for ring in sweep.stations:
        vertices = {v for e in ring for v in (edges[e].start, edges[e].end)}
        for k, (below, above) in enumerate(pairwise(ends)):
            if vertices & below and vertices & above:
                found.append((float(lengths[k]), min(vertices)))
    return found


def _fraction(solid: Solid, chain: Sequence[DirectedEdge], k: int) -> float:
    lengths = [solid.edges[e].length for e, _ in chain]
    return sum(lengths[:k]) / sum(lengths)


def n_least(levels: Levels) -> int:
    """Fewest layers that the levels allow; 0 where a level would have to lie above itself."""
    height = [0] * levels.n
    for _ in range(levels.n + 1):
        changed = False
        for (low, high), n in levels.least.items():
            if height[high] < height[low] + n:
                height[high] = height[low] + n
                changed = True
        if not changed:
            return height[-1]
    return 0
