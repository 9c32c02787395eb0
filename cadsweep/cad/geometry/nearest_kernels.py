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
