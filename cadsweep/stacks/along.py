"""Heights of faces and edges over places on a plane: where a line along the direction meets them.

Place in the flow: foundation of :mod:`cadsweep.stacks`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Curve, Edge, Face
from ..errors import SurfaceMeshError

Rim = tuple[Edge, IntArray]
"""An edge of a cap, and which of some places lie under it."""

_STEPS = 30
_CLOSE = 1e-12
"""Distance from the line, in sizes of the face, at which a point of the face is on it."""
_ENOUGH = 1e-9
"""The same, beyond which the search has failed."""
_AT = np.linspace(0.0, 1.0, 129)
"""Fractions of an edge's samples."""
_THREE = np.array([0.0, 0.5, 1.0])
_LEVEL = 1e-15
"""Difference of heights, in lengths or heights of the edge, that rounding makes of none."""
_APART = 1e-6
"""Fraction of an edge over which its tangent is taken."""
_STILL = 1e-13
"""Move, as a fraction of the edge, below which a place has been found."""
_PLANAR = ("line", "circle", "ellipse")
"""Kinds of edges that lie in the plane through any three of their points."""
_AT_END = 1e-6
"""Distance from the place of an edge's end, in lengths of the edge, at which a place is that."""


def across(direction: FloatArray) -> FloatArray:
    """Two unit vectors (2, 3) across a direction, right-handed with it."""
    x, y, z = direction.tolist()
    axis = int(np.argmin(np.abs(direction)))
    first = np.array([(0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0)][axis])
    first /= np.linalg.norm(first)
    a, b, c = first.tolist()
    # Written out: many caps and edges ask for it, and ``numpy.cross`` takes ten times as long for two vectors.
    return np.array([first, (y * c - z * b, z * a - x * c, x * b - y * a)])


def heights_on_face(face: Face, direction: FloatArray, places: FloatArray) -> FloatArray:
    """Heights ``x @ direction`` of the points x of a face over places.

    Parameters
    ----------
    face : Face
        A line along `direction` crosses it once.
    direction : (3,) float64
        Unit vector.
    places : (m, 3) float64
        Anywhere on the lines.

    Returns
    -------
    (m,) float64

    Raises
    ------
    SurfaceMeshError
        A line misses the face's surface.
    """
    base = places @ direction
    slope = face.normal @ direction
    if face.kind == "plane":
        return base + ((face.center - places) @ face.normal) / slope
    surface, frame = face.surface, across(direction)
    size = max(np.sqrt(face.area), 1e-300)
    # The plane through the middle is a start; the nearest point to it is on the face's own side of the surface.
    guess = places + ((face.center - places) @ direction)[:, None] * direction
    for _ in range(3):
        uv = surface.project(guess)
        guess = places + ((surface.evaluate(uv) - places) @ direction)[:, None] * direction
    for _ in range(_STEPS):
        gap = (surface.evaluate(uv) - places) @ frame.T
        if float(np.abs(gap).max()) <= _CLOSE * size:
            break
        by_u, by_v = surface.derivatives(uv)
        jacobian = np.stack([by_u @ frame.T, by_v @ frame.T], axis=-1)
        determinant = np.linalg.det(jacobian)
        safe = np.abs(determinant) > 1e-14 * (np.abs(jacobian).max(axis=(1, 2)) ** 2)
        step = np.zeros_like(uv)
        step[safe] = np.linalg.solve(jacobian[safe], gap[safe][..., None])[..., 0]
        uv = uv - step
    found = surface.evaluate(uv)
    gap = np.abs((found - places) @ frame.T).max(axis=1)
    if not float(gap.max()) <= _ENOUGH * size:
        j = int(np.argmax(gap))
        raise SurfaceMeshError(
            f"{face.label()} has no point over ({face.units.place(places[j])}) along the stack's direction"
        )
    return np.asarray(found @ direction)


def heights_on_cap(face: Face, direction: FloatArray, places: FloatArray, rims: Sequence[Rim]) -> FloatArray:
    """Heights of the points of a cap over places (m, 3): on its rim those of its edges.

    A cap may be tangent to a wall along its rim, where its surface has no one height over a place.
    """
    if face.kind == "plane":
        return heights_on_face(face, direction, places)
    found = np.full(len(places), np.nan)
    for edge, at in rims:
        found[at] = heights_on_edge(edge, direction, places[at])
    inner = np.isnan(found)
    if inner.any():
        found[inner] = heights_on_face(face, direction, places[inner])
    return found


def heights_on_edge(edge: Edge, direction: FloatArray, places: FloatArray) -> FloatArray:
    """Heights of the points of an edge over places (m, 3) that lie under it."""
    curve = edge.curve
    if edge.kind in _PLANAR:
        some = curve.evaluate(_THREE)
        heights = (some @ direction).tolist()
        low, high = min(heights), max(heights)
        if high - low <= _LEVEL * max(edge.length, high, -low):
            return np.full(len(places), heights[1])
    frame = across(direction)
    seen = (some[::2] if edge.kind == "line" else curve.evaluate(_AT)) @ frame.T
    target = places @ frame.T
    # An edge that ends along the direction has no height to speak of there but that of its end.
    at_start, at_end = (np.linalg.norm(target - seen[end], axis=1) <= _AT_END * edge.length for end in (0, -1))
    fractions = np.where(at_end & ~at_start, 1.0, 0.0)
    inner = np.flatnonzero(~(at_start | at_end))
    if len(inner) and edge.kind == "line":
        step = seen[1] - seen[0]
        fractions[inner] = np.clip((target[inner] - seen[0]) @ step / max(step @ step, 1e-300), 0.0, 1.0)
    elif len(inner):
        fractions[inner] = _fractions_under(curve, frame, seen, target[inner])
    return np.asarray(curve.evaluate(fractions) @ direction)


def _fractions_under(curve: Curve, frame: FloatArray, seen: FloatArray, target: FloatArray) -> FloatArray:
    """Fractions (m,) of a curve at places (m, 2) of the plane, from its samples `seen` there."""
    n = len(target)
    fractions = _AT[np.argmin(np.linalg.norm(seen[None] - target[:, None], axis=2), axis=1)]
    for _ in range(_STEPS):
        low, high = np.clip(fractions - _APART, 0.0, 1.0), np.clip(fractions + _APART, 0.0, 1.0)
        found = curve.evaluate(np.concatenate([low, high, fractions])) @ frame.T
        tangent = (found[n : 2 * n] - found[:n]) / (high - low)[:, None]
        gap = target - found[2 * n :]
        move = (gap * tangent).sum(axis=1) / np.maximum((tangent**2).sum(axis=1), 1e-300)
        fractions = np.clip(fractions + move, 0.0, 1.0)
        if float(np.abs(move).max()) < _STILL:
            break
    return fractions
