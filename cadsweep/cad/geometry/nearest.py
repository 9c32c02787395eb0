"""Nearest points on B-spline surfaces, as a compiled loop.

Place in the flow: ``face_surface`` calls :func:`nearest_on_spline` with start values from its grid. What is compiled is
:class:`cadsweep.cad.nurbs.BSplineSurface` for one point at a time: thousands of mesh nodes are held against their
faces on every run, and numpy takes ten times as long for it.

Method: Gauss-Newton from each start value, with steps that are halved until they come nearer, and that slide along the
limits where they would leave them.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ...arrays import FloatArray
from .nurbs import BSplineSurface

MOST_STEPS = 50
MANY = 2_000
"""Points from which the loop pays for being compiled or loaded."""

_njit = njit(cache=True, nogil=True, error_model="numpy")
_part = njit(nogil=True, error_model="numpy", inline="always")


def nearest_on_spline(
    spline: BSplineSurface,
    points: FloatArray,
    start: FloatArray,
    *,
    lower: FloatArray,
    upper: FloatArray,
    periods: tuple[float | None, float | None] = (None, None),
) -> tuple[FloatArray, FloatArray]:
    """Find the points of a B-spline surface that are nearest to given ones, near start values.

    Parameters
    ----------
    spline : BSplineSurface
    points : (m, 3) float64
    start : (m, 2) float64
        Parameters to begin with.
    lower, upper : (2,) float64
        Parameters beyond which none is looked for.
    periods : (float or None, float or None)
        Where the surface goes on beyond its knots.

    Returns
    -------
    (m, 2) float64, (m,) float64
        Parameters, and the distances from the points of the surface there.
    """
    weights = np.ones(spline.poles.shape[:2]) if spline.weights is None else spline.weights
    poles = np.concatenate([spline.poles * weights[..., None], weights[..., None]], axis=2)
    uv = np.array(start, dtype=np.float64)
    distances = np.empty(len(points))
    _nearest(
        np.ascontiguousarray(points, dtype=np.float64),
        np.asarray(lower, dtype=np.float64),
        np.asarray(upper, dtype=np.float64),
        np.array([0.0 if period is None else period for period in periods]),
        spline.degrees[0],
        spline.degrees[1],
        np.ascontiguousarray(spline.u_knots, dtype=np.float64),
        np.ascontiguousarray(spline.v_knots, dtype=np.float64),
        np.ascontiguousarray(poles),
        uv,
        distances,
    )
    return uv, distances


@_part
def _into_knots(knots, degree, n_poles, period, t):  # type: ignore[no-untyped-def]  # pragma: no cover
    """The parameter brought into the knots of a periodic surface, and its span."""
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
    while low > degree and knots[low] == knots[low + 1]:  # the end belongs to the last span that is not empty
        low -= 1
    while knots[low] == knots[low + 1]:
        low += 1
    return t, low


@_part
def _basis(knots, degree, span, t, values, slopes):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """The non-zero basis functions and their derivatives (Cox-de Boor, as in :func:`cadsweep.cad.nurbs.basis`)."""
    values[0] = 1.0
    slopes[0] = 0.0
    for p in range(1, degree + 1):
        if p == degree:
            for j in range(degree + 1):
                slopes[j] = 0.0
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


@_njit
def _nearest(points, lower, upper, periods, p, q, u_knots, v_knots, poles, uv, distances):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0915, PLR0917  # pragma: no cover
    n_u, n_v = poles.shape[0], poles.shape[1]
    in_u, by_u, in_v, by_v = np.empty(p + 1), np.empty(p + 1), np.empty(q + 1), np.empty(q + 1)
    place, a, b, row, slope, h, hu, hv = (
        np.empty(3),
        np.empty(3),
        np.empty(3),
        np.empty(4),
        np.empty(4),
        np.empty(4),
        np.empty(4),
        np.empty(4),
    )
    width_u, width_v = upper[0] - lower[0], upper[1] - lower[1]
    enough = 1e-13 * max(width_u, width_v)
    for m in range(points.shape[0]):
        u, v = uv[m, 0], uv[m, 1]
        new_u, new_v = u, v
        squared = np.inf
        e = f = aa = ab = bb = 0.0
        moved = np.inf
        for step in range(MOST_STEPS):
            found = False
            for _ in range(10):
                t, i = _into_knots(u_knots, p, n_u, periods[0], new_u)
                s, j = _into_knots(v_knots, q, n_v, periods[1], new_v)
                _basis(u_knots, p, i, t, in_u, by_u)
                _basis(v_knots, q, j, s, in_v, by_v)
                h[:] = 0.0
                hu[:] = 0.0
                hv[:] = 0.0
                for k in range(p + 1):
                    row[:] = 0.0
                    slope[:] = 0.0
                    for n in range(q + 1):
                        for c in range(4):
                            pole = poles[i - p + k, j - q + n, c]
                            row[c] += in_v[n] * pole
                            slope[c] += by_v[n] * pole
                    for c in range(4):
                        h[c] += in_u[k] * row[c]
                        hu[c] += by_u[k] * row[c]
                        hv[c] += in_u[k] * slope[c]
                new_squared = 0.0
                for c in range(3):
                    place[c] = h[c] / h[3]
                    new_squared += (points[m, c] - place[c]) ** 2
                if new_squared <= squared * (1.0 + 1e-14):
                    found = True
                    break
                new_u, new_v = 0.5 * (new_u + u), 0.5 * (new_v + v)
            if not found:
                break
            moved = max(abs(new_u - u), abs(new_v - v))
            u, v, squared = new_u, new_v, new_squared
            if step > 0 and moved <= enough:
                break
            aa = ab = bb = e = f = 0.0
            for c in range(3):
                a[c], b[c] = (hu[c] - hu[3] * place[c]) / h[3], (hv[c] - hv[3] * place[c]) / h[3]
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
