"""Is the Jacobian of a hexahedron positive everywhere inside? Bernstein bounds, subdivided until decided.

Place in the flow: :mod:`cadsweep.quality.accumulate` sends the hexahedra here whose first bound did
not decide (some per ten thousand), and every hexahedron of order 2 and above; of orders above 2 those that do not bend
count as of order 1.

Method. The Jacobian determinant is a polynomial: of degree 3 p - 1 in each direction: 2 for hex8, 5 for hex27,
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

import math
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from ..compiled import compiled
from ..lattice import lexicographic, order_of
from .kernels import ZERO

MAX_BOXES = 20_000
"""Boxes that are looked at for one hexahedron before it counts as not positive."""

MAX_DEPTH = 40
"""Halvings of one hexahedron: the smallest box is at the rounding of its parameters."""


class Proof(NamedTuple):
    """What is proven of hexahedra (m,).

    Attributes
    ----------
    positive : (m,) bool
        Whether the Jacobian determinant is positive everywhere: True only where it is proven.
    volumes : (m,) float64
        Its integrals.
    ratios : (m,) float64
        Its least value over its greatest, of 3 p equispaced places in each direction, corners included.
    bounds : (m,) float64
        Its least Bernstein coefficient over that greatest value: nowhere is it less. Negative where the proof had to
        subdivide.
    """

    positive: np.ndarray
    volumes: FloatArray
    ratios: FloatArray
    bounds: FloatArray


def positive_inside(points: FloatArray, hexes: IntArray) -> tuple[np.ndarray, FloatArray]:
    """Decide for every hexahedron whether its Jacobian is positive everywhere; the first two of :func:`prove`."""
    return prove(points, hexes)[:2]


def prove(points: FloatArray, hexes: IntArray) -> Proof:
    """Decide for every hexahedron whether its Jacobian is positive everywhere, and how much.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 8), (m, 20) or (m, (p + 1)^3) int64
        VTK node order.
    """
    points = np.ascontiguousarray(points, dtype=np.float64)
    proof = Proof(np.zeros(len(hexes), dtype=np.bool_), *np.zeros((3, len(hexes))))
    order = order_of(hexes.shape[1])
    for first in range(0, len(hexes), 4096):
        some = slice(first, first + 4096)
        grid = _grid(points, hexes[some], order)
        bent = np.flatnonzero(_is_bent(grid)) if order > 2 else np.arange(len(grid))
        if len(bent) < len(grid):
            straight, corners = np.setdiff1d(np.arange(len(grid)), bent), np.array([0, order])
            ends = np.ascontiguousarray(grid[np.ix_(straight, corners, corners, corners)])
            _decide_some(ends, 1, first + straight, proof)
        _decide_some(_controls(grid[bent], order), order, first + bent, proof)
    return proof


def _decide_some(controls: FloatArray, order: int, at: IntArray, proof: Proof) -> None:
    own = Proof(np.zeros(len(at), dtype=np.bool_), *np.zeros((3, len(at))))
    n = 3 * order
    places, degree = np.linspace(0.0, 1.0, n)[:, None], np.arange(n)
    values = np.array([math.comb(n - 1, i) for i in range(n)]) * places**degree * (1.0 - places) ** (n - 1 - degree)
    _decide(controls, order, MAX_BOXES, MAX_DEPTH, values, *own)
    for found, part in zip(proof, own, strict=True):
        found[at] = part


def _grid(points: FloatArray, hexes: IntArray, order: int) -> FloatArray:
    """Nodes (m, order + 1, order + 1, order + 1, 3), indexed k, j, i."""
    nodes = with_inner_nodes(points[hexes]) if hexes.shape[1] == 20 else points[hexes]
    n = order + 1
    return np.ascontiguousarray(nodes[:, lexicographic(order)].reshape(-1, n, n, n, 3))


def _is_bent(grid: FloatArray) -> np.ndarray:
    """Which hexahedra are not, but for rounding, the trilinear ones of their corners."""
    order = grid.shape[1] - 1
    at = np.arange(order + 1) / order
    ends = np.stack([1.0 - at, at], axis=1)
    straight = np.einsum("kK,jJ,iI,mKJIc->mkjic", ends, ends, ends, grid[:, ::order, ::order, ::order], optimize=True)
    off = np.abs(grid - straight).max(axis=(1, 2, 3, 4))
    is_bent: np.ndarray = ~(off <= 1e-14 * np.abs(grid).max(axis=(1, 2, 3, 4)))
    return is_bent


def _controls(grid: FloatArray, order: int) -> FloatArray:
    """Bernstein control points (m, order + 1, order + 1, order + 1, 3), indexed k, j, i."""
    if order == 1:
        return grid
    at, degree = np.arange(order + 1) / order, np.arange(order + 1)
    choose = np.array([math.comb(order, i) for i in range(order + 1)])
    # The Bernstein polynomials at the nodes; of order 2 the inverse is exact: 2 m - (a + b) / 2.
    to_control = np.linalg.inv(choose * at[:, None] ** degree * (1.0 - at[:, None]) ** (order - degree))
    return np.ascontiguousarray(
        np.einsum("kK,jJ,iI,mKJIc->mkjic", to_control, to_control, to_control, grid, optimize=True)
    )


def with_inner_nodes(nodes: FloatArray) -> FloatArray:
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


_compiled = compiled(cache=True, error_model="numpy", nogil=True)


@_compiled
def _binomials(degree):  # type: ignore[no-untyped-def]
    row = np.ones(degree + 1)
    for i in range(1, degree + 1):
        row[i] = row[i - 1] * (degree + 1 - i) / i
    return row


@_compiled
def _column(controls, h, axis, order, column):  # type: ignore[no-untyped-def]
    """Fill `column` with the derivative along an axis (0: i, 1: j, 2: k), its coefficients times their binomials.

    Returns the length of the longest coefficient.
    """
    n0, n1, n2 = order + (axis != 2), order + (axis != 1), order + (axis != 0)
    b0, b1, b2 = _binomials(n0 - 1), _binomials(n1 - 1), _binomials(n2 - 1)
    longest = 0.0
    for k in range(n0):
        for j in range(n1):
            for i in range(n2):
                square = 0.0
                for c in range(3):
                    ahead = controls[h, k + (axis == 2), j + (axis == 1), i + (axis == 0), c]
                    step = order * (ahead - controls[h, k, j, i, c])
                    square += step * step
                    column[k, j, i, c] = step * b0[k] * b1[j] * b2[i]
                longest = max(longest, square)
    return np.sqrt(longest)


@_compiled
def _add_products(u, v, order, normal):  # type: ignore[no-untyped-def]
    """Fill `normal` with the coefficients of u x v, times their binomials."""
    for k in range(2 * order + 1):
        for j in range(2 * order):
            for i in range(2 * order):
                normal[k, j, i, 0] = normal[k, j, i, 1] = normal[k, j, i, 2] = 0.0
    for a in range((order + 1) * (order + 1) * order):
        k, j, i = a // order // (order + 1), a // order % (order + 1), a % order
        for b in range((order + 1) * order * (order + 1)):
            kk, jj, ii = b // (order + 1) // order, b // (order + 1) % order, b % (order + 1)
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                normal[k + kk, j + jj, i + ii, c] += u[k, j, i, d] * v[kk, jj, ii, e] - u[k, j, i, e] * v[kk, jj, ii, d]


@_compiled
def _jacobian(controls, h, order, jacobian):  # type: ignore[no-untyped-def]
    """Fill `jacobian` with its Bernstein coefficients, index (k n + j) n + i, n = 3 order; return its scale."""
    most = order + 1
    u, v, w = np.empty((most, most, most, 3)), np.empty((most, most, most, 3)), np.empty((most, most, most, 3))
    scale = _column(controls, h, 0, order, u) * _column(controls, h, 1, order, v) * _column(controls, h, 2, order, w)
    normal = np.empty((2 * order + 1, 2 * order, 2 * order, 3))
    _add_products(u, v, order, normal)
    n = 3 * order
    for m in range(n * n * n):
        jacobian[m] = 0.0
    for k in range(2 * order + 1):
        for j in range(2 * order):
            for i in range(2 * order):
                for b in range(order * (order + 1) * (order + 1)):
                    kk, jj, ii = b // (order + 1) // (order + 1), b // (order + 1) % (order + 1), b % (order + 1)
                    at = ((k + kk) * n + j + jj) * n + i + ii
                    for c in range(3):
                        jacobian[at] += normal[k, j, i, c] * w[kk, jj, ii, c]
    row = _binomials(n - 1)
    for m in range(n * n * n):
        jacobian[m] /= row[m // n // n] * row[m // n % n] * row[m % n]
    return scale


@_compiled
def _halve(stack, at, n, axis):  # type: ignore[no-untyped-def]
    """Cut box `at` of the stack in two by de Casteljau's rule: the halves replace it and follow it."""
    stride = n ** (2 - axis)
    line = np.empty(n)
    for a in range(n):
        for b in range(n):
            # First entry of the line: its position's digits in base n, the axis' own digit 0.
            first = a * (n * n if axis > 0 else n) + b * (n if axis == 2 else 1)
            for m in range(n):
                line[m] = stack[at, first + m * stride]
            for m in range(n):
                stack[at, first + m * stride] = line[0]
                stack[at + 1, first + (n - 1 - m) * stride] = line[n - 1 - m]
                for i in range(n - 1 - m):
                    line[i] = 0.5 * (line[i] + line[i + 1])


