"""Nearest points on surfaces, from their records, as compiled loops.

Place in the flow: ``face_surface`` calls these: thousands of nodes of a mesh are held against their faces on every
run, a few at a time, and numpy takes ten times as long for it. In closed form where there is one; else from the best
place of a grid by Gauss-Newton.
"""

from __future__ import annotations

import numpy as np

from .record_kernels import ROOM, cross_and_norms, row_point, row_room, surface_point, surface_row
from .records import CONE, TORUS
from .spline_kernels import kernel


@kernel
def exact_feet(record, box, points, guess, by_guess, uv):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917  # pragma: no cover
    """Parameters ``uv`` (m, 2) of points by a cone, cylinder, sphere or torus, in the branch of a guess (m or 1, 2).

    At an apex or a pole the angle is free; where `by_guess` is set, the guess is taken there.
    """
    kind, a, b = int(record[0]), record[15], record[16]
    room, h, found, cross = np.empty(ROOM), np.empty((3, 4)), np.empty((3, 3)), np.empty(3)
    slopes = np.empty((2, points.shape[0]))
    straight = not by_guess or (kind == CONE and b == 0.0)
    # Beyond the apex of a cone, or the axis of a torus that is thicker than wide, radii are negative.
    middle = 0.5 * (box[0, 1] + box[1, 1])
    beyond = (a > 0.0 and a + b * np.cos(middle) < 0.0) if kind == TORUS else a + middle * np.sin(b) < 0.0
    for m in range(points.shape[0]):
        x = y = z = 0.0
        for c in range(3):
            off = points[m, c] - record[3 + c]
            x, y, z = x + off * record[6 + c], y + off * record[9 + c], z + off * record[12 + c]
        r = np.hypot(x, y)
        if beyond:
            x, y, r = -x, -y, -r
        uv[m, 0] = np.arctan2(y, x)
        if kind == TORUS:
            uv[m, 1] = np.arctan2(z, r - a)
        else:
            v = (r - a) * np.sin(b) + z * np.cos(b)
            if b != 0.0:
                apex = -a / np.sin(b)
                v = max(v, apex) if (b > 0.0) != beyond else min(v, apex)
            uv[m, 1] = v
        for j in range(2):
            period = record[1 + j]
            if period > 0.0:
                uv[m, j] += period * np.round((guess[m % len(guess), j] - uv[m, j]) / period)
        if not straight:
            surface_point(record, guess[m, 0], guess[m, 1], room, h, found)
            _, slopes[0, m], slopes[1, m] = cross_and_norms(found, cross)
    if straight or points.shape[0] == 0:
        return
    least = 1e-3 * max(np.abs(box).max(), 0.0)
    for j in range(2):
        if record[1 + j] > 0.0:
            limit = 1e-7 * max(slopes[j].max(), least)
            for m in range(points.shape[0]):
                if slopes[j, m] <= limit:
                    uv[m, j] = guess[m, j]


MOST_STEPS = 50
"""Descents need about ten steps; those that need fifty go in circles."""


@kernel
def descended_feet(record, lower, upper, points, uv, distances):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917  # pragma: no cover
    """Nearest parameters ``uv`` (m, 2), from the start values in it, and the distances (m,) of points (m, 3) there.

    Gauss-Newton, with steps that are halved until they come nearer, and that slide along the limits where they would
    leave them.
    """
    room, h, found = np.empty(ROOM), np.empty((3, 4)), np.empty((3, 3))
    place, a, b = np.empty(3), np.empty(3), np.empty(3)
    enough = 1e-13 * max(upper[0] - lower[0], upper[1] - lower[1])
    for m in range(points.shape[0]):
        u, v = uv[m, 0], uv[m, 1]
        new_u, new_v = u, v
        squared = np.inf
        e = f = aa = ab = bb = 0.0
        moved = np.inf
        for step in range(MOST_STEPS):
            nearer = False
            for _ in range(10):
                surface_point(record, new_u, new_v, room, h, found)
                new_squared = 0.0
                for c in range(3):
                    place[c] = found[0, c]
                    new_squared += (points[m, c] - place[c]) ** 2
                if new_squared <= squared * (1.0 + 1e-14):
                    nearer = True
                    break
                new_u, new_v = 0.5 * (new_u + u), 0.5 * (new_v + v)
            if not nearer:
                break
            moved = max(abs(new_u - u), abs(new_v - v))
            u, v, squared = new_u, new_v, new_squared
            if step > 0 and moved <= enough:
                break
            aa = ab = bb = e = f = 0.0
            for c in range(3):
                a[c], b[c] = found[1, c], found[2, c]
                off = points[m, c] - place[c]
                aa += a[c] * a[c]
                ab += a[c] * b[c]
                bb += b[c] * b[c]
                e += a[c] * off
                f += b[c] * off
            along_u, along_v = e / aa if aa > 0.0 else 0.0, f / bb if bb > 0.0 else 0.0
            determinant = aa * bb - ab * ab
            if determinant > 1e-14 * max(aa * bb, 1e-300):
                step_u, step_v = (bb * e - ab * f) / determinant, (aa * f - ab * e) / determinant
            elif aa >= bb:
                step_u, step_v = along_u, 0.0
            else:
                step_u, step_v = 0.0, along_v
            # At a limit that the step would cross, the other parameter goes alone.
            if not lower[0] < u + step_u < upper[0] and (u in (lower[0], upper[0])):
                step_u, step_v = 0.0, along_v
            elif not lower[1] < v + step_v < upper[1] and (v in (lower[1], upper[1])):
                step_u, step_v = along_u, 0.0
            new_u = min(max(u + step_u, lower[0]), upper[0])
            new_v = min(max(v + step_v, lower[1]), upper[1])
        uv[m, 0], uv[m, 1] = u, v
        distances[m] = np.sqrt(squared)


