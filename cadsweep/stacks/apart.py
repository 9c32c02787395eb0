"""Caps of unlike heights that come near each other in plan: on one level, its quads between them are all but upright.

Place in the flow: after :mod:`.sheets`, for :mod:`.levels`. Where caps meet, one over the other, they are on different
levels in any case; here are those between which there is a short way across one cell.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..stack import Stack
from .along import heights_on_edge
from .sheets import Sheets
from .widths import Pairs, Samples, pairs_across

STEEP = 2.0
"""Height between two sheets, in lengths of the way across, from which on they are told apart."""
_REACH = 0.5
"""Longest way across that is looked at, in sizes of the mesh."""
_LEAST = 1e-6
"""Shortest one, in sizes of the mesh."""
_THIN = 0.05
"""Height between two sheets, in sizes of the mesh, up to which they had better share a level."""

Known = dict[int, int]
"""Edges of the part over a place, by their sheets."""


def sheets_apart(stack: Stack, sheets: Sheets, size: float) -> dict[tuple[int, int], float]:
    """Pairs (lower, upper) of sheets that come near each other, and how steep a level would be that has both.

    Parameters
    ----------
    stack : Stack
    sheets : Sheets
    size : float
        Of the mesh, working units.
    """
    prism = stack.arrangement.prism
    samples = Samples(stack, _REACH * size)
    over = {e: _known(stack, sheets, e) for e in stack.arrangement.over}
    at_vertex: dict[int, Known] = {}
    for e, known in over.items():
        for v in (prism.edges[e].start, prism.edges[e].end):
            at_vertex.setdefault(v, {}).update(known)
    found: dict[tuple[int, int], float] = {}
    cells = [prism.faces[bottom].edges for c, bottom in enumerate(stack.arrangement.bottoms) if stack.columns[c]]
    pairs = pairs_across(prism.edges, cells, samples.places, _REACH * size)
    for e, at, other, distance in _nearest(pairs, samples, _REACH * size):
        ends = {0: prism.edges[e].start, len(samples.places[e]) - 1: prism.edges[e].end}
        here = at_vertex[ends[at]] if at in ends else over[e]
        place = samples.lifted(samples.places[e][at])
        _compare(stack, (here, over[other]), place, max(distance, _LEAST * size), _THIN * size, found)
    return found


def _nearest(pairs: Pairs, samples: Samples, reach: float) -> list[tuple[int, int, int, float]]:
    """The shortest way from every edge, and from both of its ends, to every other: edge, sample, other, length."""
    last = np.zeros(max(samples.places, default=-1) + 1, dtype=np.int64)
    last[list(samples.places)] = [len(own) - 1 for own in samples.places.values()]
    part = np.where(pairs.at == 0, 0, np.where(pairs.at == last[pairs.one], 1, 2))
    order = np.lexsort((pairs.distances, part, pairs.other, pairs.one, pairs.cell))
    order = order[pairs.distances[order] <= reach]
    keys = np.stack([pairs.cell, pairs.one, pairs.other, part], axis=1)[order]
    first = order[np.append(True, (np.diff(keys, axis=0) != 0).any(axis=1))[: len(order)]]
    columns = (column[first].tolist() for column in (pairs.one, pairs.at, pairs.other, pairs.distances))
    return list(zip(*columns, strict=True))


def _known(stack: Stack, sheets: Sheets, e: int) -> Known:
    """The sheets that have an edge over one of the arrangement."""
    known: Known = {}
    for edge in stack.arrangement.over[e]:
        if edge in sheets.stations:
            known[sheets.stations[edge]] = edge
        for f in stack.solid.edges[edge].faces:
            if f in sheets.caps:
                known[sheets.caps[f]] = edge
    return known


def _compare(  # noqa: PLR0917
    stack: Stack,
    known: tuple[Known, Known],
    place: FloatArray,
    distance: float,
    thin: float,
    found: dict[tuple[int, int], float],
) -> None:
    """Add the pairs of sheets of which each is on one side of a way alone."""
    here, there = known
    apart = ({s: e for s, e in here.items() if s not in there}, {s: e for s, e in there.items() if s not in here})
    if not (apart[0] and apart[1]):
        return
    edges = stack.solid.edges
    heights = [
        [(s, float(heights_on_edge(edges[e], stack.direction, place[None])[0])) for s, e in own.items()]
        for own in apart
    ]
    for s, low in heights[0]:
        for t, high in heights[1]:
            steep = abs(high - low) / distance
            pair = (s, t) if low < high else (t, s)
            if abs(high - low) > thin and steep > max(STEEP, found.get(pair, 0.0)):
                found[pair] = steep


__all__ = ["STEEP", "sheets_apart"]