@_compiled
def _is_positive(jacobian, n, least, max_boxes, max_depth):  # type: ignore[no-untyped-def]
    """Whether a polynomial with coefficients (n * n * n,) is proven to exceed `least` on the whole box."""
    size = n * n * n
    # A branch leaves at most one open sibling a level: halving one axis at a time keeps the stack short.
    stack = np.empty((3 * max_depth + 2, size))
    depth = np.zeros(3 * max_depth + 2, dtype=np.int64)
    for i in range(size):
        stack[0, i] = jacobian[i]
    top = 1
    for _ in range(max_boxes):
        if top == 0:
            return True
        top -= 1
        level = depth[top]
        bound = np.inf
        for i in range(size):
            # In this order a coefficient that is no number becomes the bound.
            bound = bound if stack[top, i] > bound else stack[top, i]
        if bound > least:
            continue
        for corner in range(8):
            at = (n - 1) * ((corner & 1) + n * ((corner >> 1) & 1) + n * n * (corner >> 2))
            if not stack[top, at] > least:
                return False
        if level >= 3 * max_depth:
            return False
        _halve(stack, top, n, level % 3)
        depth[top] = depth[top + 1] = level + 1
        top += 2
    return False


@_compiled
def _extremes(jacobian, n, values):  # type: ignore[no-untyped-def]
    """Least and greatest value of a polynomial with coefficients (n * n * n,) where `values` (n, n) says."""
    before, after = jacobian.reshape(n * n, n).copy(), np.empty((n * n, n))
    for _ in range(3):  # each time the last axis is evaluated and becomes the first
        for i in range(n):
            for m in range(n * n):
                total = 0.0
                for c in range(n):
                    total += values[i, c] * before[m, c]
                after[(i * n * n + m) // n, (i * n * n + m) % n] = total
        before, after = after, before
    return before.min(), before.max()


@_compiled
def _decide(controls, order, max_boxes, max_depth, values, positive, volumes, ratios, bounds):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    n = 3 * order
    jacobian = np.empty(n * n * n)
    for h in range(controls.shape[0]):
        scale = _jacobian(controls, h, order, jacobian)
        total = 0.0
        for i in range(n * n * n):
            total += jacobian[i]
        volumes[h] = total / (n * n * n)
        finite = np.isfinite(scale) and np.isfinite(total) and scale > 0.0
        positive[h] = finite and _is_positive(jacobian, n, ZERO * scale, max_boxes, max_depth)
        least, greatest = _extremes(jacobian, n, values)
        ratios[h] = least / greatest if greatest > 0.0 else -np.inf
        bounds[h] = jacobian.min() / greatest if greatest > 0.0 else -np.inf
