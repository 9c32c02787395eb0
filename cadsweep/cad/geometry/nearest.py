"""Nearest points on B-spline surfaces, as a compiled loop.

Place in the flow: ``face_surface`` calls :func:`nearest_on_spline` with start values from its grid. What is compiled is
:class:`cadsweep.cad.nurbs.BSplineSurface` for one point at a time: thousands of mesh nodes are held against their
faces on every run, and numpy takes ten times as long for it.

Method: Gauss-Newton from each start value, with steps that are halved until they come nearer, and that slide along the
limits where they would leave them.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from .nurbs import BSplineSurface
from .spline_kernels import kernel, surface_at

MOST_STEPS = 50
"""Descents need about ten steps; those that need fifty go in circles."""


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
    u_knots, v_knots, p, q, poles = spline.arrays
    uv = np.array(start, dtype=np.float64)
    distances = np.empty(len(points))
    _nearest(
        np.ascontiguousarray(points, dtype=np.float64),
        np.asarray(lower, dtype=np.float64),
        np.asarray(upper, dtype=np.float64),
        np.array([0.0 if period is None else period for period in periods]),
        p,
        q,
        u_knots,
        v_knots,
        poles,
        uv,
        distances,
    )
    return uv, distances


@kernel
def _nearest(points, lower, upper, periods, p, q, u_knots, v_knots, poles, uv, distances):  # type: ignore[no-untyped-def]  # noqa: PLR0912, PLR0917  # pragma: no cover
    room, h = np.empty((4, max(p, q) + 1)), np.empty((3, 4))
    place, a, b = np.empty(3), np.empty(3), np.empty(3)
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
                surface_at(u_knots, v_knots, p, q, poles, periods, new_u, new_v, room, h)
                new_squared = 0.0
                for c in range(3):
                    place[c] = h[0, c] / h[0, 3]
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
                a[c] = (h[1, c] - h[1, 3] * place[c]) / h[0, 3]
                b[c] = (h[2, c] - h[2, 3] * place[c]) / h[0, 3]
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
