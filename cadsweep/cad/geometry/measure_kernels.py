"""The sums of ``measure``, as compiled loops: what a face's boundary adds to its area, moments and volume.

Place in the flow: called by :mod:`.measure`, which tells the method. A face has some thousand points of quadrature, and
their number is small for each edge: numpy would spend its time on calls.
"""

from __future__ import annotations

import numpy as np

from .record_kernels import ROOM, curve_point, row_point, row_room, surface_row
from .spline_kernels import callee, kernel


@callee
def _add_inner(record, panels, n_parts, rule, uv, weight, origin, space, totals):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Add `weight` times the integrals over u, from the first panel to `uv`, of the integrands; return their points."""
    room, h, found, row = space
    u, v = uv[0], uv[1]
    n, n_points = len(panels) - 1, 0
    surface_row(record, v, room, row)
    for k in range(n * n_parts):
        whole, share = k // n_parts, (k % n_parts) / n_parts
        start = panels[whole] + share * (panels[whole + 1] - panels[whole])
        if k and u <= start:
            break
        share = (k % n_parts + 1) / n_parts
        end = panels[whole] + share * (panels[whole + 1] - panels[whole])
        # Beyond the last panel's end the parameters of an edge may run on by a rounding error.
        width = u - start if k == n * n_parts - 1 else min(u, end) - start
        if width == 0.0:
            continue
        for g in range(rule.shape[1]):
            row_point(record, row, start + width * rule[0, g], v, room, h, found)
            n0 = found[1, 1] * found[2, 2] - found[1, 2] * found[2, 1]
            n1 = found[1, 2] * found[2, 0] - found[1, 0] * found[2, 2]
            n2 = found[1, 0] * found[2, 1] - found[1, 1] * found[2, 0]
            size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
            x, y, z = found[0, 0] - origin[0], found[0, 1] - origin[1], found[0, 2] - origin[2]
            factor = weight * width * rule[1, g]
            totals[0] += factor * size
            totals[1] += factor * size * x
            totals[2] += factor * size * y
            totals[3] += factor * size * z
            totals[4] += factor * n0
            totals[5] += factor * n1
            totals[6] += factor * n2
            totals[7] += factor * (x * n0 + y * n1 + z * n2)
        n_points += rule.shape[1]
    return n_points


@kernel
def boundary_sums(surface, rule, n_parts, n_least, edges, loops, stops, first_stops, close, totals):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Line integral round the loops of a face, into ``totals`` (8,); the number of points it took.

    `surface` is the record, the ends of the panels in u, and the point that moments are about. `edges`, in the order of
    their loops, are all records, where each begins, its first and last parameter and the shift into the branch (n, 4),
    and its sense, 1 or -1; `loops` (n,) numbers the loop of each; ``stops[first_stops[j]:first_stops[j +
    1]]`` the places where edge j is less than smooth, its ends among them. Each is cut in `n_least` panels at least.
    Where `close` is set, a gap in the parameters to the next edge of the loop is bridged by a straight line.
    """
    record, panels, origin = surface
    curves, starts, ends, senses = edges
    room, on_curve = np.empty(ROOM), np.empty((2, 3))
    space = room, np.empty((3, 4)), np.empty((3, 3)), row_room(record)
    uv, first_of_loop, before = np.empty(2), np.empty(2), np.empty(2)
    n_points = 0
    n = len(starts)
    totals[:] = 0.0
    for j in range(n):
        curve = curves[starts[j] :]
        first, last, shift_u, shift_v = ends[j, 0], ends[j, 1], ends[j, 2], ends[j, 3]
        pieces = first_stops[j + 1] - first_stops[j] - 1
        parts = max(1, -(-n_least // pieces)) * n_parts
        sense = senses[j]
        opens = j == 0 or loops[j - 1] != loops[j]
        curve_point(curve, first if sense > 0.0 else last, room, on_curve)
        start_u, start_v = on_curve[0, 0] + shift_u, on_curve[0, 1] + shift_v
        if opens:
            first_of_loop[0], first_of_loop[1] = start_u, start_v
        elif close:
            n_points += _add_gap(record, panels, n_parts, rule, before, start_u, start_v, origin, space, totals)
        for piece in range(pieces):
            low, high = stops[first_stops[j] + piece], stops[first_stops[j] + piece + 1]
            for part in range(parts):
                a, b = low + part / parts * (high - low), low + (part + 1) / parts * (high - low)
                for g in range(rule.shape[1]):
                    curve_point(curve, a + (b - a) * rule[0, g], room, on_curve)
                    weight = sense * (b - a) * rule[1, g] * on_curve[1, 1]
                    if weight != 0.0:
                        uv[0], uv[1] = on_curve[0, 0] + shift_u, on_curve[0, 1] + shift_v
                        n_points += _add_inner(record, panels, n_parts, rule, uv, weight, origin, space, totals)
        curve_point(curve, last if sense > 0.0 else first, room, on_curve)
        before[0], before[1] = on_curve[0, 0] + shift_u, on_curve[0, 1] + shift_v
        if close and (j + 1 == n or loops[j + 1] != loops[j]):
            n_points += _add_gap(
                record,
                panels,
                n_parts,
                rule,
                before,
                first_of_loop[0],
                first_of_loop[1],
                origin,
                space,
                totals,
            )
    return n_points


@callee
def _add_gap(record, panels, n_parts, rule, before, u, v, origin, space, totals):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Add what the straight line in the parameters from `before` (2,) to u, v gives; return the points it took."""
    gap_u, gap_v = u - before[0], v - before[1]
    n_points = 0
    if gap_v != 0.0:
        uv = np.empty(2)
        for g in range(rule.shape[1]):
            uv[0], uv[1] = before[0] + rule[0, g] * gap_u, before[1] + rule[0, g] * gap_v
            n_points += _add_inner(record, panels, n_parts, rule, uv, rule[1, g] * gap_v, origin, space, totals)
    return n_points
