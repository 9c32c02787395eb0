"""B-splines, rational or not, evaluated by compiled loops: one parameter or thousands.

Place in the flow: ``nurbs`` and ``nearest`` call these. Compiled, because curves and surfaces are asked for a few
parameters at a time, hundreds of thousands of times on a part with hundreds of faces, and numpy spends its time on
calls (the table in ``docs/performance.md`` has what else was measured).

Method: the Cox-de Boor recurrence and its derivatives (Piegl and Tiller, "The NURBS Book", 2nd ed., sections 2.3 and
2.5); rational points by the quotient rule on homogeneous poles.
"""

from __future__ import annotations

import numpy as np

from ...compiled import compiled

kernel = compiled(cache=True, nogil=True, error_model="numpy")
part = compiled(nogil=True, error_model="numpy", inline="always")
callee = compiled(nogil=True, error_model="numpy")

NEAR = 1e-9
"""Miss of an arc length, as a share of its interval, after which Newton's step leaves nothing but rounding."""


@part
def into_knots(knots, degree, n_poles, period, t):  # type: ignore[no-untyped-def]  # pragma: no cover
    """The parameter brought into the knots of a periodic curve or surface (period 0: of none), and its span.

    The span has a width; the end belongs to the last one, and what is beyond the knots to the first or last.
    """
    first, last = knots[0], knots[-1]
    if period > 0.0 and (t < first or t > last):
        t = first + (t - first) % period
    low, high = degree, n_poles
    while high - low > 1:
        middle = (low + high) // 2
        if knots[middle] <= t:
            low = middle
        else:
            high = middle
    while low > degree and knots[low] == knots[low + 1]:
        low -= 1
    while knots[low] == knots[low + 1]:
        low += 1
    return t, low


@part
def functions(knots, degree, span, t, values, slopes):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """The basis functions that do not vanish in a span, and their derivatives, each (degree + 1,)."""
    values[0] = 1.0
    slopes[0] = 0.0
    for p in range(1, degree + 1):
        if p == degree:
            slopes[: p + 1] = 0.0
            for j in range(p):
                share = degree * values[j] / (knots[span + j + 1] - knots[span + j + 1 - p])
                slopes[j] -= share
                slopes[j + 1] += share
        saved = 0.0
        for j in range(p):
            right, left = knots[span + j + 1], knots[span + j + 1 - p]
            share = values[j] / (right - left)
            values[j] = saved + (right - t) * share
            saved = (t - left) * share
        values[p] = saved


@part
def second_derivatives(knots, degree, span, t, lower, found):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Second derivatives (degree + 1,) of the basis functions, from the first ones of the degree below."""
    found[: degree + 1] = 0.0
    if degree < 2:
        return
    p = degree - 1
    values = np.empty(degree + 1)
    functions(knots, p, span, t, values, lower)
    for j in range(degree):
        share = degree * lower[j] / (knots[span + j + 1] - knots[span + j + 1 - degree])
        found[j] -= share
        found[j + 1] += share


@kernel
def curve_derivatives(knots, degree, poles, period, parameters, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Points and derivatives ``out`` (order + 1, m, d) of a curve; poles (n, d), or (n, d + 1) homogeneous."""
    n, width = poles.shape
    order, d = out.shape[0] - 1, out.shape[2]
    f0, f1, f2, lower = np.empty(degree + 1), np.empty(degree + 1), np.empty(degree + 1), np.empty(degree + 1)
    h = np.empty((3, width))
    for m in range(len(parameters)):
        t, span = into_knots(knots, degree, n, period, parameters[m])
        functions(knots, degree, span, t, f0, f1)
        if order > 1:
            second_derivatives(knots, degree, span, t, lower, f2)
        h[:] = 0.0
        for j in range(degree + 1):
            for c in range(width):
                pole = poles[span - degree + j, c]
                h[0, c] += f0[j] * pole
                h[1, c] += f1[j] * pole
                if order > 1:
                    h[2, c] += f2[j] * pole
        if width == d:
            for k in range(order + 1):
                for c in range(d):
                    out[k, m, c] = h[k, c]
            continue
        for c in range(d):
            out[0, m, c] = h[0, c] / h[0, d]
            if order > 0:
                out[1, m, c] = (h[1, c] - h[1, d] * out[0, m, c]) / h[0, d]
            if order > 1:
                out[2, m, c] = (h[2, c] - 2.0 * h[1, d] * out[1, m, c] - h[2, d] * out[0, m, c]) / h[0, d]


