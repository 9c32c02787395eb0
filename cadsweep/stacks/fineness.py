"""How finely the edges of an arrangement are divided where outlines come near each other, or are short themselves.

Place in the flow: after outlines that may be have been laid together (:mod:`.merging`); what is near still is a thin
piece of the part, or a narrow gap.

Method: a short edge, and a place of an edge with another one across the cell, want segments of about that length; from
there on they grow evenly with the distance. Every edge is divided by the size that this gives along it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import scipy

from ..arrays import FloatArray
from ..stack import Stack
from .along import across
from .merging import is_inside, nearest

_GROWTH = 0.5
"""Growth of the wanted length per length: segments beside each other differ by half."""
_ACROSS = 1.5
"""Segments along a gap, in widths of it."""
_FINEST = 1.0 / 12.0
"""Least length that a gap asks for, in sizes: longer quads in a still narrower one are right angled, too."""
_SHORTEST = 1.0 / 50.0
"""The same of a short edge."""
_STEPS = 16
"""Places along an edge, between which its size is interpolated; more on one of many sizes."""
_EVEN = 1.3
"""Ratio of the sizes along an edge up to which it is divided evenly."""
_FINER = 0.85
"""Share of the size below which an edge is told to be finer."""


def grade_edges(stack: Stack, size: float) -> tuple[dict[int, float], dict[int, Callable[[int], FloatArray]]]:
    """Lengths of segments, and divisions, of edges at narrow places.

    Parameters
    ----------
    stack : Stack
    size : float
        Wanted length elsewhere, working units.

    Returns
    -------
    sizes : dict of int to float
        By edge of the arrangement: mean length of its segments.
    divisions : dict of int to callable
        Fractions (n + 1,) of the ends of n segments, of edges whose segments should differ.
    """
    prism, frame = stack.arrangement.prism, across(stack.direction)
    courses: dict[int, FloatArray] = {}
    at: dict[int, FloatArray] = {}
    for e in stack.arrangement.over:
        edge = prism.edges[e]
        n = max(_STEPS, min(8 * _STEPS, round(4.0 * edge.length / size)))
        at[e] = np.linspace(0.0, 1.0, n + 1)
        courses[e] = edge.curve.evaluate(at[e]) @ frame.T
    places, wanted = _sources(stack, courses, size)
    if not len(places):
        return {}, {}
    tree = scipy.spatial.cKDTree(places)
    sizes: dict[int, float] = {}
    divisions: dict[int, Callable[[int], FloatArray]] = {}
    reach = (size - wanted) / _GROWTH
    for e, course in courses.items():
        own = np.full(len(course), size)
        for j, near in enumerate(tree.query_ball_point(course, float(reach.max()))):
            if near:
                grown = wanted[near] + _GROWTH * np.linalg.norm(places[near] - course[j], axis=1)
                own[j] = min(size, float(grown.min()))
        if own.min() > _FINER * size:
            continue
        density = np.concatenate([[0.0], np.cumsum(np.diff(at[e]) * (1.0 / own[1:] + 1.0 / own[:-1]) / 2.0)])
        sizes[e] = 1.0 / float(density[-1])
        if own.max() > _EVEN * own.min():
            divisions[e] = partial(_divided, density / density[-1], at[e])
    return sizes, divisions


def _divided(share: FloatArray, at: FloatArray, n: int) -> FloatArray:
    fractions = np.interp(np.linspace(0.0, 1.0, n + 1), share, at)
    fractions[0], fractions[-1] = 0.0, 1.0
    return np.asarray(fractions)


def _sources(stack: Stack, courses: dict[int, FloatArray], size: float) -> tuple[FloatArray, FloatArray]:
    """Places (n, 2) that want shorter segments, and their lengths (n,)."""
    prism = stack.arrangement.prism
    places: list[FloatArray] = []
    wanted: list[float] = []
    for e, course in courses.items():
        if prism.edges[e].length < _FINER * size:
            places.append(course[len(course) // 2])
            wanted.append(max(prism.edges[e].length, _SHORTEST * size))
    for f in stack.arrangement.bottoms:
        for where, gap in _gaps(stack, f, courses, size):
            places.append(where)
            wanted.append(max(_ACROSS * gap, _FINEST * size))
    return np.array(places).reshape(-1, 2), np.array(wanted)


def _gaps(stack: Stack, f: int, courses: dict[int, FloatArray], size: float) -> list[tuple[FloatArray, float]]:
    """Places of a cell's outline with another one nearer to them, across the cell, than a size."""
    prism = stack.arrangement.prism
    face = prism.faces[f]
    polygons = [
        np.concatenate([courses[e][:: 1 if forward else -1][:-1] for e, forward in loop.directed])
        for loop in face.loops
    ]
    edges = list(dict.fromkeys(face.edges))
    starts = np.concatenate([courses[e][:-1] for e in edges])
    ends = np.concatenate([courses[e][1:] for e in edges])
    owner = np.concatenate([np.full(len(courses[e]) - 1, j) for j, e in enumerate(edges)])
    corners = [{prism.edges[e].start, prism.edges[e].end} for e in edges]
    found = []
    limit = _FINER * size / _ACROSS
    for j, e in enumerate(edges):
        beside = np.array([bool(corners[j] & own) for own in corners])
        apart = ~beside[owner]
        if not apart.any():
            continue
        course = courses[e]
        step = max(1, (len(course) - 1) // _STEPS)
        for place in course[::step]:
            distance, at = nearest(place, starts[apart], ends[apart])
            k = int(np.argmin(distance))
            if distance[k] < limit:
                other = starts[apart][k] + at[k] * (ends[apart][k] - starts[apart][k])
                if is_inside((place + other) / 2.0, polygons):
                    found.append((place, float(distance[k])))
    return found
