"""Compiled loops over hexahedra and quads: Verdict's metrics and the Bernstein bound of the Jacobian.

Place in the flow: the inner loops of :mod:`cadsweep.quality.metrics` and
:mod:`cadsweep.quality.checks`; nothing else calls them. Each has a plain numpy statement of what it
computes in ``tests/quality/plain.py``, which the tests hold it to.

Method. With ``x(xi, eta, zeta)`` trilinear on the unit cube, the column ``dx/dxi`` is bilinear in
(eta, zeta) and its Bernstein coefficients are the four edges along xi; likewise for the others. The
Jacobian determinant has degree (2, 2, 2), so its 27 Bernstein coefficients are weighted sums of the
64 triple products of one edge of each direction. They bound it from below everywhere inside, eight
of them are its values at the corners, and their mean is its integral, the volume.

Thirty-two hexahedra are worked on together, which the nearest cache holds, the innermost loop running
over them, so that the compiler can use vector instructions. The kernels release the interpreter's lock,
and read indices without checking them: callers check first.

References
----------
Verdict library reference manual (SAND2007-1751); Johnen, Weill, Remacle, "Robust and efficient
validation of the linear hexahedral element" (2017).
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled

METRICS = ("scaled_jacobian", "aspect", "skew", "taper", "condition", "warpage", "volume", "bound")
"""Columns that :func:`measure_hexes` fills."""

ZERO = 4e-15
"""A determinant below `ZERO` times the product of the longest edges counts as not positive (rounding)."""

_LANES = 32
"""Hexahedra that are worked on together."""

_compiled = compiled(cache=True, error_model="numpy", nogil=True)
_part = compiled(error_model="numpy", nogil=True, inline="always")
"""Pieces of the loops below: compiled inside them alone, which takes a quarter less time on the first run."""


@_part
def _gather_edges(points, hexes, first, n, edges):  # type: ignore[no-untyped-def]
    """Fill edges[e, c, lane]: four along xi (at eta + 2 zeta), four along eta (xi + 2 zeta), four along zeta."""
    for lane in range(n):
        h = first + lane
        for c in range(3):
            p0 = points[hexes[h, 0], c]
            p1 = points[hexes[h, 1], c]
            p2 = points[hexes[h, 2], c]
            p3 = points[hexes[h, 3], c]
            p4 = points[hexes[h, 4], c]
            p5 = points[hexes[h, 5], c]
            p6 = points[hexes[h, 6], c]
            p7 = points[hexes[h, 7], c]
            edges[0, c, lane] = p1 - p0
            edges[1, c, lane] = p2 - p3
            edges[2, c, lane] = p5 - p4
            edges[3, c, lane] = p6 - p7
            edges[4, c, lane] = p3 - p0
            edges[5, c, lane] = p2 - p1
            edges[6, c, lane] = p7 - p4
            edges[7, c, lane] = p6 - p5
            edges[8, c, lane] = p4 - p0
            edges[9, c, lane] = p5 - p1
            edges[10, c, lane] = p7 - p3
            edges[11, c, lane] = p6 - p2


@_part
def _expand_jacobian(edges, n, normals, bernstein):  # type: ignore[no-untyped-def]
    """Fill the 27 Bernstein coefficients bernstein[i + 3 j + 9 k, lane] of the Jacobian.

    The product of two linear Bernstein polynomials is one of degree 2; both mixed products are the
    middle one with weight 1/2, hence the division of sums by their number of terms.
    """
    for m in range(12):
        for q in range(n):
            normals[m, 0, q] = normals[m, 1, q] = normals[m, 2, q] = 0.0
    for t in range(27):
        for q in range(n):
            bernstein[t, q] = 0.0
    for a in range(4):
        for b in range(4):
            # u x v: degree 1 in xi (from v) and in eta (from u), degree 2 in zeta.
            m = (b & 1) + 2 * (a & 1) + 4 * ((a >> 1) + (b >> 1))
            for q in range(n):
                u0, u1, u2 = edges[a, 0, q], edges[a, 1, q], edges[a, 2, q]
                v0, v1, v2 = edges[4 + b, 0, q], edges[4 + b, 1, q], edges[4 + b, 2, q]
                normals[m, 0, q] += u1 * v2 - u2 * v1
                normals[m, 1, q] += u2 * v0 - u0 * v2
                normals[m, 2, q] += u0 * v1 - u1 * v0
    for m in range(12):
        for w in range(4):
            i = (m & 1) + (w & 1)
            j = ((m >> 1) & 1) + (w >> 1)
            k = m >> 2
            t = i + 3 * j + 9 * k
            share = 1.0 / ((1 + (i & 1)) * (1 + (j & 1)) * (1 + (k & 1)))
            for q in range(n):
                bernstein[t, q] += share * (
                    normals[m, 0, q] * edges[8 + w, 0, q]
                    + normals[m, 1, q] * edges[8 + w, 1, q]
                    + normals[m, 2, q] * edges[8 + w, 2, q]
                )


@_part
def _square_lengths(edges, n, squares):  # type: ignore[no-untyped-def]
    for e in range(12):
        for q in range(n):
            squares[e, q] = edges[e, 0, q] ** 2 + edges[e, 1, q] ** 2 + edges[e, 2, q] ** 2


@_part
def _least_corner_and_condition(edges, squares, bernstein, n, scale, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Fill out[0] and out[4] from the eight corners."""
    for q in range(n):
        out[0, q] = np.inf
        out[4, q] = 0.0
    for corner in range(8):
        i, j, k = corner & 1, (corner >> 1) & 1, corner >> 2
        a, b, c = j + 2 * k, 4 + i + 2 * k, 8 + i + 2 * j
        t = 2 * i + 6 * j + 18 * k
        for q in range(n):
            det = bernstein[t, q]
            uu, vv, ww = squares[a, q], squares[b, q], squares[c, q]
            product = uu * vv * ww
            value = det / np.sqrt(product) if product > 0.0 else 0.0
            out[0, q] = value if not value >= out[0, q] else out[0, q]
            uv = edges[a, 0, q] * edges[b, 0, q] + edges[a, 1, q] * edges[b, 1, q] + edges[a, 2, q] * edges[b, 2, q]
            vw = edges[b, 0, q] * edges[c, 0, q] + edges[b, 1, q] * edges[c, 1, q] + edges[b, 2, q] * edges[c, 2, q]
            wu = edges[c, 0, q] * edges[a, 0, q] + edges[c, 1, q] * edges[a, 1, q] + edges[c, 2, q] * edges[a, 2, q]
            areas = (uu * vv - uv * uv) + (vv * ww - vw * vw) + (ww * uu - wu * wu)
            number = np.sqrt((uu + vv + ww) * areas) / (3.0 * det) if det > ZERO * scale[q] else np.inf
            out[4, q] = number if number > out[4, q] else out[4, q]


