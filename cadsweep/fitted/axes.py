"""The axes of the grid: three directions at right angles that most of the part runs along, whichever way it is turned.

Plane faces have the direction that they look along; round and extruded ones that which none of them looks along.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from .facets import Facets

_FLAT = 1e-5
"""Share of a face's normals, squared, that may be off its direction, or along it."""
_SAME = 1e-3
"""Cosine, or sine, up to which two directions are at right angles, or one."""
_CLEARLY = 1.5
"""How much of the part has to run along other axes, over what runs along the model's, for them to be taken."""


def choose_axes(facets: Facets) -> FloatArray:
    """Axes of a grid, the rows of (3, 3), right-handed; those of the model where most runs along them."""
    directions, areas = _directions(facets)
    if not len(areas):
        return np.eye(3)
    first = directions[np.argmax(areas)]
    across = np.abs(directions @ first) < _SAME
    beside = directions[across][np.argmax(areas[across])] if across.any() else np.eye(3)[np.argmin(np.abs(first))]
    second = beside - (beside @ first) * first
    second /= np.linalg.norm(second)
    found = np.stack([first, second, np.cross(first, second)])

    def along(axes: FloatArray) -> float:
        return float(areas[(np.abs(directions @ axes.T) > np.sqrt(1.0 - _SAME**2)).any(axis=1)].sum())

    return found if along(found) > _CLEARLY * along(np.eye(3)) else np.eye(3)


def _directions(facets: Facets) -> tuple[FloatArray, FloatArray]:
    """Directions (d, 3) of plane, round and extruded faces, each once, and the area (d,) of the faces that have it."""
    corners = facets.points[facets.triangles]
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    own = np.linalg.norm(normals, axis=1)
    shares = normals[:, :, None] * normals[:, None, :] / np.maximum(own, 1e-300)[:, None, None]
    tensors = np.zeros((int(facets.faces.max()) + 1, 3, 3))
    np.add.at(tensors, facets.faces, shares)
    values, vectors = np.linalg.eigh(tensors)
    total = np.maximum(values.sum(axis=1), 1e-300)
    flat, straight = values[:, 1] < _FLAT * total, values[:, 0] < _FLAT * total
    ways = np.where(flat[:, None], vectors[:, :, 2], vectors[:, :, 0])
    directions, areas = [], []
    left = flat | straight
    for face in np.argsort(-total, kind="stable"):
        if left[face]:
            same = left & (np.abs(ways @ ways[face]) > np.sqrt(1.0 - _SAME**2))
            directions.append(ways[face])
            areas.append(total[same].sum())
            left &= ~same
    return np.array(directions).reshape(-1, 3), np.array(areas)
