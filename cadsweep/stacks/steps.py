"""Where outlines of an arrangement come near each other: the steps by which :mod:`.merging` may lay them together.

Method: inside every cell, corners against the edges across it, and both ends of short edges; from sharp corners on, the
two sides up to where they are apart. Whether a step may be made is not asked here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np
import scipy

from ..arrays import FloatArray
from ..polygons import is_inside
from .graph import Graph

_SHARP = np.radians(15.0)
"""Interior angle of a cell up to which its sides are laid together from the corner on."""


class Step(NamedTuple):
    """Two places of a cell to be brought together: half-edges that begin there, or run to a place inside of them."""

    distance: float
    one: int
    at: float
    other: int
    along: float


def find_steps(graph: Graph, cells: Collection[int], near: float) -> list[Step]:
    """Where outlines come near each other across cells, or along their edges.

    Parameters
    ----------
    graph : Graph
    cells : collection of int
        The cells that are looked at; edges that must stay are left out.
    near : float
        Working units.
    """
    own: dict[int, list[list[int]]] = {}
    for loop in graph.loops():
        if (c := graph.cell[loop[0]]) in cells and c >= 0:
            own.setdefault(c, []).append(loop)
    found: list[Step] = []
    for loops in own.values():
        if any(graph.lines[h >> 1].frozen for loop in loops for h in loop):
            loops = [loop for loop in loops if not any(graph.lines[h >> 1].frozen for h in loop)]  # noqa: PLW2901
        found += _steps_across(graph, loops, near)
    return found


def _steps_across(graph: Graph, loops: list[list[int]], near: float) -> Iterator[Step]:
    halves = [h for loop in loops for h in loop]
    courses = {h: graph.samples(h >> 1)[:: -1 if h % 2 else 1] for h in halves}
    if not halves:
        return
    polygons = [np.concatenate([courses[h][:-1] for h in loop]) for loop in loops]
    starts = np.concatenate([courses[h][:-1] for h in halves])
    ends = np.concatenate([courses[h][1:] for h in halves])
    owner = np.concatenate([np.full(len(courses[h]) - 1, j) for j, h in enumerate(halves)])
    offsets = np.cumsum([0, *(len(courses[h]) - 1 for h in halves)])
    lengths = np.linalg.norm(ends - starts, axis=1)
    pieces = np.split(lengths, offsets[1:-1])
    short = [(float(piece.sum()), h) for piece, h in zip(pieces, halves, strict=True) if piece.sum() < near]
    yield from (Step(length, h, 0.0, graph.next[h], 0.0) for length, h in short)
    at_ends = _at_ends(graph, halves)
    corners = np.array([graph.points[graph.origin[h]] for h in halves])
    for h, corner, mine in zip(halves, corners, _within_reach(corners, starts, ends, near), strict=True):
        skip = at_ends[graph.origin[h]]
        mine = [k for k in mine if int(owner[k]) not in skip]  # noqa: PLW2901
        if not mine:
            continue
        distances, shares = _nearest(corner, starts[mine], ends[mine])
        nearest = int(np.argmin(distances))
        k, distance, share = mine[nearest], float(distances[nearest]), float(shares[nearest])
        if not distance < near:
            continue
        j = int(owner[k])
        other = halves[j]
        place = starts[k] + share * (ends[k] - starts[k])
        if not is_inside(polygons, (corner + place)[None] / 2.0)[0]:
            continue
        own = pieces[j]
        run = own[: k - offsets[j]].sum() + share * own[k - offsets[j]]
        whole = own.sum()
        if run < near:
            yield Step(float(np.linalg.norm(corner - courses[other][0])), h, 0.0, other, 0.0)
        elif whole - run < near:
            last = graph.next[other]
            yield Step(float(np.linalg.norm(corner - courses[other][-1])), h, 0.0, last, 0.0)
        else:
            yield Step(distance, h, 0.0, other, float(run / whole))
    for h in halves:
        yield from _zipped(graph, graph.before[h], h, courses, near)


def _zipped(graph: Graph, one: int, other: int, courses: dict[int, FloatArray], near: float) -> Iterator[Step]:
    """From a sharp corner on, the two sides are laid together up to where they are apart."""
    corner = graph.origin[other]
    if one not in courses or other not in courses or one >> 1 == other >> 1 or corner >= graph.given:
        return
    back, ahead = courses[one][::-1], courses[other]
    lengths = [np.linalg.norm(np.diff(course, axis=0), axis=1).sum() for course in (back, ahead)]
    reach = min(lengths) * 0.999
    at = np.linspace(0.0, 1.0, 65)[1:] * reach
    gaps = np.linalg.norm(_along(back, at) - _along(ahead, at), axis=1)
    apart = np.flatnonzero(gaps > near)
    if not len(apart) or gaps[0] > 2.0 * np.sin(_SHARP / 2.0) * at[0]:
        return
    run = float(np.interp(near, [0.0, *gaps[: apart[0] + 1]], [0.0, *at[: apart[0] + 1]]))
    if run < 2.0 * near or run > 0.9 * min(lengths):
        return
    yield Step(near, one, 1.0 - run / lengths[0], other, run / lengths[1])


def _along(course: FloatArray, lengths: FloatArray) -> FloatArray:
    """Points (m, 2) of a polyline at lengths from its start."""
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(course, axis=0), axis=1))])
    return np.stack([np.interp(lengths, run, course[:, k]) for k in range(2)], axis=1)


def _at_ends(graph: Graph, halves: Sequence[int]) -> dict[int, set[int]]:
    """Places in `halves` of those that begin or end at a vertex."""
    found: dict[int, set[int]] = {}
    for j, h in enumerate(halves):
        for end in (graph.origin[h], graph.origin[h ^ 1]):
            found.setdefault(end, set()).add(j)
    return found


def _within_reach(points: FloatArray, starts: FloatArray, ends: FloatArray, near: float) -> list[list[int]]:
    """Of each point the segments, in order, that may be nearer than `near`: seen from the segments, as few are long."""
    reach = near + np.linalg.norm(ends - starts, axis=1) / 2.0
    found: list[list[int]] = [[] for _ in points]
    for k, own in enumerate(scipy.spatial.cKDTree(points).query_ball_point((starts + ends) / 2.0, reach)):
        for j in own:
            found[j].append(k)
    return found


def _nearest(point: FloatArray, starts: FloatArray, ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances (m,) of a point from segments, and the fractions of the nearest points."""
    along = ends - starts
    at = np.clip(((point - starts) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(starts + at[:, None] * along - point, axis=1), at


__all__ = ["Step", "find_steps"]
