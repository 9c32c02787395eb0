"""Conformal charts of a curved face: angles stay as they are, so quads that are square in the plane are on the face.

Place in the flow: ``charts`` asks for one where its other charts squeeze the face more one way than the other: a
dome as high as it is wide, looked at from above, has its flanks in a thin ring.

Method: least-squares conformal map of a triangulation of the face, with its outline free. How much it enlarges or
shrinks is left to the size field (:mod:`.background`).

Not handled: outlines that overlap themselves in the conformal map.

References
----------
Levy, Petitjean, Ray, Maillot, "Least squares conformal maps for automatic texture atlas generation", SIGGRAPH 2002.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray

_NEAR = 12
"""Triangles, by their middles, among which the one around a place is looked for."""


def conformal_map(points: FloatArray, triangles: IntArray) -> FloatArray | None:
    """Flatten a triangulated disc, with holes or without.

    Parameters
    ----------
    points : (n, 3) float64
    triangles : (t, 3) int64
        Of one orientation.

    Returns
    -------
    (n, 2) float64 or None
        Triangles counter-clockwise, their areas in sum as in space; None where one is turned over.
    """
    corners = points[triangles]
    first = corners[:, 1] - corners[:, 0]
    second = corners[:, 2] - corners[:, 0]
    length = np.linalg.norm(first, axis=1)
    normal = np.cross(first, second)
    twice = np.linalg.norm(normal, axis=1)
    if not (length > 0).all() or not (twice > 0).all():
        return None
    x2 = (first * second).sum(axis=1) / length
    local = np.zeros((len(triangles), 3), dtype=complex)
    local[:, 1], local[:, 2] = length, x2 + 1j * twice / length
    # Each corner's weight is the opposite side; a conformal map makes their sum with the places vanish.
    weight = (np.roll(local, -2, axis=1) - np.roll(local, -1, axis=1)) / np.sqrt(twice)[:, None]
    rows = np.repeat(np.arange(len(triangles)), 3)
    matrix = scipy.sparse.csc_matrix((weight.ravel(), (rows, triangles.ravel())), shape=(len(triangles), len(points)))
    start = int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))
    end = int(np.argmax(np.linalg.norm(points - points[start], axis=1)))
    pinned = np.array([start, end])
    free = np.setdiff1d(np.arange(len(points)), pinned)
    held = np.array([0.0, np.linalg.norm(points[end] - points[start])], dtype=complex)
    a, b = matrix[:, free], matrix[:, pinned]
    # The sum of squares of complex residuals is minimal where its normal equations, Hermitian ones, hold.
    hermitian = (a.conj().T @ a).tocsc()
    places = np.empty(len(points), dtype=complex)
    places[pinned] = held
    places[free] = scipy.sparse.linalg.splu(hermitian).solve(-(a.conj().T @ (b @ held)))
    flat = np.stack([places.real, places.imag], axis=1)
    flat_corners = flat[triangles]
    u, v = flat_corners[:, 1] - flat_corners[:, 0], flat_corners[:, 2] - flat_corners[:, 0]
    flat_twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    if not np.isfinite(flat).all() or not (flat_twice > 0).all():
        return None
    return flat * np.sqrt(twice.sum() / flat_twice.sum())


def make_locator(flat: FloatArray, triangles: IntArray) -> Callable[[FloatArray], tuple[IntArray, FloatArray]]:
    """Find the triangle of a flat triangulation around places.

    Returns
    -------
    callable
        ``locate(places (m, 2)) -> (nodes (m, 3), weights (m, 3))``: places outside get the nearest point of a triangle
        near them.
    """
    corners = flat[triangles]
    tree = scipy.spatial.cKDTree(corners.mean(axis=1))
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    twice = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    near = min(_NEAR, len(triangles))

    def locate(places: FloatArray) -> tuple[IntArray, FloatArray]:
        candidates = tree.query(places, k=near)[1].reshape(len(places), near)
        off = places[:, None] - corners[candidates, 0]
        e, f, area = first[candidates], second[candidates], twice[candidates]
        second_weight = (off[..., 0] * f[..., 1] - off[..., 1] * f[..., 0]) / area
        third_weight = (e[..., 0] * off[..., 1] - e[..., 1] * off[..., 0]) / area
        weights = np.stack([1 - second_weight - third_weight, second_weight, third_weight], axis=-1)
        best = np.argmax(weights.min(axis=-1), axis=1)
        rows = np.arange(len(places))
        chosen = np.clip(weights[rows, best], 0.0, None)
        return triangles[candidates[rows, best]], chosen / chosen.sum(axis=1, keepdims=True)

    return locate
