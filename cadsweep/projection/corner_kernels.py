"""Compiled loops over the corners of a cap's quads: their sines, and which way the quads turn.

Place in the flow: how :mod:`.target` judges a cap.
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

_compiled = compiled(cache=True, error_model="numpy", nogil=True)
_part = compiled(error_model="numpy", nogil=True, inline="always")


@_part
def _cross(a, b, out):  # type: ignore[no-untyped-def]
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@_part
def _between(points, a, b, out):  # type: ignore[no-untyped-def]
    for x in range(3):
        out[x] = points[b, x] - points[a, x]


@_part
def _dot(a, b):  # type: ignore[no-untyped-def]
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@_compiled
def least_sine(points, quads, normals, counted):  # type: ignore[no-untyped-def]
    """Least sine of the corners of quads (q, 4) of points (n, 3) that count (q, 4), 1 where none does.

    About the normals (n, 3) at the nodes, or each quad's own where there are none. Not a number where a sine is none.
    """
    along, back, across, about = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    least = 1.0
    for q in range(quads.shape[0]):
        if not normals.shape[0]:
            _between(points, quads[q, 0], quads[q, 2], along)
            _between(points, quads[q, 1], quads[q, 3], back)
            _cross(along, back, about)
            size = np.sqrt(_dot(about, about))
            for x in range(3):
                about[x] /= size if size > 0.0 else 1.0
        for i in range(4):
            if not counted[q, i]:
                continue
            node = quads[q, i]
            _between(points, node, quads[q, (i + 1) & 3], along)
            _between(points, node, quads[q, (i + 3) & 3], back)
            _cross(along, back, across)
            product = np.sqrt(_dot(along, along)) * np.sqrt(_dot(back, back))
            sine = _dot(across, normals[node] if normals.shape[0] else about) / (product if product > 0.0 else 1.0)
            if not sine >= least:
                least = sine
                if np.isnan(sine):
                    return sine
    return least


@_compiled
def area_along(points, quads, normals):  # type: ignore[no-untyped-def]
    """Area of quads (q, 4), twice, as far as they turn to the normals (n, 3) at their nodes."""
    one, other, across = np.empty(3), np.empty(3), np.empty(3)
    total = 0.0
    for q in range(quads.shape[0]):
        _between(points, quads[q, 0], quads[q, 2], one)
        _between(points, quads[q, 1], quads[q, 3], other)
        _cross(one, other, across)
        for i in range(4):
            total += _dot(across, normals[quads[q, i]]) / 4.0
    return total
