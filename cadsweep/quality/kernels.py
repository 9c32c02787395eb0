"""Compiled loops over hexahedra and quads: Verdict's metrics and the Bernstein bound of the Jacobian.

Place in the flow: the inner loops of :mod:`cadsweep.quality.metrics` and
:mod:`cadsweep.quality.checks`; nothing else calls them. Each has a plain numpy statement of what it
computes in ``tests/quality/plain.py``, which the tests hold it to.

Method. With ``x(xi, eta, zeta)`` trilinear on the unit cube, the column ``dx/dxi`` is bilinear in
(eta, zeta) and its Bernstein coefficients are the four edges along xi; likewise for the others. The
Jacobian determinant has degree (2, 2, 2), so its 27 Bernstein coefficients are weighted sums of the
64 triple products of one edge of each direction. They bound it from below everywhere inside, eight
of them are its values at the corners, and their mean is its integral, the volume.

The kernels read indices without checking them: callers check first (`checks.indices_are_usable`).

References
----------
Verdict library reference manual (SAND2007-1751); Johnen, Weill, Remacle, "Robust and efficient
validation of the linear hexahedral element" (2017).
"""

from __future__ import annotations

import numpy as np
from numba import njit, prange

METRICS = ("scaled_jacobian", "aspect", "skew", "taper", "condition", "warpage", "volume", "bound")
"""Columns that :func:`measure_hexes` fills."""

ZERO = 4e-15
"""A determinant below `ZERO` times the product of the longest edges counts as not positive (rounding)."""

_BLOCK = 1024


@njit(cache=True, inline="always")
def _det(a, i, b, j, c, k):  # type: ignore[no-untyped-def]
    return (
        a[i, 0] * (b[j, 1] * c[k, 2] - b[j, 2] * c[k, 1])
        + a[i, 1] * (b[j, 2] * c[k, 0] - b[j, 0] * c[k, 2])
        + a[i, 2] * (b[j, 0] * c[k, 1] - b[j, 1] * c[k, 0])
    )


@njit(cache=True, inline="always")
def _dot(a, i, b, j):  # type: ignore[no-untyped-def]
    return a[i, 0] * b[j, 0] + a[i, 1] * b[j, 1] + a[i, 2] * b[j, 2]


@njit(cache=True)
def _edges_of(points, hexes, h, u, v, w):  # type: ignore[no-untyped-def]
    """Edges of hex `h`: u[eta + 2 zeta] along xi, v[xi + 2 zeta] along eta, w[xi + 2 eta] along zeta."""
    for c in range(3):
        p0 = points[hexes[h, 0], c]
        p1 = points[hexes[h, 1], c]
        p2 = points[hexes[h, 2], c]
        p3 = points[hexes[h, 3], c]
        p4 = points[hexes[h, 4], c]
        p5 = points[hexes[h, 5], c]
        p6 = points[hexes[h, 6], c]
        p7 = points[hexes[h, 7], c]
        u[0, c] = p1 - p0
        u[1, c] = p2 - p3
        u[2, c] = p5 - p4
        u[3, c] = p6 - p7
        v[0, c] = p3 - p0
        v[1, c] = p2 - p1
        v[2, c] = p7 - p4
        v[3, c] = p6 - p5
        w[0, c] = p4 - p0
        w[1, c] = p5 - p1
        w[2, c] = p7 - p3
        w[3, c] = p6 - p2


@njit(cache=True)
def _bernstein_of(u, v, w, coefficients):  # type: ignore[no-untyped-def]
    """Fill the 27 Bernstein coefficients, index i + 3 j + 9 k, from the edges; return their sum."""
    for m in range(27):
        coefficients[m] = 0.0
    for a in range(4):
        j1 = a & 1
        k1 = a >> 1
        for b in range(4):
            i1 = b & 1
            k2 = b >> 1
            x = u[a, 1] * v[b, 2] - u[a, 2] * v[b, 1]
            y = u[a, 2] * v[b, 0] - u[a, 0] * v[b, 2]
            z = u[a, 0] * v[b, 1] - u[a, 1] * v[b, 0]
            base = i1 + 3 * j1 + 9 * (k1 + k2)
            for c in range(4):
                coefficients[base + (c & 1) + 3 * (c >> 1)] += x * w[c, 0] + y * w[c, 1] + z * w[c, 2]
    total = 0.0
    for k in range(3):
        for j in range(3):
            for i in range(3):
                # The product of two linear Bernstein polynomials meets the middle one of degree 2 with weight 1/2,
                # twice; dividing the sums of the two (four, eight) products gives the coefficient.
                half = (2.0 if i == 1 else 1.0) * (2.0 if j == 1 else 1.0) * (2.0 if k == 1 else 1.0)
                m = i + 3 * j + 9 * k
                coefficients[m] /= half
                total += coefficients[m]
    return total


