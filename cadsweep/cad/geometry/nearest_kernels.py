"""The nearest of some places, by comparing all of them: for few, a tree takes longer to be made.

Place in the flow: first guesses of the nearest points of curves and surfaces.
"""

from __future__ import annotations

import numpy as np

from .spline_kernels import kernel


@kernel
def nearest_rows(rows, points, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """For each of points (m, 3) the row ``out`` (m,) of `rows` (g, 3) that is nearest to it; NaN counts as far."""
    for m in range(points.shape[0]):
        least = np.inf
        out[m] = 0
        x, y, z = points[m, 0], points[m, 1], points[m, 2]
        for g in range(rows.shape[0]):
            squared = (rows[g, 0] - x) ** 2 + (rows[g, 1] - y) ** 2 + (rows[g, 2] - z) ** 2
            if squared < least:
                least = squared
                out[m] = g


@kernel
def near_on_lines(places, n_across, axis, points, rows, shares):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """For each of points (m, 3) where the lines of a grid along an axis are nearer to it than the lines beside.

    ``places`` (g, 3) are those of the grid, `n_across` of them in each line along its axis 1. ``rows`` (m, k) gets
    where the parts of the lines begin, nearest ones first, -1 where there are fewer, and ``shares`` (m, k) how far
    along the part the place is.
    """
    n_lines, most = places.shape[0] // n_across, rows.shape[1]
    ahead = n_across if axis == 0 else 1
    n_i, n_j = (n_lines - 1, n_across) if axis == 0 else (n_lines, n_across - 1)
    side_i, side_j = (0, 1) if axis == 0 else (1, 0)
    squared, share, least = np.empty((n_i, n_j)), np.empty((n_i, n_j)), np.empty(most)
    for m in range(points.shape[0]):
        for i in range(n_i):
            for j in range(n_j):
                g = i * n_across + j
                square = along = 0.0
                for c in range(3):
                    step = places[g + ahead, c] - places[g, c]
                    square += step * step
                    along += step * (points[m, c] - places[g, c])
                part = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
                away = 0.0
                for c in range(3):
                    step = places[g + ahead, c] - places[g, c]
                    away += (points[m, c] - places[g, c] - part * step) ** 2
                squared[i, j], share[i, j] = away, part
        n = 0
        for i in range(n_i):
            for j in range(n_j):
                own = squared[i, j]
                if not np.isfinite(own) or (n == most and own >= least[n - 1]):
                    continue
                before_i, before_j = max(i - side_i, 0), max(j - side_j, 0)
                after_i, after_j = min(i + side_i, n_i - 1), min(j + side_j, n_j - 1)
                if own > squared[before_i, before_j] or own > squared[after_i, after_j]:
                    continue
                n = min(n + 1, most)
                place = n - 1
                while place > 0 and own < least[place - 1]:
                    least[place], rows[m, place] = least[place - 1], rows[m, place - 1]
                    shares[m, place] = shares[m, place - 1]
                    place -= 1
                least[place], rows[m, place], shares[m, place] = own, i * n_across + j, share[i, j]
        rows[m, n:] = -1


@kernel
def other_walls(places, normals, most, turned, far):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Lower ``far`` (a, b) to how far those of a grid's places (a, b, 3) are that face elsewhere, on lines of the grid.

    At most `most` places away; they face elsewhere where the cosine between the normals (a, b, 3) is below `turned`.
    """
    n_i, n_j = far.shape
    for axis in range(2):
        for i in range(n_i):
            for j in range(n_j):
                for step in range(1, most + 1):
                    k, m = (i + step, j) if axis == 0 else (i, j + step)
                    if k >= n_i or m >= n_j:
                        break
                    cosine = squared = 0.0
                    for c in range(3):
                        cosine += normals[i, j, c] * normals[k, m, c]
                        squared += (places[i, j, c] - places[k, m, c]) ** 2
                    if cosine < turned:
                        away = np.sqrt(squared)
                        far[i, j], far[k, m] = min(far[i, j], away), min(far[k, m], away)