@kernel
def turning_stops(record, stops, across, axis, least, most, largest_turn):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Parameters along one axis, `least` to `most` intervals, between which the surface hardly turns.

    It is looked at between `stops`, on five lines from ``across[0]`` to ``across[1]``. Half of the intervals go with
    the turns, half with the parameter.
    """
    room, h, found = np.empty(ROOM), np.empty((3, 4)), np.empty((3, 3))
    n = 16 * (len(stops) - 1) + 1
    fine = np.empty(n)
    for k in range(n):
        whole = min(k // 16, len(stops) - 2)
        fine[k] = stops[whole] + (k - 16 * whole) / 16 * (stops[whole + 1] - stops[whole])
    turns = np.zeros(n - 2)
    steps = np.empty((n - 1, 3))
    last = np.empty(3)
    for line in range(5):
        other = across[0] + line / 4 * (across[1] - across[0])
        for k in range(n):
            u, v = (fine[k], other) if axis == 0 else (other, fine[k])
            surface_point(record, u, v, room, h, found)
            for c in range(3):
                if k:
                    steps[k - 1, c] = found[0, c] - last[c]
                last[c] = found[0, c]
        for k in range(n - 2):
            dot = first = second = 0.0
            for c in range(3):
                dot += steps[k, c] * steps[k + 1, c]
                first += steps[k, c] ** 2
                second += steps[k + 1, c] ** 2
            cosine = dot / max(np.sqrt(first) * np.sqrt(second), 1e-300)
            turns[k] = max(turns[k], np.arccos(min(max(cosine, -1.0), 1.0)))
    total = turns.sum()
    intervals = int(min(max(np.ceil(total / largest_turn), least), most))
    share = np.empty(n)
    run = 0.0
    for k in range(n):
        if 0 < k < n - 1:
            run += turns[k - 1]
        share[k] = k / (n - 1) + (run / total if total > 0.0 else 0.0)
    return np.interp(np.linspace(0.0, share[-1], intervals + 1), share, fine)


@kernel
def grid_places(record, u, v, uv, places, normals):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Parameters ``uv`` (g, 2), points ``places`` and unit normals (g, 3) of a grid, v running faster.

    The normals are those of the parameters' sense; at a singular point they are 0.
    """
    room, h, found, cross = np.empty(ROOM), np.empty((3, 4)), np.empty((3, 3)), np.empty(3)
    norms = np.empty(len(uv))
    row = row_room(record)
    for j in range(len(v)):
        surface_row(record, v[j], room, row)
        for i in range(len(u)):
            k = i * len(v) + j
            uv[k, 0], uv[k, 1] = u[i], v[j]
            row_point(record, row, u[i], v[j], room, h, found)
            norms[k], by_u, by_v = cross_and_norms(found, cross)
            if not norms[k] > 1e-9 * by_u * by_v:
                norms[k] = 0.0
            for c in range(3):
                places[k, c] = found[0, c]
                normals[k, c] = cross[c]
    least = 1e-9 * norms.max()
    for k in range(len(uv)):
        for c in range(3):
            normals[k, c] = normals[k, c] / norms[k] if norms[k] > least else 0.0
