"""A face whose quads are one grid: found in them, and what is known on its rim carried inside by its lines.

Place in the flow: called by :mod:`.carried`, where linking sides and other four-sided faces keep the places that they
have in their grids.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray


def find_grid(quads: IntArray, loops: Sequence[IntArray]) -> IntArray | None:
    """Nodes of a face in rows and columns.

    Parameters
    ----------
    quads : (q, 4) int64
    loops : sequence of int64 arrays
        Boundary cycles.

    Returns
    -------
    (r, c) int64 or None
        None where the quads are no single grid with four corners.
    """
    if len(loops) != 1:
        return None
    loop = loops[0]
    corners = np.flatnonzero(np.bincount(quads.ravel(), minlength=int(loop.max()) + 1)[loop] == 1)
    if len(corners) != 4:
        return None
    n_columns, n_rows, *others = np.diff(np.append(corners, corners[0] + len(loop))).tolist()
    if others != [n_columns, n_rows] or n_columns * n_rows != len(quads):
        return None
    base = int(quads.max()) + 1
    starts, ends = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    keys = starts * base + ends
    order = np.argsort(keys)
    ring = np.roll(loop, -corners[0])
    if not np.isin(ring[0] * base + ring[1], keys):  # the cycle runs against the quads
        ring = np.roll(ring[::-1], 1)
        n_columns, n_rows = n_rows, n_columns
    rows = [ring[: n_columns + 1]]
    for _ in range(n_rows):
        wanted = rows[-1][:-1] * base + rows[-1][1:]
        at = order[np.minimum(np.searchsorted(keys, wanted, sorter=order), len(keys) - 1)]
        if not np.array_equal(keys[at], wanted):
            return None
        quad, side = at // 4, at % 4
        far, near = quads[quad, (side + 2) % 4], quads[quad, (side + 3) % 4]
        if not np.array_equal(far[:-1], near[1:]):
            return None
        rows.append(np.append(near, far[-1]))
    grid = np.stack(rows)
    rim = np.concatenate([grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]])
    return grid if np.array_equal(rim, ring) else None


def carry_inside(grid: IntArray, points: FloatArray, values: FloatArray) -> FloatArray:
    """Values inside a grid from those on its rim, by transfinite interpolation with the fractions of its lines.

    Parameters
    ----------
    grid : (r, c) int64
        Places in the other two.
    points : (n, 3) float64
        Where the nodes are: fractions are of lengths along rows and columns.
    values : (n, d) float64
        Read on the rim of the grid alone.

    Returns
    -------
    (n, d) float64
        On the rim what was given.
    """
    along, across = _fractions(points[grid])[..., None], _fractions(points[grid.T]).T[..., None]
    own = values[grid]
    by_rows = (1.0 - along) * own[:, :1] + along * own[:, -1:]
    by_columns = (1.0 - across) * own[:1] + across * own[-1:]
    of_corners = (1.0 - across) * ((1.0 - along) * own[0, 0] + along * own[0, -1]) + across * (
        (1.0 - along) * own[-1, 0] + along * own[-1, -1]
    )
    inside = by_rows + by_columns - of_corners
    found = np.empty_like(values)
    found[grid] = inside
    rim = np.concatenate([grid[0], grid[-1], grid[:, 0], grid[:, -1]])
    found[rim] = values[rim]
    return found


def _fractions(lines: FloatArray) -> FloatArray:
    """Fractions (r, c) of the lengths of lines of nodes (r, c, 3); even ones where a line has no length."""
    steps = np.linalg.norm(np.diff(lines, axis=1), axis=2)
    steps[steps.sum(axis=1) <= 0.0] = 1.0
    run = np.cumsum(steps, axis=1)
    return np.concatenate([np.zeros((len(run), 1)), run / run[:, -1:]], axis=1)


__all__ = ["carry_inside", "find_grid"]
