"""Is the Jacobian of a hexahedron positive everywhere inside? Bernstein bounds, subdivided until decided.

Place in the flow: :mod:`cadsweep.quality.accumulate` sends the hexahedra here whose first bound did
not decide (some per ten thousand), and every hex20 and hex27.

Method. The Jacobian determinant is a polynomial: of degree (2, 2, 2) for hex8, (5, 5, 5) for hex27,
and hex20 is a hex27 whose inner nodes follow from the others. Its Bernstein coefficients are formed
by products of those of the three columns, without evaluation points. Coefficients that are all
positive prove the polynomial positive; a corner coefficient is a value, and disproves it. What is
neither is cut into eight by de Casteljau's rule and asked again, up to `MAX_BOXES` boxes. What is
still open then has a least value within rounding of zero and counts as *not* positive: no
hexahedron is called valid without proof.

References
----------
Johnen, Remacle, Geuzaine, "Geometrical validity of curvilinear finite elements", J. Comput. Phys. 233 (2013).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from ..topology import FloatArray, IntArray
from .kernels import ZERO

MAX_BOXES = 20_000
"""Boxes that are looked at for one hexahedron before it counts as not positive."""

MAX_DEPTH = 40
"""Halvings of one hexahedron: the smallest box is at the rounding of its parameters."""

_TENSOR_8 = np.array([0, 1, 3, 2, 4, 5, 7, 6])
"""Corner i + 2 j + 4 k of a hexahedron in VTK's order."""

_TENSOR_27 = np.array(
    [0, 8, 1, 11, 24, 9, 3, 10, 2, 16, 22, 17, 20, 26, 21, 19, 23, 18, 4, 12, 5, 15, 25, 13, 7, 14, 6]
)
"""Node i + 3 j + 9 k of a hex27 in VTK's order."""


