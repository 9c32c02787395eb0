"""The distortion energy of hexahedra and its gradient: what smoothing minimises.

Place in the flow: :mod:`cadsweep.smoothing.patch` hands it to :mod:`cadsweep.smoothing.descent`. Every
corner of a hexahedron has a Jacobian of its edges, each edge divided by the length that it
should have, so that graded layers count as undistorted.

``shape`` (untangles)
    ``|A|^2 / (3 chi^(2/3)) + weight (1 + D^2) / (2 chi)`` with ``D = det A`` and
    ``chi = (D + sqrt(eps^2 + D^2)) / 2``: finite for inverted corners, and growing without bound
    there as eps goes to 0. The second term keeps volumes from drifting.
``angle`` (polishes)
    ``(1 / scaled Jacobian)^p``, plus a little of ``shape``: with a large p the worst corner
    dominates. Infinite where a corner is not positive, so a valid mesh stays valid. Angles say nothing of lengths, and
    the little of ``shape`` is nothing beside a high power: a node would be pushed along an edge of the part until it
    ends upon the next one, where that opens a poor corner. An edge far shorter than it should be therefore counts as a
    poor corner itself.

References
----------
Garanzha, Kaporin, Kudryavtseva, Protais, Ray, Sokolov, "Foldover-free maps in 50 lines of code",
ACM Trans. Graph. 40 (2021).
"""

from __future__ import annotations

import numpy as np

from ..compiled import compiled
from ..quality import HEX_CORNERS

_compiled = compiled(cache=True, error_model="numpy", nogil=True)

CORNERS = np.array(HEX_CORNERS)

DIRECTIONS = np.array([[0, 1, 2], [1, 0, 2], [0, 1, 2], [1, 0, 2], [1, 0, 2], [0, 1, 2], [1, 0, 2], [0, 1, 2]])
"""Direction (xi, eta, zeta) of each of those edges."""

SHORT = 0.01
"""Share of its wanted length below which polishing counts an edge as a poor corner.

Hardly an edge is meant to be so short, and its nodes are still told from nodes upon each other.
"""


@_compiled
def _shortness(squared):  # type: ignore[no-untyped-def]  # pragma: no cover
    """By what an edge multiplies the angle's energy, 1 from `SHORT` on, and the slope of the logarithm of that."""
    ratio = SHORT * SHORT / squared
    if ratio <= 1.0:
        return 1.0, 0.0
    over = ratio - 1.0
    factor = 1.0 + over * over
    return factor, -2.0 * over * ratio / (squared * factor)


@_compiled
def hex_energy(x, hexes, free, inverse_lengths, gradient, eps, volume_weight, power, shape_weight):  # type: ignore[no-untyped-def]  # noqa: PLR0915, PLR0917
    """Sum the energy over the corners of hexes (m, 8) that have a free node, add its gradient to `gradient` (n, 3).

    ``inverse_lengths`` (m, 3): one over the wanted edge length along xi, eta, zeta. ``power``: a power of two; 0: the
    energy ``shape`` alone. Returns the energy and the least determinant of the scaled edges.
    """
    total, least = 0.0, np.inf
    for h in range(hexes.shape[0]):
        for c in range(8):
            o, p, q, r = (
                hexes[h, CORNERS[c, 0]],
                hexes[h, CORNERS[c, 1]],
                hexes[h, CORNERS[c, 2]],
                hexes[h, CORNERS[c, 3]],
            )
            if not (free[o] or free[p] or free[q] or free[r]):
                continue
            su, sv, sw = (
                inverse_lengths[h, DIRECTIONS[c, 0]],
                inverse_lengths[h, DIRECTIONS[c, 1]],
                inverse_lengths[h, DIRECTIONS[c, 2]],
            )
            u0, u1, u2 = (x[p, 0] - x[o, 0]) * su, (x[p, 1] - x[o, 1]) * su, (x[p, 2] - x[o, 2]) * su
            v0, v1, v2 = (x[q, 0] - x[o, 0]) * sv, (x[q, 1] - x[o, 1]) * sv, (x[q, 2] - x[o, 2]) * sv
            w0, w1, w2 = (x[r, 0] - x[o, 0]) * sw, (x[r, 1] - x[o, 1]) * sw, (x[r, 2] - x[o, 2]) * sw
            a0, a1, a2 = v1 * w2 - v2 * w1, v2 * w0 - v0 * w2, v0 * w1 - v1 * w0
            b0, b1, b2 = w1 * u2 - w2 * u1, w2 * u0 - w0 * u2, w0 * u1 - w1 * u0
            c0, c1, c2 = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
            det = u0 * a0 + u1 * a1 + u2 * a2
            least = min(least, det)
            uu, vv, ww = u0 * u0 + u1 * u1 + u2 * u2, v0 * v0 + v1 * v1 + v2 * v2, w0 * w0 + w1 * w1 + w2 * w2
            root = np.sqrt(eps * eps + det * det)
            # For negative determinants the sum cancels; the product form does not.
            chi = 0.5 * (det + root) if det > 0.0 else 0.5 * eps * eps / (root - det)
            if not chi > 0.0:
                return np.inf, least
            slope = chi / root
            root_chi = np.cbrt(chi)
            scale = 1.0 / (root_chi * root_chi)
            norm = uu + vv + ww
            energy = norm * scale / 3.0 + volume_weight * (1.0 + det * det) / (2.0 * chi)
            # d energy = along * A + across * cofactor(A)
            along = 2.0 * scale / 3.0
            across = -(2.0 / 9.0) * norm * scale / chi * slope
            across += volume_weight * (det / chi - (1.0 + det * det) * slope / (2.0 * chi * chi))
            ku = kv = kw = along * shape_weight
            across *= shape_weight
            energy *= shape_weight
            if power > 0.0:
                if not det > 0.0:
                    return np.inf, least
                # The worst corner of 1/scaled Jacobian to a high power; 1 for a right-angled corner.
                # The powers are twice those of two: a few products, where a call of pow is half of all time.
                angle = uu * vv * ww / (det * det)
                short_u, slope_u = _shortness(uu)
                short_v, slope_v = _shortness(vv)
                short_w, slope_w = _shortness(ww)
                angle *= short_u * short_v * short_w
                exponent = 0.5 * power
                while exponent > 1.5:
                    angle *= angle
                    exponent *= 0.5
                energy += angle
                ku += power * angle * (1.0 / uu + slope_u)
                kv += power * angle * (1.0 / vv + slope_v)
                kw += power * angle * (1.0 / ww + slope_w)
                across -= power * angle / det
            total += energy
            g0, g1, g2 = su * (ku * u0 + across * a0), su * (ku * u1 + across * a1), su * (ku * u2 + across * a2)
            h0, h1, h2 = sv * (kv * v0 + across * b0), sv * (kv * v1 + across * b1), sv * (kv * v2 + across * b2)
            i0, i1, i2 = sw * (kw * w0 + across * c0), sw * (kw * w1 + across * c1), sw * (kw * w2 + across * c2)
            gradient[p, 0] += g0
            gradient[p, 1] += g1
            gradient[p, 2] += g2
            gradient[q, 0] += h0
            gradient[q, 1] += h1
            gradient[q, 2] += h2
            gradient[r, 0] += i0
            gradient[r, 1] += i1
            gradient[r, 2] += i2
            gradient[o, 0] -= g0 + h0 + i0
            gradient[o, 1] -= g1 + h1 + i1
            gradient[o, 2] -= g2 + h2 + i2
    return total, least