@part
def speed_at(knots, degree, poles, period, d, t, room):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Length of the derivative of a curve in `d` dimensions; `room` (4, any degree + 1 and poles' width)."""
    n, width = poles.shape
    t, span = into_knots(knots, degree, n, period, t)
    f0, f1, point, slope = room[0], room[1], room[2], room[3]
    functions(knots, degree, span, t, f0, f1)
    for c in range(width):
        point[c] = 0.0
        slope[c] = 0.0
        for j in range(degree + 1):
            pole = poles[span - degree + j, c]
            point[c] += f0[j] * pole
            slope[c] += f1[j] * pole
    total = 0.0
    for c in range(d):
        part = slope[c] if width == d else (slope[c] - slope[d] * point[c] / point[d]) / point[d]
        total += part * part
    return np.sqrt(total)


@part
def arc_between(knots, degree, poles, period, d, rule, low, high, room):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Arc length between two parameters by a quadrature `rule` (2, k) of nodes and weights on 0 to 1."""
    total = 0.0
    for k in range(rule.shape[1]):
        total += rule[1, k] * speed_at(knots, degree, poles, period, d, low + (high - low) * rule[0, k], room)
    return (high - low) * total


@kernel
def arc_lengths(knots, degree, poles, period, d, rule, lower, upper, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Arc lengths ``out`` (m,) of a curve from `lower` (m,) to `upper` (m,)."""
    room = np.empty((4, max(degree + 1, poles.shape[1])))
    for m in range(len(lower)):
        out[m] = arc_between(knots, degree, poles, period, d, rule, lower[m], upper[m], room)


@kernel
def arc_table(knots, degree, poles, period, d, rule, stops, limits):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Interval ends and the arc lengths up to them, from stops (s,) between which the curve is smooth.

    `limits` are how often an interval is halved at most, and the share of the length up to which the lengths of an
    interval and of its halves are the same.
    """
    room = np.empty((4, max(degree + 1, poles.shape[1])))
    ends = np.empty(2 * len(stops) - 1)
    for k in range(len(stops)):
        ends[2 * k] = stops[k]
        if k + 1 < len(stops):
            ends[2 * k + 1] = stops[k] + (stops[k + 1] - stops[k]) / 2.0
    whole = np.empty(0)
    for _ in range(int(limits[0])):
        n = len(ends) - 1
        whole, halves = np.empty(n), np.empty(n)
        for k in range(n):
            low, high = ends[k], ends[k + 1]
            middle = (low + high) / 2.0
            whole[k] = arc_between(knots, degree, poles, period, d, rule, low, high, room)
            halves[k] = arc_between(knots, degree, poles, period, d, rule, low, middle, room)
            halves[k] += arc_between(knots, degree, poles, period, d, rule, middle, high, room)
        coarse = np.abs(whole - halves) > limits[1] * halves.sum()
        n_coarse = coarse.sum()
        if n_coarse == 0:
            break
        finer = np.empty(len(ends) + n_coarse)
        finer[0] = ends[0]
        at = 1
        for k in range(n):
            if coarse[k]:
                finer[at] = (ends[k] + ends[k + 1]) / 2.0
                at += 1
            finer[at] = ends[k + 1]
            at += 1
        ends = finer
    lengths = np.zeros(len(ends))
    for k in range(len(ends) - 1):
        if len(whole) < len(ends) - 1:  # halved once more after the last sums
            lengths[k + 1] = lengths[k] + arc_between(knots, degree, poles, period, d, rule, ends[k], ends[k + 1], room)
        else:
            lengths[k + 1] = lengths[k] + whole[k]
    return ends, lengths


@kernel
def arc_parameters(knots, degree, poles, period, d, rule, ends, lengths, wanted, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Parameters ``out`` (m,) at arc lengths (m,), by a table of interval ends and the lengths up to them.

    Newton's method, each by itself, so that no answer depends on what else is asked for.
    """
    room = np.empty((4, max(degree + 1, poles.shape[1])))
    total, last = lengths[-1], len(ends) - 2
    mean = total / (ends[-1] - ends[0])
    for m in range(len(wanted)):
        k = min(max(np.searchsorted(lengths, wanted[m], side="right") - 1, 0), last)
        step = lengths[k + 1] - lengths[k]
        t = ends[k] + (ends[k + 1] - ends[k]) * (wanted[m] - lengths[k]) / (step if step > 0.0 else 1.0)
        for _ in range(20):
            miss = lengths[k] + arc_between(knots, degree, poles, period, d, rule, ends[k], t, room) - wanted[m]
            if abs(miss) <= 4e-16 * total:
                break
            speed = speed_at(knots, degree, poles, period, d, t, room)
            new = min(max(t - miss / (speed if speed > 0.0 else mean), ends[k]), ends[k + 1])
            # Where it is near, a step doubles the digits: this was the last one that a sum can tell from the next.
            last_step = new == t or (speed > 0.0 and abs(miss) <= NEAR * min(step, speed * (ends[k + 1] - ends[k])))
            t = new
            if last_step:
                break
        out[m] = t


@kernel
def nearest_parameters(knots, degree, poles, period, d, samples, places, points, limits, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Parameters ``out`` (m,) of the curve nearest to points (m, 3), from the nearest of its samples (s,) and places.

    Newton's method between the samples beside that one; the Gauss-Newton term stands in where the full second
    derivative is not positive. `limits` are the numbers of rounds, and the move below which none follows.
    """
    n, width = poles.shape
    f0, f1, f2, lower = np.empty(degree + 1), np.empty(degree + 1), np.empty(degree + 1), np.empty(degree + 1)
    h = np.empty((3, width))
    most, enough = int(limits[0]), limits[1]
    for m in range(points.shape[0]):
        row, least = 0, np.inf
        for g in range(places.shape[0]):
            squared = 0.0
            for c in range(d):
                squared += (places[g, c] - points[m, c]) ** 2
            if squared < least:
                row, least = g, squared
        t = samples[row]
        low, high = samples[max(row - 1, 0)], samples[min(row + 1, len(samples) - 1)]
        for _ in range(most):
            at, span = into_knots(knots, degree, n, period, t)
            functions(knots, degree, span, at, f0, f1)
            second_derivatives(knots, degree, span, at, lower, f2)
            h[:] = 0.0
            for j in range(degree + 1):
                for c in range(width):
                    pole = poles[span - degree + j, c]
                    h[0, c] += f0[j] * pole
                    h[1, c] += f1[j] * pole
                    h[2, c] += f2[j] * pole
            slope = gauss = full = 0.0
            for c in range(d):
                place, first, second = h[0, c], h[1, c], h[2, c]
                if width > d:
                    place /= h[0, d]
                    first = (first - h[1, d] * place) / h[0, d]
                    second = (second - 2.0 * h[1, d] * first - h[2, d] * place) / h[0, d]
                slope += (place - points[m, c]) * first
                gauss += first * first
                full += (place - points[m, c]) * second
            curvature = gauss + full if gauss + full > 0.1 * gauss else max(gauss, 1e-300)
            new = min(max(t - slope / curvature, low), high)
            moved = abs(new - t)
            t = new
            if not moved > enough:
                break
        out[m] = t


@part
def surface_at(u_knots, v_knots, p, q, poles, periods, u, v, room, h):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Homogeneous point and derivatives by u and v of a surface, into `h` (3, 4); `room` (4, any degree + 1)."""
    t, i = into_knots(u_knots, p, poles.shape[0], periods[0], u)
    s, j = into_knots(v_knots, q, poles.shape[1], periods[1], v)
    in_u, by_u, in_v, by_v = room[0], room[1], room[2], room[3]
    functions(u_knots, p, i, t, in_u, by_u)
    functions(v_knots, q, j, s, in_v, by_v)
    h[:] = 0.0
    for c in range(4):
        for k in range(p + 1):
            row = slope = 0.0
            for n in range(q + 1):
                pole = poles[i - p + k, j - q + n, c]
                row += in_v[n] * pole
                slope += by_v[n] * pole
            h[0, c] += in_u[k] * row
            h[1, c] += by_u[k] * row
            h[2, c] += in_u[k] * slope


@kernel
def surface_derivatives(u_knots, v_knots, p, q, poles, periods, uv, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Points, or also derivatives by u and v, ``out`` (1 or 3, m, 3) of a surface; poles (n, n', 4) homogeneous."""
    room, h = np.empty((4, max(p, q) + 1)), np.empty((3, 4))
    for m in range(uv.shape[0]):
        surface_at(u_knots, v_knots, p, q, poles, periods, uv[m, 0], uv[m, 1], room, h)
        for c in range(3):
            out[0, m, c] = h[0, c] / h[0, 3]
            if out.shape[0] > 1:
                out[1, m, c] = (h[1, c] - h[1, 3] * out[0, m, c]) / h[0, 3]
                out[2, m, c] = (h[2, c] - h[2, 3] * out[0, m, c]) / h[0, 3]