def positive_inside(points: FloatArray, hexes: IntArray) -> tuple[np.ndarray, FloatArray]:
    """Decide for every hexahedron whether its Jacobian is positive everywhere.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 8), (m, 20) or (m, 27) int64
        VTK node order.

    Returns
    -------
    positive : (m,) bool
        True only where it is proven.
    volumes : (m,) float64
        Integrals of the Jacobian.
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    positive = np.zeros(len(hexes), dtype=np.bool_)
    volumes = np.zeros(len(hexes))
    order = 1 if hexes.shape[1] == 8 else 2
    for first in range(0, len(hexes), 4096):
        some = slice(first, first + 4096)
        controls = _controls(points, hexes[some], order)
        _decide(controls, order, MAX_BOXES, MAX_DEPTH, positive[some], volumes[some])
    return positive, volumes


def _controls(points: FloatArray, hexes: IntArray, order: int) -> FloatArray:
    """Bernstein control points (m, order + 1, order + 1, order + 1, 3), indexed k, j, i."""
    if order == 1:
        return points[hexes[:, _TENSOR_8]].reshape(-1, 2, 2, 2, 3)
    nodes = points[hexes] if hexes.shape[1] == 27 else _with_inner_nodes(points[hexes])
    grid = nodes[:, _TENSOR_27].reshape(-1, 3, 3, 3, 3)
    # The middle control point of a parabola through a, m, b is 2 m - (a + b) / 2.
    to_control = np.array([[1.0, 0.0, 0.0], [-0.5, 2.0, -0.5], [0.0, 0.0, 1.0]])
    return np.ascontiguousarray(
        np.einsum("kK,jJ,iI,mKJIc->mkjic", to_control, to_control, to_control, grid, optimize=True)
    )


def _with_inner_nodes(nodes: FloatArray) -> FloatArray:
    """Add to hex20 nodes (m, 20, 3) the face and volume nodes at which the serendipity shape lies."""
    faces = [
        ((0, 4, 7, 3), (16, 15, 19, 11)),
        ((1, 2, 6, 5), (9, 18, 13, 17)),
        ((0, 1, 5, 4), (8, 17, 12, 16)),
        ((3, 7, 6, 2), (19, 14, 18, 10)),
        ((0, 3, 2, 1), (11, 10, 9, 8)),
        ((4, 5, 6, 7), (12, 13, 14, 15)),
    ]
    inner = [nodes[:, m].sum(axis=1) / 2 - nodes[:, c].sum(axis=1) / 4 for c, m in faces]
    inner.append(nodes[:, 8:].sum(axis=1) / 4 - nodes[:, :8].sum(axis=1) / 4)
    return np.concatenate([nodes, np.stack(inner, axis=1)], axis=1)


@njit(cache=True, error_model="numpy", nogil=True)
def _binomials(degree):  # type: ignore[no-untyped-def]
    row = np.ones(degree + 1)
    for i in range(1, degree + 1):
        row[i] = row[i - 1] * (degree + 1 - i) / i
    return row


@njit(cache=True, error_model="numpy", nogil=True)
def _column(control, axis, order):  # type: ignore[no-untyped-def]
    """Derivative along an axis (0: i, 1: j, 2: k), its coefficients times their binomials, and its longest."""
    n0 = order + (axis != 2)
    n1 = order + (axis != 1)
    n2 = order + (axis != 0)
    b0, b1, b2 = _binomials(n0 - 1), _binomials(n1 - 1), _binomials(n2 - 1)
    column = np.empty((n0, n1, n2, 3))
    longest = 0.0
    for k in range(n0):
        for j in range(n1):
            for i in range(n2):
                square = 0.0
                for c in range(3):
                    ahead = control[k + (axis == 2), j + (axis == 1), i + (axis == 0), c]
                    step = order * (ahead - control[k, j, i, c])
                    square += step * step
                    column[k, j, i, c] = step * b0[k] * b1[j] * b2[i]
                longest = max(longest, square)
    return column, np.sqrt(longest)


@njit(cache=True, error_model="numpy", nogil=True)
def _jacobian(control, order):  # type: ignore[no-untyped-def]  # noqa: PLR0912
    """Bernstein coefficients (d + 1, d + 1, d + 1), d = 3 order - 1, of the Jacobian, and its scale."""
    u, longest_u = _column(control, 0, order)
    v, longest_v = _column(control, 1, order)
    w, longest_w = _column(control, 2, order)
    normal = np.zeros((2 * order + 1, 2 * order, 2 * order, 3))
    for k in range(order + 1):
        for j in range(order + 1):
            for i in range(order):
                a = u[k, j, i]
                for kk in range(order + 1):
                    for jj in range(order):
                        for ii in range(order + 1):
                            b = v[kk, jj, ii]
                            n = normal[k + kk, j + jj, i + ii]
                            n[0] += a[1] * b[2] - a[2] * b[1]
                            n[1] += a[2] * b[0] - a[0] * b[2]
                            n[2] += a[0] * b[1] - a[1] * b[0]
    size = 3 * order
    jacobian = np.zeros((size, size, size))
    for k in range(2 * order + 1):
        for j in range(2 * order):
            for i in range(2 * order):
                n = normal[k, j, i]
                for kk in range(order):
                    for jj in range(order + 1):
                        for ii in range(order + 1):
                            b = w[kk, jj, ii]
                            jacobian[k + kk, j + jj, i + ii] += n[0] * b[0] + n[1] * b[1] + n[2] * b[2]
    row = _binomials(size - 1)
    for k in range(size):
        for j in range(size):
            for i in range(size):
                jacobian[k, j, i] /= row[k] * row[j] * row[i]
    return jacobian, longest_u * longest_v * longest_w


@njit(cache=True, error_model="numpy", nogil=True)
def _halve(box, axis, lower, upper):  # type: ignore[no-untyped-def]
    """Cut a box of coefficients in two by de Casteljau's rule along an axis."""
    n = box.shape[0]
    line = np.empty(n)
    for a in range(n):
        for b in range(n):
            for m in range(n):
                line[m] = box[m, a, b] if axis == 0 else (box[a, m, b] if axis == 1 else box[a, b, m])
            for m in range(n):
                low, high = line[0], line[n - 1 - m]
                if axis == 0:
                    lower[m, a, b], upper[n - 1 - m, a, b] = low, high
                elif axis == 1:
                    lower[a, m, b], upper[a, n - 1 - m, b] = low, high
                else:
                    lower[a, b, m], upper[a, b, n - 1 - m] = low, high
                for i in range(n - 1 - m):
                    line[i] = 0.5 * (line[i] + line[i + 1])


@njit(cache=True, error_model="numpy", nogil=True)
def _is_positive(jacobian, least, max_boxes, max_depth):  # type: ignore[no-untyped-def]
    """Whether a polynomial is proven to exceed `least` on the whole box."""
    n = jacobian.shape[0]
    # A branch leaves at most one open sibling a level: halving one axis at a time keeps the stack short.
    stack = np.empty((3 * max_depth + 2, n, n, n))
    depth = np.zeros(3 * max_depth + 2, dtype=np.int64)
    stack[0] = jacobian
    top = 1
    for _ in range(max_boxes):
        if top == 0:
            return True
        top -= 1
        box = stack[top].copy()
        level = depth[top]
        if not box.min() <= least:
            continue
        for k in (0, n - 1):
            for j in (0, n - 1):
                for i in (0, n - 1):
                    if not box[k, j, i] > least:
                        return False
        if level >= 3 * max_depth:
            return False
        _halve(box, level % 3, stack[top], stack[top + 1])
        depth[top] = depth[top + 1] = level + 1
        top += 2
    return False


@njit(cache=True, error_model="numpy", nogil=True)
def _decide(controls, order, max_boxes, max_depth, positive, volumes):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    for h in range(controls.shape[0]):
        jacobian, scale = _jacobian(controls[h], order)
        volumes[h] = jacobian.mean()
        finite = np.isfinite(scale) and np.isfinite(volumes[h]) and scale > 0.0
        positive[h] = finite and _is_positive(jacobian, ZERO * scale, max_boxes, max_depth)
