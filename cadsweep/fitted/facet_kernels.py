"""Distances of points from triangles: the loops of :mod:`.facets`.

Boxes around ever fewer triangles, halved across where they are longest, say which of them need not be looked at.
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

_compiled = compiled(cache=True, nogil=True)

_FEW = 4
"""Triangles of a box that is not halved."""
_DEPTH = 64
"""Boxes that wait at once, at most: one for every halving."""


@_compiled
def _dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_compiled
def _less(a, b, share):  # type: ignore[no-untyped-def]
    """``a - share * b``."""
    return a[0] - share * b[0], a[1] - share * b[1], a[2] - share * b[2]


@_compiled
def _off_segment(off, step):  # type: ignore[no-untyped-def]
    """Squared distance of a point from a segment, given the place of the point and of its end, both off its start."""
    foot = _less(off, step, min(max(_dot(off, step) / max(_dot(step, step), 1e-300), 0.0), 1.0))
    return _dot(foot, foot)


@_compiled
def box_triangles(corners):  # type: ignore[no-untyped-def]
    """Of triangles ``corners`` (t, 3, 3) the order (t,), and the boxes (n, 2, 3): those of box i are 2i + 1 and 2i + 2.

    A box has a range of the order; its halves have that up to its middle, and from there.
    """
    n_boxes, n = 1, len(corners)
    while n > _FEW:
        n_boxes, n = 2 * n_boxes + 1, (n + 1) // 2
    order, boxes = np.arange(len(corners)), np.empty((n_boxes, 2, 3))
    middles = (corners[:, 0] + corners[:, 1] + corners[:, 2]) / 3.0
    ranges = np.empty((n_boxes, 2), dtype=np.int64)
    ranges[0, 0], ranges[0, 1] = 0, len(corners)
    for i in range(n_boxes):
        start, end = ranges[i]
        for d in range(3):
            boxes[i, 0, d], boxes[i, 1, d] = np.inf, -np.inf
            for t in order[start:end]:
                for corner in range(3):
                    boxes[i, 0, d] = min(boxes[i, 0, d], corners[t, corner, d])
                    boxes[i, 1, d] = max(boxes[i, 1, d], corners[t, corner, d])
        if 2 * i + 2 < n_boxes:
            longest = np.argmax(boxes[i, 1] - boxes[i, 0])
            order[start:end] = order[start:end][np.argsort(middles[order[start:end], longest], kind="mergesort")]
            middle = (start + end) // 2
            ranges[2 * i + 1, 0], ranges[2 * i + 1, 1] = start, middle
            ranges[2 * i + 2, 0], ranges[2 * i + 2, 1] = middle, end
    return order, boxes


@_compiled
def _off_box(point, box):  # type: ignore[no-untyped-def]
    """Squared distance of a point from a box."""
    found = 0.0
    for d in range(3):
        beyond = max(box[0, d] - point[d], point[d] - box[1, d], 0.0)
        found += beyond * beyond
    return found


@_compiled
def _off_triangle(point, corners):  # type: ignore[no-untyped-def]
    """Squared distance of a point from a triangle."""
    first = corners[0]
    off = _less(point, first, 1.0)
    along, across = _less(corners[1], first, 1.0), _less(corners[2], first, 1.0)
    a, b, c = _dot(along, along), _dot(along, across), _dot(across, across)
    d, e = _dot(off, along), _dot(off, across)
    area = max(a * c - b * b, 1e-300)
    u, v = (c * d - b * e) / area, (a * e - b * d) / area
    if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
        foot = _less(_less(off, along, u), across, v)
        return _dot(foot, foot)
    beyond = _off_segment(_less(off, along, 1.0), _less(across, along, 1.0))
    return min(_off_segment(off, along), _off_segment(off, across), beyond)


@_compiled
def nearest_triangles(points, corners, order, boxes):  # type: ignore[no-untyped-def]
    """Of ``points`` (m, 3) the distance (m,) from the nearest triangle, and which; boxes: :func:`box_triangles`."""
    away, nearest = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    waiting, off = np.empty((_DEPTH, 3), dtype=np.int64), np.empty(_DEPTH)
    for p in range(len(points)):
        best, nearest[p], n = np.inf, -1, 1
        waiting[0, 0], waiting[0, 1], waiting[0, 2], off[0] = 0, 0, len(corners), 0.0
        while n:
            n -= 1
            if off[n] >= best:
                continue
            i, start, end = waiting[n]
            if 2 * i + 2 >= len(boxes):
                for t in order[start:end]:
                    found = _off_triangle(points[p], corners[t])
                    if found < best:
                        best, nearest[p] = found, t
                continue
            middle = (start + end) // 2
            first, second = _off_box(points[p], boxes[2 * i + 1]), _off_box(points[p], boxes[2 * i + 2])
            # The nearer one is looked at first: it lies on top.
            for is_first in (first > second, first <= second):
                waiting[n, 0] = 2 * i + 1 if is_first else 2 * i + 2
                waiting[n, 1], waiting[n, 2] = (start, middle) if is_first else (middle, end)
                off[n] = first if is_first else second
                n += 1
        away[p] = np.sqrt(best)
    return away, nearest