@_part
def _measure_frame(edges, n, out):  # type: ignore[no-untyped-def]
    """Fill out[1:4] (aspect, skew, taper) from the principal axes; lower out[0] to the value at the centre."""
    for q in range(n):
        x0 = edges[0, 0, q] + edges[1, 0, q] + edges[2, 0, q] + edges[3, 0, q]
        x1 = edges[0, 1, q] + edges[1, 1, q] + edges[2, 1, q] + edges[3, 1, q]
        x2 = edges[0, 2, q] + edges[1, 2, q] + edges[2, 2, q] + edges[3, 2, q]
        y0 = edges[4, 0, q] + edges[5, 0, q] + edges[6, 0, q] + edges[7, 0, q]
        y1 = edges[4, 1, q] + edges[5, 1, q] + edges[6, 1, q] + edges[7, 1, q]
        y2 = edges[4, 2, q] + edges[5, 2, q] + edges[6, 2, q] + edges[7, 2, q]
        z0 = edges[8, 0, q] + edges[9, 0, q] + edges[10, 0, q] + edges[11, 0, q]
        z1 = edges[8, 1, q] + edges[9, 1, q] + edges[10, 1, q] + edges[11, 1, q]
        z2 = edges[8, 2, q] + edges[9, 2, q] + edges[10, 2, q] + edges[11, 2, q]
        xx = np.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
        yy = np.sqrt(y0 * y0 + y1 * y1 + y2 * y2)
        zz = np.sqrt(z0 * z0 + z1 * z1 + z2 * z2)
        det = x0 * (y1 * z2 - y2 * z1) + x1 * (y2 * z0 - y0 * z2) + x2 * (y0 * z1 - y1 * z0)
        least = min(xx, yy, zz)
        good = least > 0.0
        centre = det / (xx * yy * zz) if good else 0.0
        out[0, q] = centre if not centre >= out[0, q] else out[0, q]
        out[1, q] = max(xx, yy, zz) / least if good else np.inf
        xy = abs(x0 * y0 + x1 * y1 + x2 * y2) / (xx * yy)
        xz = abs(x0 * z0 + x1 * z1 + x2 * z2) / (xx * zz)
        yz = abs(y0 * z0 + y1 * z1 + y2 * z2) / (yy * zz)
        out[2, q] = max(xy, xz, yz) if good else 1.0
        cxy = cxz = cyz = 0.0
        for c in range(3):
            d = edges[0, c, q] - edges[1, c, q] + edges[2, c, q] - edges[3, c, q]
            cxy += d * d
            d = edges[0, c, q] + edges[1, c, q] - edges[2, c, q] - edges[3, c, q]
            cxz += d * d
            d = edges[4, c, q] + edges[5, c, q] - edges[6, c, q] - edges[7, c, q]
            cyz += d * d
        taper = max(np.sqrt(cxy) / min(xx, yy), np.sqrt(cxz) / min(xx, zz), np.sqrt(cyz) / min(yy, zz))
        out[3, q] = taper if good else np.inf


