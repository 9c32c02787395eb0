"""What relaxing a cap spends its time on, as compiled loops: the corners of quads, and looking around a node.

Place in the flow: called by :mod:`.relax`. Nodes have four quads or five, and numpy spends its time on arrays of a few
numbers; on a gear these two were a tenth of all.
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

kernel = compiled(cache=True, nogil=True, error_model="numpy")


@compiled(nogil=True, error_model="numpy", inline="always")
def _sine(back, step, normal):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Sine from one unit vector to another, seen along a normal."""
    return (
        (back[1] * step[2] - back[2] * step[1]) * normal[0]
        + (back[2] * step[0] - back[0] * step[2]) * normal[1]
        + (back[0] * step[1] - back[1] * step[0]) * normal[2]
    )


@compiled(nogil=True, error_model="numpy", inline="always")
def _unit_steps(corners, steps):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Unit vectors ``steps`` (4, 3) from each of four corners (4, 3) to the next."""
    for i in range(4):
        following = (i + 1) % 4
        squared = 0.0
        for d in range(3):
            steps[i, d] = corners[following, d] - corners[i, d]
            squared += steps[i, d] * steps[i, d]
        length = np.sqrt(max(squared, 1e-300))
        for d in range(3):
            steps[i, d] /= length


@compiled(nogil=True, error_model="numpy", inline="always")
def _unit_step(start, end, step):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Unit vector ``step`` (3,) from one point to another."""
    squared = 0.0
    for d in range(3):
        step[d] = end[d] - start[d]
        squared += step[d] * step[d]
    length = max(np.sqrt(squared), 1e-300)
    for d in range(3):
        step[d] /= length


@kernel
def quad_sines(points, quads, normals, out):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Sines ``out`` (q, 4) of the corner angles of quads (q, 4), seen along the nodes' normals (n, 3)."""
    corners, steps = np.empty((4, 3)), np.empty((4, 3))
    for q in range(quads.shape[0]):
        for i in range(4):
            for d in range(3):
                corners[i, d] = points[quads[q, i], d]
        _unit_steps(corners, steps)
        for i in range(4):
            out[q, i] = _sine(steps[i - 1], steps[i], normals[quads[q, i]])


@kernel
def best_places(points, normals, quads, sines, starts, around, nodes, offsets, off, gain):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917  # pragma: no cover
    """For each of some nodes, the best of offsets (k, 2) in its tangent plane: ``off`` (m, 3), and the ``gain`` (m,).

    The best is where the worst corner of the node's quads has the greatest sine; offsets count in lengths of the
    shortest edge of these quads. `starts` (n + 1,) and `around` are the quads of every node, `sines` (q, 4) theirs.
    """
    first, second, trial = np.empty(3), np.empty(3), np.empty(3)
    corners, steps = np.empty((4, 3)), np.empty((4, 3))
    for m in range(len(nodes)):
        node = nodes[m]
        least = np.inf
        before = np.inf
        for use in range(starts[node], starts[node + 1]):
            q = around[use]
            for i in range(4):
                a, b = quads[q, i], quads[q, (i + 1) % 4]
                squared = 0.0
                for d in range(3):
                    squared += (points[b, d] - points[a, d]) ** 2
                least = min(least, squared)
                before = min(before, sines[q, i])
        size = np.sqrt(least)
        x, y, z = normals[node, 0], normals[node, 1], normals[node, 2]
        # The axis that the normal is farthest from gives a first direction of the plane, its cross product the second.
        if abs(x) <= abs(y) and abs(x) <= abs(z):
            first[0], first[1], first[2] = 0.0, z, -y
        elif abs(y) <= abs(z):
            first[0], first[1], first[2] = -z, 0.0, x
        else:
            first[0], first[1], first[2] = y, -x, 0.0
        length = np.sqrt(first[0] ** 2 + first[1] ** 2 + first[2] ** 2)
        for d in range(3):
            first[d] /= length
        second[0] = y * first[2] - z * first[1]
        second[1] = z * first[0] - x * first[2]
        second[2] = x * first[1] - y * first[0]
        best = -np.inf
        for k in range(len(offsets)):
            for d in range(3):
                trial[d] = size * (offsets[k, 0] * first[d] + offsets[k, 1] * second[d])
            worst = np.inf
            for use in range(starts[node], starts[node + 1]):
                q = around[use]
                for i in range(4):
                    for d in range(3):
                        corners[i, d] = points[quads[q, i], d] + (trial[d] if quads[q, i] == node else 0.0)
                _unit_steps(corners, steps)
                for i in range(4):
                    worst = min(worst, _sine(steps[i - 1], steps[i], normals[quads[q, i]]))
                if not worst > best:
                    break
            if worst > best:
                best = worst
                for d in range(3):
                    off[m, d] = trial[d]
        gain[m] = best - before


@kernel
def run_along(points, fractions):  # type: ignore[no-untyped-def]  # pragma: no cover
    """How far along a chain of points (n, d) each is, as a fraction (n,) of its length; even where it has none."""
    total = 0.0
    fractions[0] = 0.0
    for k in range(1, points.shape[0]):
        squared = 0.0
        for c in range(points.shape[1]):
            squared += (points[k, c] - points[k - 1, c]) ** 2
        total += np.sqrt(squared)
        fractions[k] = total
    for k in range(1, points.shape[0]):
        fractions[k] = k / (points.shape[0] - 1) if total == 0.0 else fractions[k] / total


@kernel
def worst_grid_corner(points, normals):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Least sine of the corners of a grid of quads (h + 1, w + 1, 3), seen along normals; -inf where one is nan."""
    rows, columns = points.shape[0], points.shape[1]
    along, across = np.empty((rows, columns - 1, 3)), np.empty((rows - 1, columns, 3))
    for k in range(rows):
        for i in range(columns - 1):
            _unit_step(points[k, i], points[k, i + 1], along[k, i])
    for k in range(rows - 1):
        for i in range(columns):
            _unit_step(points[k, i], points[k + 1, i], across[k, i])
    worst = 1.0
    for k in range(rows - 1):
        for i in range(columns - 1):
            for row in range(2):
                for column in range(2):
                    sine = _sine(along[k + row, i], across[k, i + column], normals[k + row, i + column])
                    if np.isnan(sine):
                        return -np.inf
                    worst = min(worst, sine)
    return worst
