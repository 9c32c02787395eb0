"""Shape energy of hexahedron corners, and the scaled Jacobian, as compiled loops.

Place in the flow: the arithmetic under :mod:`.corrections`.

Method. At a corner of a hexahedron the three edges, each over its ideal length, are the columns of J. The energy
``((tr(J^T J) / 3)^(3/2) + w (1 + det^2) / 2) / chi(det)`` is least for a box of the ideal lengths; chi is that of
:mod:`.relax`. With a weight on the angles the product of the edges' lengths takes that share of the first term: over
det it is the inverse of the scaled Jacobian.
"""

from __future__ import annotations

import numpy as np
from numba import njit

CORNERS = np.array(
    [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]], dtype=np.int64
)
"""The neighbours of each corner, in an order in which their triple product is positive."""
DIRECTIONS = np.array(
    [[0, 1, 2], [1, 0, 2], [0, 1, 2], [1, 0, 2], [1, 0, 2], [0, 1, 2], [1, 0, 2], [0, 1, 2]], dtype=np.int64
)
"""Which of the hexahedron's three directions each of those edges runs along."""


@njit(cache=True, nogil=True, error_model="numpy")
def layer_scaled_jacobians(lower, upper, quads, lower_fixed, upper_fixed, out):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Least corner value (q,) of the hexahedra between two layers (n, 3).

    Corners between four fixed nodes, by the masks (n,), do not count.
    """
    for q in range(quads.shape[0]):
        least = np.inf
        for corner in range(8):
            here, there = (lower, upper) if corner < 4 else (upper, lower)
            here_fixed, there_fixed = (lower_fixed, upper_fixed) if corner < 4 else (upper_fixed, lower_fixed)
            c = corner % 4
            i, j, k = quads[q, c], quads[q, (c + 1) % 4], quads[q, (c + 3) % 4]
            if here_fixed[i] and here_fixed[j] and here_fixed[k] and there_fixed[i]:
                continue
            a0, a1, a2 = here[j, 0] - here[i, 0], here[j, 1] - here[i, 1], here[j, 2] - here[i, 2]
            b0, b1, b2 = here[k, 0] - here[i, 0], here[k, 1] - here[i, 1], here[k, 2] - here[i, 2]
            c0, c1, c2 = there[i, 0] - here[i, 0], there[i, 1] - here[i, 1], there[i, 2] - here[i, 2]
            det = (a1 * b2 - a2 * b1) * c0 + (a2 * b0 - a0 * b2) * c1 + (a0 * b1 - a1 * b0) * c2
            if corner >= 4:
                det = -det
            squares = (a0 * a0 + a1 * a1 + a2 * a2) * (b0 * b0 + b1 * b1 + b2 * b2) * (c0 * c0 + c1 * c1 + c2 * c2)
            least = min(least, det / np.sqrt(squares)) if squares > 0.0 else -1.0
        out[q] = least


@njit(cache=True, nogil=True, error_model="numpy")
def worst_determinant(points, hexes, ideal):  # type: ignore[no-untyped-def]  # pragma: no cover
    """Least det J of all corners."""
    worst = np.inf
    for h in range(hexes.shape[0]):
        volume = ideal[h, 0] * ideal[h, 1] * ideal[h, 2]
        for corner in range(8):
            i = hexes[h, corner]
            j, k, m = hexes[h, CORNERS[corner, 0]], hexes[h, CORNERS[corner, 1]], hexes[h, CORNERS[corner, 2]]
            a0, a1, a2 = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
            b0, b1, b2 = points[k, 0] - points[i, 0], points[k, 1] - points[i, 1], points[k, 2] - points[i, 2]
            c0, c1, c2 = points[m, 0] - points[i, 0], points[m, 1] - points[i, 1], points[m, 2] - points[i, 2]
            det = (a1 * b2 - a2 * b1) * c0 + (a2 * b0 - a0 * b2) * c1 + (a0 * b1 - a1 * b0) * c2
            worst = min(worst, det / volume)
    return worst


@njit(cache=True, nogil=True, error_model="numpy")
def corner_energies(points, hexes, ideal, eps, size_weight, angles, squarings, gradient):  # type: ignore[no-untyped-def]  # noqa: PLR0917  # pragma: no cover
    """Sum of the ``2**squarings``-th powers of all corner energies; adds its gradient to `gradient`."""
    total, power = 0.0, 2.0**squarings
    for h in range(hexes.shape[0]):
        for corner in range(8):
            i = hexes[h, corner]
            j, k, m = hexes[h, CORNERS[corner, 0]], hexes[h, CORNERS[corner, 1]], hexes[h, CORNERS[corner, 2]]
            r = 1.0 / ideal[h, DIRECTIONS[corner, 0]]
            s = 1.0 / ideal[h, DIRECTIONS[corner, 1]]
            t = 1.0 / ideal[h, DIRECTIONS[corner, 2]]
            a0, a1, a2 = (
                r * (points[j, 0] - points[i, 0]),
                r * (points[j, 1] - points[i, 1]),
                r * (points[j, 2] - points[i, 2]),
            )
            b0, b1, b2 = (
                s * (points[k, 0] - points[i, 0]),
                s * (points[k, 1] - points[i, 1]),
                s * (points[k, 2] - points[i, 2]),
            )
            c0, c1, c2 = (
                t * (points[m, 0] - points[i, 0]),
                t * (points[m, 1] - points[i, 1]),
                t * (points[m, 2] - points[i, 2]),
            )
            # Cofactors: the derivatives of det by a, b and c.
            ca0, ca1, ca2 = b1 * c2 - b2 * c1, b2 * c0 - b0 * c2, b0 * c1 - b1 * c0
            cb0, cb1, cb2 = c1 * a2 - c2 * a1, c2 * a0 - c0 * a2, c0 * a1 - c1 * a0
            cc0, cc1, cc2 = a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
            det = a0 * ca0 + a1 * ca1 + a2 * ca2
            root = np.sqrt(eps * eps + det * det)
            if root == 0.0 or (eps == 0.0 and det <= 0.0):
                return np.inf
            chi = 0.5 * (det + root) if det > 0.0 else 0.5 * eps * eps / (root - det)
            aa, bb, cc = a0 * a0 + a1 * a1 + a2 * a2, b0 * b0 + b1 * b1 + b2 * b2, c0 * c0 + c1 * c1 + c2 * c2
            norm2 = (aa + bb + cc) / 3.0
            length = np.sqrt(norm2)
            product = np.sqrt(aa * bb * cc)
            shape = (1.0 - angles) * norm2 * length + angles * product
            top = shape + size_weight * 0.5 * (1.0 + det * det)
            f = top / chi
            powered = f
            for _ in range(squarings):
                powered *= powered
            total += powered
            outer = power * powered / f
            # d norm2^(3/2) / da = length a; d product / da = product / |a|^2 a.
            d_length = outer * (1.0 - angles) * length / chi
            d_product = outer * angles * product / chi
            d_a, d_b, d_c = d_length + d_product / aa, d_length + d_product / bb, d_length + d_product / cc
            d_det = outer * (size_weight * det / chi - top / (chi * root))
            ja0, ja1, ja2 = r * (d_a * a0 + d_det * ca0), r * (d_a * a1 + d_det * ca1), r * (d_a * a2 + d_det * ca2)
            jb0, jb1, jb2 = s * (d_b * b0 + d_det * cb0), s * (d_b * b1 + d_det * cb1), s * (d_b * b2 + d_det * cb2)
            jc0, jc1, jc2 = t * (d_c * c0 + d_det * cc0), t * (d_c * c1 + d_det * cc1), t * (d_c * c2 + d_det * cc2)
            gradient[j, 0] += ja0
            gradient[j, 1] += ja1
            gradient[j, 2] += ja2
            gradient[k, 0] += jb0
            gradient[k, 1] += jb1
            gradient[k, 2] += jb2
            gradient[m, 0] += jc0
            gradient[m, 1] += jc1
            gradient[m, 2] += jc2
            gradient[i, 0] -= ja0 + jb0 + jc0
            gradient[i, 1] -= ja1 + jb1 + jc1
            gradient[i, 2] -= ja2 + jb2 + jc2
    return total
