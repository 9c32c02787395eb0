"""The nearest of some places, by comparing all of them: for few, a tree takes longer to be made.

Place in the flow: first guesses of the nearest points of curves and surfaces.
"""

from __future__ import annotations

import numpy as np

from .spline_kernels import callee, kernel


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
def block_boxes(places, n_across, width, boxes, widest):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Boxes (p, q, 2, 3) of blocks of a grid's places, `width` cells wide, and the widest cell of each (p, q)."""
    n_lines = places.shape[0] // n_across
    boxes[:, :, 0], boxes[:, :, 1], widest[:] = np.inf, -np.inf, 0.0
    for i in range(n_lines):
        for j in range(n_across):
            g = i * n_across + j
            ahead = beside = 0.0
            for c in range(3):
                if i + 1 < n_lines:
                    ahead += (places[g + n_across, c] - places[g, c]) ** 2
                if j + 1 < n_across:
                    beside += (places[g + 1, c] - places[g, c]) ** 2
            cell = np.sqrt(max(ahead, beside))
            # A place on the border of two blocks belongs to both.
            for p in range(max(i - 1, 0) // width, min(i // width, boxes.shape[0] - 1) + 1):
                for q in range(max(j - 1, 0) // width, min(j // width, boxes.shape[1] - 1) + 1):
                    widest[p, q] = max(widest[p, q], cell)
                    for c in range(3):
                        boxes[p, q, 0, c] = min(boxes[p, q, 0, c], places[g, c])
                        boxes[p, q, 1, c] = max(boxes[p, q, 1, c], places[g, c])


@callee
def from_part(places, g, following, point):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Squared distance of a point from the line between two of a grid's places, and how far along that is."""
    square = along = 0.0
    for c in range(3):
        step = places[following, c] - places[g, c]
        square += step * step
        along += step * (point[c] - places[g, c])
    share = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
    away = 0.0
    for c in range(3):
        away += (point[c] - places[g, c] - share * (places[following, c] - places[g, c])) ** 2
    return away, share


@kernel
def near_on_lines(places, n_across, axis, blocks, points, found, cells, rows, shares):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917  # pragma: no cover
    """For each of points (m, 3) where the lines of a grid along an axis are nearer to it than the lines beside.

    ``places`` (g, 3) are those of the grid, `n_across` of them in each line along its axis 1; ``blocks`` their boxes
    (p, q, 2, 3), the widest cell of each, and how many cells wide they are. Left out is what cannot be nearer than
    ``found`` (m,): a cell reaches no farther from its lines than it is wide. So is what lies beside the cells (m, 2)
    where that was found, unless a line is nearer there: the same descent would be made again; and of every line what
    is nearer a little along it. ``rows`` (m, k) gets where the parts of the lines begin, nearest ones first, -1 where
    there are fewer, and ``shares`` (m, k) how far along the part the place is.
    """
    boxes, widest, width = blocks
    n_lines, most = places.shape[0] // n_across, rows.shape[1]
    ahead, beside = (n_across, 1) if axis == 0 else (1, n_across)
    n_i, n_j = (n_lines - 1, n_across) if axis == 0 else (n_lines, n_across - 1)
    least = np.empty(most)
    for m in range(points.shape[0]):
        n = 0
        for p in range(boxes.shape[0]):
            for q in range(boxes.shape[1]):
                limit = (found[m] + widest[p, q]) ** 2
                square = 0.0
                for c in range(3):
                    off = max(boxes[p, q, 0, c] - points[m, c], points[m, c] - boxes[p, q, 1, c], 0.0)
                    square += off * off
                if square > limit:
                    continue
                for i in range(p * width, min((p + 1) * width, n_i) if p + 1 < boxes.shape[0] else n_i):
                    for j in range(q * width, min((q + 1) * width, n_j) if q + 1 < boxes.shape[1] else n_j):
                        g = i * n_across + j
                        own, share = from_part(places, g, g + ahead, points[m])
                        if not own <= limit or (n == most and own >= least[n - 1]):
                            continue
                        if own >= found[m] ** 2 and abs(i - cells[m, 0]) <= 1 and abs(j - cells[m, 1]) <= 1:
                            continue
                        # The following part of the line begins where this one ends, and is as near there.
                        k, k_last = (i, n_i - 1) if axis == 0 else (j, n_j - 1)
                        if share == 1.0 and k < k_last:
                            continue
                        if share == 0.0 and k > 0 and from_part(places, g - ahead, g, points[m])[1] < 1.0:
                            continue
                        at, last = (j, n_across - 1) if axis == 0 else (i, n_lines - 1)
                        if at > 0 and own > from_part(places, g - beside, g - beside + ahead, points[m])[0]:
                            continue
                        if at < last and own > from_part(places, g + beside, g + beside + ahead, points[m])[0]:
                            continue
                        n = min(n + 1, most)
                        place = n - 1
                        while place > 0 and own < least[place - 1]:
                            least[place], rows[m, place] = least[place - 1], rows[m, place - 1]
                            shares[m, place] = shares[m, place - 1]
                            place -= 1
                        least[place], rows[m, place], shares[m, place] = own, g, share
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