_FACES = np.array([(0, 1, 4, 5), (2, 3, 6, 7), (0, 2, 8, 9), (1, 3, 10, 11), (4, 6, 8, 10), (5, 7, 9, 11)])
"""Edges of the six faces: two one way, two the other; corners pair the first with the first or second."""


@_part
def _measure_warpage(edges, n, out):  # type: ignore[no-untyped-def]
    """Fill out[5]: over the faces, the least cube of the cosine between opposite corner normals."""
    for q in range(n):
        out[5, q] = 1.0
    for f in range(6):
        for pair in range(2):
            a, b = _FACES[f, 0], _FACES[f, 1]
            c, d = _FACES[f, 2 + pair], _FACES[f, 3 - pair]
            for q in range(n):
                x1 = edges[a, 1, q] * edges[c, 2, q] - edges[a, 2, q] * edges[c, 1, q]
                y1 = edges[a, 2, q] * edges[c, 0, q] - edges[a, 0, q] * edges[c, 2, q]
                z1 = edges[a, 0, q] * edges[c, 1, q] - edges[a, 1, q] * edges[c, 0, q]
                x2 = edges[b, 1, q] * edges[d, 2, q] - edges[b, 2, q] * edges[d, 1, q]
                y2 = edges[b, 2, q] * edges[d, 0, q] - edges[b, 0, q] * edges[d, 2, q]
                z2 = edges[b, 0, q] * edges[d, 1, q] - edges[b, 1, q] * edges[d, 0, q]
                size = (x1 * x1 + y1 * y1 + z1 * z1) * (x2 * x2 + y2 * y2 + z2 * z2)
                cosine = (x1 * x2 + y1 * y2 + z1 * z2) / np.sqrt(size) if size > 0.0 else -1.0
                cube = cosine * cosine * cosine
                out[5, q] = cube if not cube >= out[5, q] else out[5, q]


@_part
def _mark_unmeasurable(squares, n, out):  # type: ignore[no-untyped-def]
    """Set out[0] to -1 where a coordinate is not finite: comparisons with nan lose it on the way."""
    for q in range(n):
        total = 0.0
        for e in range(12):
            total += squares[e, q]
        if not total < np.inf:
            out[0, q] = -1.0


