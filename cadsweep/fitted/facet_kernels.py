"""Distances of points from triangles: the loop of :mod:`.facets`."""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

_compiled = compiled(cache=True, nogil=True)


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
def nearest_triangles(points, corners, seen):  # type: ignore[no-untyped-def]
    """Of ``points`` (m, 3) the distance (m,) from the nearest of the triangles ``seen`` (m, k) from each, and which."""
    away, nearest = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    for i in range(len(points)):
        best, nearest[i] = np.inf, seen[i, 0]
        for t in seen[i]:
            first = corners[t, 0]
            off = _less(points[i], first, 1.0)
            along, across = _less(corners[t, 1], first, 1.0), _less(corners[t, 2], first, 1.0)
            a, b, c = _dot(along, along), _dot(along, across), _dot(across, across)
            d, e = _dot(off, along), _dot(off, across)
            area = max(a * c - b * b, 1e-300)
            u, v = (c * d - b * e) / area, (a * e - b * d) / area
            if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                foot = _less(_less(off, along, u), across, v)
                found = _dot(foot, foot)
            else:
                beyond = _off_segment(_less(off, along, 1.0), _less(across, along, 1.0))
                found = min(_off_segment(off, along), _off_segment(off, across), beyond)
            if found < best:
                best, nearest[i] = found, t
        away[i] = np.sqrt(best)
    return away, nearest
