"""Closed polygons in the plane, as arrays of their corners; numpy alone.

Place in the flow: wherever a face or the plan of a part is seen from one direction.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import BoolArray, FloatArray, IntArray

_MOST_PAIRS = 10**6
"""Pairs of a place and a segment that are looked at together."""


def next_corners(loops: Sequence[NDArray[Any]]) -> IntArray:
    """Of every corner of closed polygons (m, ...), one after the other in one numbering: the corner after it."""
    sizes = np.array([len(loop) for loop in loops], dtype=np.int64)
    ends = np.cumsum(sizes)
    after = np.arange(1, int(sizes.sum()) + 1)
    after[ends[sizes > 0] - 1] -= sizes[sizes > 0]
    return after


def mean_sides(loops: Sequence[FloatArray]) -> FloatArray:
    """Mean length of the two sides at every corner of closed polygons, one after the other."""
    starts, after = np.concatenate(loops), next_corners(loops)
    steps = np.linalg.norm(starts[after] - starts, axis=1)
    before = np.empty_like(steps)
    before[after] = steps
    return np.asarray((steps + before) / 2.0)


def is_inside(loops: Sequence[FloatArray], places: FloatArray) -> BoolArray:
    """Which places (n, 2) lie inside closed polygons (m, 2), by the parity of their crossings with a ray."""
    starts = np.concatenate(loops)
    ends = starts[next_corners(loops)]
    order = np.argsort(places[:, 1], kind="stable")
    x, y = places[order].T
    # A ray crosses a segment where its height is between the ends': places by height, each segment has a run of them.
    first = np.searchsorted(y, np.minimum(starts[:, 1], ends[:, 1]))
    runs = np.searchsorted(y, np.maximum(starts[:, 1], ends[:, 1])) - first
    crossings = np.zeros(len(places), dtype=np.int64)
    total = np.cumsum(runs)
    n_chunks = 1 + int(total[-1]) // _MOST_PAIRS
    bounds = np.searchsorted(total, np.linspace(0, total[-1], n_chunks + 1)[1:-1])
    for chunk in np.split(np.arange(len(starts)), bounds):
        segment = np.repeat(chunk, runs[chunk])
        within = np.arange(len(segment)) - np.repeat(np.cumsum(runs[chunk]) - runs[chunk], runs[chunk])
        place = first[segment] + within
        share = (y[place] - starts[segment, 1]) / (ends[segment, 1] - starts[segment, 1])
        right = x[place] < starts[segment, 0] + share * (ends[segment, 0] - starts[segment, 0])
        crossings += np.bincount(place[right], minlength=len(places))
    inside = np.empty(len(places), dtype=bool)
    inside[order] = crossings % 2 == 1
    return inside


def interior_angles(polygon: FloatArray) -> FloatArray:
    """Angles (m,) of a polygon (m, 2) at its corners, from 0 to 2 pi, on its left."""
    after, before = np.roll(polygon, -1, axis=0) - polygon, np.roll(polygon, 1, axis=0) - polygon
    turns = np.arctan2(before[:, 1], before[:, 0]) - np.arctan2(after[:, 1], after[:, 0])
    return np.asarray(np.mod(turns, 2 * np.pi))


def signed_area(polygon: FloatArray) -> float:
    """Area of a polygon (m, 2), positive where it runs counter-clockwise."""
    x, y = (polygon - polygon.mean(axis=0)).T
    return float(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def signed_areas(corners: FloatArray, stops: IntArray) -> FloatArray:
    """Areas (n,) of polygons whose corners (m, 2) stand one after the other, each up to its stop (n,)."""
    starts = np.append(0, stops[:-1])
    after = np.arange(1, len(corners) + 1)
    after[stops - 1] = starts
    # About a corner of each: far from the origin the products would lose their digits.
    own = corners - np.repeat(corners[starts], stops - starts, axis=0)
    x, y = own.T
    following_x, following_y = own[after].T
    return 0.5 * np.add.reduceat(x * following_y - following_x * y, starts)