@_part
def _close_lanes(bernstein, scale, squares, n, out):  # type: ignore[no-untyped-def]
    """Fill out[6:8] (volume, bound)."""
    for q in range(n):
        total = 0.0
        bound = np.inf
        for t in range(27):
            total += bernstein[t, q]
            bound = min(bound, bernstein[t, q])
        out[6, q] = total / 27.0
        usable = scale[q] > 0.0 and scale[q] < np.inf and np.isfinite(total)
        out[7, q] = bound / scale[q] if usable else -1.0
    _mark_unmeasurable(squares, n, out)


@_compiled
def measure_hexes(points, hexes, out):  # type: ignore[no-untyped-def]
    """Fill `out` (8, m) with the rows `METRICS` for hexes (m, 8 or more) of `points` (n, 3).

    The last row is the least Bernstein coefficient over the product of the longest edges of each
    direction: above `ZERO`, the Jacobian is positive everywhere inside.
    """
    m = hexes.shape[0]
    edges = np.empty((12, 3, _LANES))
    normals = np.empty((12, 3, _LANES))
    bernstein = np.empty((27, _LANES))
    squares = np.empty((12, _LANES))
    scale = np.empty(_LANES)
    lanes = np.empty((8, _LANES))
    for first in range(0, m, _LANES):
        n = min(_LANES, m - first)
        _gather_edges(points, hexes, first, n, edges)
        _expand_jacobian(edges, n, normals, bernstein)
        _square_lengths(edges, n, squares)
        for q in range(n):
            u = max(squares[0, q], squares[1, q], squares[2, q], squares[3, q])
            v = max(squares[4, q], squares[5, q], squares[6, q], squares[7, q])
            w = max(squares[8, q], squares[9, q], squares[10, q], squares[11, q])
            scale[q] = np.sqrt(u * v * w)
        _least_corner_and_condition(edges, squares, bernstein, n, scale, lanes)
        _measure_frame(edges, n, lanes)
        _measure_warpage(edges, n, lanes)
        _close_lanes(bernstein, scale, squares, n, lanes)
        for r in range(8):
            for q in range(n):
                out[r, first + q] = lanes[r, q]


@_compiled
def scaled_jacobians_of_hexes(points, hexes, out):  # type: ignore[no-untyped-def]
    """Fill `out` (m,) with the least scaled Jacobian over the eight corners and the centre."""
    m = hexes.shape[0]
    edges = np.empty((12, 3, _LANES))
    squares = np.empty((12, _LANES))
    lanes = np.empty((4, _LANES))
    for first in range(0, m, _LANES):
        n = min(_LANES, m - first)
        _gather_edges(points, hexes, first, n, edges)
        _square_lengths(edges, n, squares)
        for q in range(n):
            lanes[0, q] = np.inf
        for corner in range(8):
            i, j, k = corner & 1, (corner >> 1) & 1, corner >> 2
            a, b, c = j + 2 * k, 4 + i + 2 * k, 8 + i + 2 * j
            for q in range(n):
                x = edges[a, 1, q] * edges[b, 2, q] - edges[a, 2, q] * edges[b, 1, q]
                y = edges[a, 2, q] * edges[b, 0, q] - edges[a, 0, q] * edges[b, 2, q]
                z = edges[a, 0, q] * edges[b, 1, q] - edges[a, 1, q] * edges[b, 0, q]
                det = x * edges[c, 0, q] + y * edges[c, 1, q] + z * edges[c, 2, q]
                product = squares[a, q] * squares[b, q] * squares[c, q]
                value = det / np.sqrt(product) if product > 0.0 else 0.0
                lanes[0, q] = value if not value >= lanes[0, q] else lanes[0, q]
        _measure_frame(edges, n, lanes)
        _mark_unmeasurable(squares, n, lanes)
        for q in range(n):
            out[first + q] = lanes[0, q]
