"""Rational B-splines as arrays: points and derivatives of thousands of parameters at a time.

Place in the flow: ``curves`` and ``surfaces`` use these evaluators, because a call into
OpenCASCADE for every point costs more than the mesh.

Method: basis functions by the Cox-de Boor recurrence (Piegl and Tiller, "The NURBS Book", 2nd ed.,
section 2.5), every parameter at once; rational points by the quotient rule.

Not handled: periodic knot vectors. The caller turns them into clamped ones first.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray, IntArray

_CHUNK = 1 << 14
"""Parameters evaluated at once, which keeps the gathered poles of a surface within the cache."""


def basis(knots: FloatArray, degree: int, spans: IntArray, parameters: FloatArray, order: int = 0) -> FloatArray:
    """Evaluate the non-zero B-spline basis functions, or a derivative of them.

    Parameters
    ----------
    knots : (n_poles + degree + 1,) float64
    degree : int
    spans : (m,) int64
        Index of the knot span of each parameter (:func:`find_spans`).
    parameters : (m,) float64
    order : int
        Order of the derivative.

    Returns
    -------
    (m, degree + 1) float64
        Functions ``spans - degree`` to ``spans``.
    """
    values = np.zeros((len(parameters), degree + 1))
    if order > degree:
        return values
    if order == 0:
        values[:, 0] = 1.0
        for p in range(1, degree + 1):
            saved = np.zeros(len(parameters))
            for j in range(p):
                right = knots[spans + j + 1]
                left = knots[spans + j + 1 - p]
                share = values[:, j] / (right - left)
                values[:, j] = saved + (right - parameters) * share
                saved = (parameters - left) * share
            values[:, p] = saved
        return values
    lower = basis(knots, degree - 1, spans, parameters, order - 1)
    for j in range(degree):
        # Function j of degree p - 1 lives on the knots that functions j and j + 1 of degree p share.
        share = degree * lower[:, j] / (knots[spans + j + 1] - knots[spans + j + 1 - degree])
        values[:, j] -= share
        values[:, j + 1] += share
    return values


def find_spans(knots: FloatArray, degree: int, parameters: FloatArray) -> IntArray:
    """Index of the non-empty knot span of each parameter; the end belongs to the last span."""
    n_poles = len(knots) - degree - 1
    spans = np.searchsorted(knots, parameters, side="right") - 1
    last = int(np.searchsorted(knots, knots[n_poles], side="left")) - 1
    first = int(np.searchsorted(knots, knots[degree], side="right")) - 1
    return np.clip(spans, first, last).astype(np.int64)


@dataclass(frozen=True, kw_only=True, eq=False)
class BSpline:
    """A clamped, possibly rational B-spline curve in any dimension.

    Attributes
    ----------
    degree : int
    knots : (n + degree + 1,) float64
        With repetitions.
    poles : (n, d) float64
    weights : (n,) float64 or None
    """

    degree: int
    knots: FloatArray
    poles: FloatArray
    weights: FloatArray | None = None

    @property
    def breaks(self) -> FloatArray:
        """Distinct knots: between two of them the curve is smooth."""
        return np.unique(self.knots)

    def derivatives(self, parameters: FloatArray, order: int = 0) -> list[FloatArray]:
        """Points and derivatives up to `order` (0, 1 or 2), each (m, d)."""
        poles = self.poles
        if self.weights is not None:
            poles = np.column_stack([poles * self.weights[:, None], self.weights])
        spans = find_spans(self.knots, self.degree, parameters)
        local = poles[spans[:, None] + np.arange(-self.degree, 1)]
        homogeneous = [
            np.einsum("mi,mid->md", basis(self.knots, self.degree, spans, parameters, k), local)
            for k in range(order + 1)
        ]
        if self.weights is None:
            return homogeneous
        w = homogeneous[0][:, -1:]
        out = [homogeneous[0][:, :-1] / w]
        if order >= 1:
            dw = homogeneous[1][:, -1:]
            out.append((homogeneous[1][:, :-1] - dw * out[0]) / w)
        if order >= 2:
            out.append((homogeneous[2][:, :-1] - 2 * dw * out[1] - homogeneous[2][:, -1:] * out[0]) / w)
        return out


@dataclass(frozen=True, kw_only=True, eq=False)
class BSplineSurface:
    """A clamped, possibly rational tensor-product B-spline surface in space.

    Attributes
    ----------
    degrees : (int, int)
    u_knots, v_knots : float64 arrays
        With repetitions.
    poles : (n_u, n_v, 3) float64
    weights : (n_u, n_v) float64 or None
    """

    degrees: tuple[int, int]
    u_knots: FloatArray
    v_knots: FloatArray
    poles: FloatArray
    weights: FloatArray | None = None

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3) at the parameters (m, 2)."""
        return self._partials(uv, ((0, 0),))[0]

    def evaluate_grid(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Points (m, n, 3) at all pairs of parameters `u` (m,) and `v` (n,)."""
        in_u, in_v = _all_functions(self.u_knots, self.degrees[0], u), _all_functions(self.v_knots, self.degrees[1], v)
        weights = np.ones(self.poles.shape[:2]) if self.weights is None else self.weights
        homogeneous = np.concatenate([self.poles * weights[..., None], weights[..., None]], axis=2)
        points = np.einsum("mi,ijc,nj->mnc", in_u, homogeneous, in_v, optimize=True)
        return np.asarray(points[..., :3] / points[..., 3:])

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points and partial derivatives by u and v, each (m, 3)."""
        point, by_u, by_v = self._partials(uv, ((0, 0), (1, 0), (0, 1)))
        return point, by_u, by_v

    def _partials(self, uv: FloatArray, orders: tuple[tuple[int, int], ...]) -> list[FloatArray]:
        out = [np.empty((len(uv), 3)) for _ in orders]
        for start in range(0, len(uv), _CHUNK):
            part = slice(start, start + _CHUNK)
            for target, values in zip(out, self._chunk(uv[part], orders), strict=True):
                target[part] = values
        return out

    def _chunk(self, uv: FloatArray, orders: tuple[tuple[int, int], ...]) -> list[FloatArray]:
        p, q = self.degrees
        u, v = np.ascontiguousarray(uv[:, 0]), np.ascontiguousarray(uv[:, 1])
        u_spans, v_spans = find_spans(self.u_knots, p, u), find_spans(self.v_knots, q, v)
        rows = (u_spans[:, None] + np.arange(-p, 1))[:, :, None]
        columns = (v_spans[:, None] + np.arange(-q, 1))[:, None, :]
        local = self.poles[rows, columns]
        if self.weights is not None:
            w = self.weights[rows, columns][..., None]
            local = np.concatenate([local * w, w], axis=-1)
        in_u = [basis(self.u_knots, p, u_spans, u, k) for k in range(max(a for a, _ in orders) + 1)]
        in_v = [basis(self.v_knots, q, v_spans, v, k) for k in range(max(b for _, b in orders) + 1)]
        half = [np.einsum("mj,mijd->mid", values, local, optimize=True) for values in in_v]
        values = [np.einsum("mi,mid->md", in_u[a], half[b]) for a, b in orders]
        if self.weights is None:
            return values
        w0 = values[0][:, 3:]
        point = values[0][:, :3] / w0
        return [point] + [(d[:, :3] - d[:, 3:] * point) / w0 for d in values[1:]]


def _all_functions(knots: FloatArray, degree: int, parameters: FloatArray) -> FloatArray:
    """All basis functions (m, n_poles) at parameters (m,), most of them 0."""
    spans = find_spans(knots, degree, parameters)
    functions = np.zeros((len(parameters), len(knots) - degree - 1))
    np.put_along_axis(
        functions, spans[:, None] + np.arange(-degree, 1), basis(knots, degree, spans, parameters), axis=1
    )
    return functions
