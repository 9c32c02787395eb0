"""The plane, cylinder, sphere, cone or torus through points, by their normals.

Place in the flow: for :mod:`..heal.canonical`.

Method: no parametrisation is asked, only points and unit normals. A cylinder's normals are all square to its axis;
those of a cone make one angle with it, and its tangent planes meet in the apex; the normals of any surface of
revolution meet the axis, which is a linear condition on it (a linear complex of lines, see Pottmann and Wallner,
Computational Line Geometry, 2001, ch. 3). Radii are those of circles and spheres by linear least squares. What was
found is taken only where every point lies on it, so that none of the steps needs a tolerance of its own.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arrays import BoolArray, FloatArray

_HAS_TURN = 1e-6
"""Share of turning in a motion along a surface, below which it is a shift."""


class Elementary(NamedTuple):
    """A surface: its kind, a place on its axis (of a cone, the apex), the axis, and up to two numbers.

    ``sizes``: radius of a cylinder or sphere, half angle of a cone, both radii of a torus.
    """

    kind: str
    place: FloatArray
    axis: FloatArray
    sizes: tuple[float, ...] = ()


_Fitted = tuple[Elementary | None, FloatArray]
"""The surface of one kind that fits best, if there is one, and distances of the points from it."""


def fit_elementary(points: FloatArray, normals: FloatArray, near: float) -> Elementary | None:
    """The first of plane, cylinder, sphere, cone and torus on which all points lie.

    Parameters
    ----------
    points, normals : (n, 3) float64
        Places of the surface and its unit normals there, all to one side.
    near : float
        Greatest distance of a point from the surface.

    Returns
    -------
    Elementary or None
        The axis of a cone leads from its apex into the points.
    """
    center = points.mean(axis=0)
    size = float(np.ptp(points, axis=0).max())
    found = _fit((points - center) / size, normals, near / size) if size > 0.0 else None
    if found is None:
        return None
    sizes = found.sizes if found.kind == "cone" else tuple(size * one for one in found.sizes)
    return found._replace(place=center + size * found.place, sizes=sizes)


def _fit(points: FloatArray, normals: FloatArray, near: float) -> Elementary | None:
    for of_kind in (_plane, _cylinder, _ball, _cone, _torus):
        found, distances = of_kind(points, normals)
        if found is not None and float(np.abs(distances).max()) < near:
            return found
    return None


def _plane(points: FloatArray, normals: FloatArray) -> _Fitted:
    mean = points.mean(axis=0)
    axis = np.linalg.svd(points - mean, full_matrices=False)[2][2]
    return Elementary("plane", mean, axis), (points - mean) @ axis


def _cylinder(points: FloatArray, normals: FloatArray) -> _Fitted:
    axis = np.linalg.svd(normals, full_matrices=False)[2][2]
    across = np.linalg.svd(axis[None])[2][1:].T
    middle, radius = fit_sphere(points @ across)
    place = across @ middle + (points.mean(axis=0) @ axis) * axis
    return Elementary("cylinder", place, axis, (radius,)), np.linalg.norm(points @ across - middle, axis=1) - radius


def _ball(points: FloatArray, normals: FloatArray) -> _Fitted:
    middle, radius = fit_sphere(points)
    found = Elementary("sphere", middle, np.array([0.0, 0.0, 1.0]), (radius,))
    return found, np.linalg.norm(points - middle, axis=1) - radius


def _cone(points: FloatArray, normals: FloatArray) -> _Fitted:
    axis = np.linalg.svd(normals - normals.mean(axis=0), full_matrices=False)[2][2]
    apex = np.linalg.lstsq(normals, np.einsum("ij,ij->i", points, normals), rcond=None)[0]
    axis = -axis if (points.mean(axis=0) - apex) @ axis < 0.0 else axis
    out, along = _from_axis(points, apex, axis)
    half = float(np.arctan2(out.sum(), along.sum()))
    return Elementary("cone", apex, axis, (half,)), out * np.cos(half) - along * np.sin(half)


def fit_axis(points: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray] | None:
    """A place on the axis that normals at points all but meet, and its direction; None where they are all parallel.

    Best for points about the origin, some units apart.
    """
    motion = np.linalg.svd(np.column_stack([np.cross(points, normals), normals]), full_matrices=False)[2][5]
    turning = float(np.linalg.norm(motion[:3]))
    if turning < _HAS_TURN:
        return None
    axis = motion[:3] / turning
    return np.cross(axis, motion[3:] / turning), axis


def _torus(points: FloatArray, normals: FloatArray) -> _Fitted:
    line = fit_axis(points, normals)
    if line is None:
        return None, points
    place, axis = line
    out, along = _from_axis(points, place, axis)
    (major, rise), minor = fit_sphere(np.column_stack([out, along]))
    if major <= minor:  # not a ring
        return None, points
    found = Elementary("torus", place + rise * axis, axis, (major, minor))
    return found, np.hypot(out - major, along - rise) - minor


def _from_axis(points: FloatArray, place: FloatArray, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Distances from an axis and heights along it, from `place` on."""
    along = (points - place) @ axis
    return np.linalg.norm(points - place - along[:, None] * axis, axis=1), along


def fit_sphere(points: FloatArray) -> tuple[FloatArray, float]:
    """Centre and radius of the sphere, or in the plane the circle, through points, by linear least squares."""
    mean = points.mean(axis=0)
    offsets = points - mean
    squares = np.einsum("ij,ij->i", offsets, offsets)
    found = np.linalg.lstsq(np.column_stack([2.0 * offsets, np.ones(len(points))]), squares, rcond=None)[0]
    center = found[:-1]
    return mean + center, float(np.sqrt(max(found[-1] + center @ center, 0.0)))


def regular(normals: FloatArray) -> BoolArray:
    """Rows whose normal has a length that tells a direction: not those at a pole."""
    lengths = np.linalg.norm(normals, axis=1)
    return np.asarray(lengths > 1e-6 * lengths.max(initial=0.0))