@njit(cache=True)
def _frame_metrics(u, v, w, axes, cross):  # type: ignore[no-untyped-def]
    """Aspect, skew and taper from the principal axes and their cross derivatives."""
    for c in range(3):
        axes[0, c] = u[0, c] + u[1, c] + u[2, c] + u[3, c]
        axes[1, c] = v[0, c] + v[1, c] + v[2, c] + v[3, c]
        axes[2, c] = w[0, c] + w[1, c] + w[2, c] + w[3, c]
        cross[0, c] = u[0, c] - u[1, c] + u[2, c] - u[3, c]  # xi, eta
        cross[1, c] = u[0, c] + u[1, c] - u[2, c] - u[3, c]  # xi, zeta
        cross[2, c] = v[0, c] + v[1, c] - v[2, c] - v[3, c]  # eta, zeta
    l0 = np.sqrt(_dot(axes, 0, axes, 0))
    l1 = np.sqrt(_dot(axes, 1, axes, 1))
    l2 = np.sqrt(_dot(axes, 2, axes, 2))
    least = min(l0, l1, l2)
    if not least > 0.0:
        return np.inf, 1.0, np.inf
    skew = max(
        abs(_dot(axes, 0, axes, 1)) / (l0 * l1),
        abs(_dot(axes, 0, axes, 2)) / (l0 * l2),
        abs(_dot(axes, 1, axes, 2)) / (l1 * l2),
    )
    taper = max(
        np.sqrt(_dot(cross, 0, cross, 0)) / min(l0, l1),
        np.sqrt(_dot(cross, 1, cross, 1)) / min(l0, l2),
        np.sqrt(_dot(cross, 2, cross, 2)) / min(l1, l2),
    )
    return max(l0, l1, l2) / least, skew, taper


@njit(cache=True, inline="always")
def _corner_cosine(a, i, j, b, k, m):  # type: ignore[no-untyped-def]
    """Cosine between the normals a_i x b_k and a_j x b_m of a face's opposite corners."""
    x1 = a[i, 1] * b[k, 2] - a[i, 2] * b[k, 1]
    y1 = a[i, 2] * b[k, 0] - a[i, 0] * b[k, 2]
    z1 = a[i, 0] * b[k, 1] - a[i, 1] * b[k, 0]
    x2 = a[j, 1] * b[m, 2] - a[j, 2] * b[m, 1]
    y2 = a[j, 2] * b[m, 0] - a[j, 0] * b[m, 2]
    z2 = a[j, 0] * b[m, 1] - a[j, 1] * b[m, 0]
    n = np.sqrt((x1 * x1 + y1 * y1 + z1 * z1) * (x2 * x2 + y2 * y2 + z2 * z2))
    if not n > 0.0:
        return -1.0
    return (x1 * x2 + y1 * y2 + z1 * z2) / n


@njit(cache=True)
def _face_warpage(a, i, j, b, k, m):  # type: ignore[no-untyped-def]
    """Warpage of the face with edges a_i, a_j one way and b_k, b_m the other way."""
    # Corners (0,0) and (1,1) have the edges (a_i, b_k), (a_j, b_m); the other two (a_i, b_m), (a_j, b_k).
    c = min(_corner_cosine(a, i, j, b, k, m), _corner_cosine(a, i, j, b, m, k))
    return c * c * c


