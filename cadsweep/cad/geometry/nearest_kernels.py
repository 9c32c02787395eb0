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
def lowest_rows(rows, n_across, points, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """For each of points (m, 3) rows ``out`` (m, k) of a grid that are nearer to it than all eight around them.

    `rows` (g, 3) are places of the grid, `n_across` of them in each line of it. The nearest of these rows come first;
    -1 where there are fewer than k.
    """
    n_lines = rows.shape[0] // n_across
    squared = np.empty(rows.shape[0])
    most = out.shape[1]
    least = np.empty(most)
    for m in range(points.shape[0]):
        x, y, z = points[m, 0], points[m, 1], points[m, 2]
        for g in range(rows.shape[0]):
            squared[g] = (rows[g, 0] - x) ** 2 + (rows[g, 1] - y) ** 2 + (rows[g, 2] - z) ** 2
        n = 0
        for i in range(n_lines):
            for j in range(n_across):
                own = squared[i * n_across + j]
                if n == most and not own < least[n - 1]:
                    continue
                lowest = np.isfinite(own)
                for a in range(max(i - 1, 0), min(i + 2, n_lines)):
                    for b in range(max(j - 1, 0), min(j + 2, n_across)):
                        lowest = lowest and own <= squared[a * n_across + b]
                if not lowest:
                    continue
                if n < most:
                    n += 1
                place = n - 1
                while place > 0 and own < least[place - 1]:
                    least[place], out[m, place] = least[place - 1], out[m, place - 1]
                    place -= 1
                least[place], out[m, place] = own, i * n_across + j
        out[m, n:] = -1
