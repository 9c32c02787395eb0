"""Normals of the faces of a solid: sampled on their edges and inside them, once, and only of faces that are asked for.

Place in the flow: foundation of :mod:`.sides`.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Solid
from ..polygons import is_inside

_ALONG_EDGES = np.linspace(0.0, 1.0, 9)
_GRID = 9
_FITS = 1e-6
"""Cosine, or its distance from 1, up to which a face counts as along a direction, or as square across it."""
_SAME = 1e-9
"""1 - cosine of directions that are the same."""


class Normals:
    """Outward normals of the faces of a solid.

    Attributes
    ----------
    solid : Solid
    axes : dict of int to (3,) float64
        Of the faces that are straight: unit vectors along which they run, where that is known without their normals.
    """

    def __init__(self, solid: Solid) -> None:
        self.solid = solid
        self.axes = {face.id: axis for face in solid.faces if (axis := self._straight(face)) is not None}
        self._borders: dict[int, dict[int, FloatArray]] = {}
        self._edges: dict[int, dict[int, FloatArray]] = {}
        self._inside: dict[int, FloatArray] = {}
        self._all: dict[int, FloatArray] = {}

    def of(self, face: Face) -> FloatArray:
        """Normals (m, 3) at places all over a face; one of a plane."""
        if face.kind == "plane":
            return face.normal[None]
        if face.id not in self._all:
            self._all[face.id] = np.concatenate([*self.on_edges(face).values(), self.inside(face)])
        return self._all[face.id]

    def on_edges(self, face: Face) -> dict[int, FloatArray]:
        """Normals (m, 3) of a face along each of its edges, from start to end."""
        if face.id not in self._edges:
            uv = self._border(face)
            found = face.surface.normals(np.concatenate(list(uv.values()))).reshape(len(uv), len(_ALONG_EDGES), 3)
            self._edges[face.id] = dict(zip(uv, found, strict=True))
        return self._edges[face.id]

    def _border(self, face: Face) -> dict[int, FloatArray]:
        """Parameters (m, 2) along each of a face's edges, from start to end."""
        if face.id not in self._borders:
            self._borders[face.id] = {e: face.surface.edge_uv(e, _ALONG_EDGES) for e in dict.fromkeys(face.edges)}
        return self._borders[face.id]

    def inside(self, face: Face) -> FloatArray:
        """Normals (m, 3) at places of a grid that lie inside of a face."""
        if face.id not in self._inside:
            self._inside[face.id] = face.surface.normals(_inner_places(face, self._border(face)))
        return self._inside[face.id]

    def _straight(self, face: Face) -> FloatArray | None:
        """Axis of a cylinder or an extrusion with a straight edge: all of those are parallel to it."""
        if face.kind not in ("cylinder", "extrusion"):
            return None
        for e in face.edges:
            edge = self.solid.edges[e]
            if edge.kind == "line":
                return np.asarray(edge.tangents[0] / np.linalg.norm(edge.tangents[0]))
        return None


def count_fitting(normals: Normals, direction: FloatArray) -> int:
    """How many of the plane and straight faces lie along a direction or square across it: how promising it is."""
    planes = np.array([face.normal for face in normals.solid.faces if face.kind == "plane"]).reshape(-1, 3)
    cosines = np.abs(planes @ direction)
    along = np.array(list(normals.axes.values())).reshape(-1, 3) @ direction
    return int(((cosines <= _FITS) | (cosines >= 1.0 - _FITS)).sum() + (np.abs(along) >= 1.0 - _FITS).sum())


def _inner_places(face: Face, border: Mapping[int, FloatArray]) -> FloatArray:
    """Parameters (m, 2) all over a face with those of its border."""
    loops = [
        np.concatenate([border[e][:: 1 if forward else -1] for e, forward in loop.directed]) for loop in face.loops
    ]
    low, high = np.concatenate(loops).min(axis=0), np.concatenate(loops).max(axis=0)
    steps = (np.arange(_GRID) + 0.5) / _GRID
    grid = low + np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2) * (high - low)
    return np.asarray(grid[is_inside(loops, grid)])


def find_directions(normals: Normals) -> list[FloatArray]:
    """Directions worth a look: normals of planes, axes of cylinders and cones, straight edges; each once."""
    solid = normals.solid
    found: list[FloatArray] = []
    for face in solid.faces:
        if face.kind == "plane":
            found.append(face.normal)
        elif face.id in normals.axes:
            found.append(normals.axes[face.id])
        elif face.kind in ("cylinder", "cone", "extrusion"):
            own = normals.of(face)
            # The normals of all three lie on a circle about the axis.
            _, spread, axes = np.linalg.svd(own - own.mean(axis=0), full_matrices=False)
            if spread[1] > 1e-6 and spread[2] < 1e-6 * spread[0]:
                found.append(axes[2])
    found += [edge.tangents[0] for edge in solid.edges if edge.kind == "line"]
    kept: list[FloatArray] = []
    for direction in found:
        unit = direction / np.linalg.norm(direction)
        if not kept or np.abs(np.array(kept) @ unit).max() < 1.0 - _SAME:
            # Upwards along its greatest coordinate, so that a part and its mirror image are seen alike.
            kept.append(unit * np.sign(unit[np.argmax(np.abs(unit).round(6))]))
    return kept