@njit(cache=True, parallel=True)
def measure_hexes(points, hexes, out):  # type: ignore[no-untyped-def]
    """Fill `out` (m, 8) with the columns `METRICS` for hexes (m, 8+) of `points` (n, 3).

    The last column is the least Bernstein coefficient over the product of the longest edges of each
    direction: above `ZERO`, the Jacobian is positive everywhere inside.
    """
    n = hexes.shape[0]
    for block in prange((n + _BLOCK - 1) // _BLOCK):
        u = np.empty((4, 3))
        v = np.empty((4, 3))
        w = np.empty((4, 3))
        axes = np.empty((3, 3))
        cross = np.empty((3, 3))
        coefficients = np.empty(27)
        lu = np.empty(4)
        lv = np.empty(4)
        lw = np.empty(4)
        for h in range(block * _BLOCK, min(n, (block + 1) * _BLOCK)):
            _edges_of(points, hexes, h, u, v, w)
            total = _bernstein_of(u, v, w, coefficients)
            for i in range(4):
                lu[i] = _dot(u, i, u, i)
                lv[i] = _dot(v, i, v, i)
                lw[i] = _dot(w, i, w, i)
            scale = np.sqrt(lu.max() * lv.max() * lw.max())
            aspect, skew, taper = _frame_metrics(u, v, w, axes, cross)
            least = np.inf
            condition = 0.0
            for k in range(2):
                for j in range(2):
                    for i in range(2):
                        a = j + 2 * k
                        b = i + 2 * k
                        c = i + 2 * j
                        det = coefficients[2 * i + 6 * j + 18 * k]
                        length = np.sqrt(lu[a] * lv[b] * lw[c])
                        value = det / length if length > 0.0 else 0.0
                        least = min(least, value)
                        if det > ZERO * scale:
                            d1 = _dot(u, a, v, b)
                            d2 = _dot(v, b, w, c)
                            d3 = _dot(w, c, u, a)
                            area = lu[a] * lv[b] - d1 * d1 + lv[b] * lw[c] - d2 * d2 + lw[c] * lu[a] - d3 * d3
                            condition = max(condition, np.sqrt((lu[a] + lv[b] + lw[c]) * area) / (3.0 * det))
                        else:
                            condition = np.inf
            lengths = np.sqrt(_dot(axes, 0, axes, 0) * _dot(axes, 1, axes, 1) * _dot(axes, 2, axes, 2))
            centre = _det(axes, 0, axes, 1, axes, 2) / lengths if lengths > 0.0 else 0.0
            least = min(least, centre)
            if not (least >= -1.0 and least <= 1.0 + 1e-9):  # not finite coordinates, or overflow
                least = -1.0
            out[h, 0] = least
            out[h, 1] = aspect
            out[h, 2] = skew
            out[h, 3] = taper
            out[h, 4] = condition
            out[h, 5] = min(
                _face_warpage(u, 0, 1, v, 0, 1),
                _face_warpage(u, 2, 3, v, 2, 3),
                _face_warpage(u, 0, 2, w, 0, 1),
                _face_warpage(u, 1, 3, w, 2, 3),
                _face_warpage(v, 0, 2, w, 0, 2),
                _face_warpage(v, 1, 3, w, 1, 3),
            )
            out[h, 6] = total / 27.0
            bound = coefficients.min()
            out[h, 7] = bound / scale if scale > 0.0 and scale < np.inf else -1.0


@njit(cache=True, parallel=True)
def scaled_jacobians_of_hexes(points, hexes, out):  # type: ignore[no-untyped-def]
    """Fill `out` (m,) with the least scaled Jacobian over the eight corners and the centre."""
    n = hexes.shape[0]
    for block in prange((n + _BLOCK - 1) // _BLOCK):
        u = np.empty((4, 3))
        v = np.empty((4, 3))
        w = np.empty((4, 3))
        axes = np.empty((3, 3))
        for h in range(block * _BLOCK, min(n, (block + 1) * _BLOCK)):
            _edges_of(points, hexes, h, u, v, w)
            for c in range(3):
                axes[0, c] = u[0, c] + u[1, c] + u[2, c] + u[3, c]
                axes[1, c] = v[0, c] + v[1, c] + v[2, c] + v[3, c]
                axes[2, c] = w[0, c] + w[1, c] + w[2, c] + w[3, c]
            length = np.sqrt(_dot(axes, 0, axes, 0) * _dot(axes, 1, axes, 1) * _dot(axes, 2, axes, 2))
            least = _det(axes, 0, axes, 1, axes, 2) / length if length > 0.0 else 0.0
            for k in range(2):
                for j in range(2):
                    for i in range(2):
                        a = j + 2 * k
                        b = i + 2 * k
                        c = i + 2 * j
                        length = np.sqrt(_dot(u, a, u, a) * _dot(v, b, v, b) * _dot(w, c, w, c))
                        value = _det(u, a, v, b, w, c) / length if length > 0.0 else 0.0
                        least = min(least, value)
            if not (least >= -1.0 and least <= 1.0 + 1e-9):
                least = -1.0
            out[h] = least
