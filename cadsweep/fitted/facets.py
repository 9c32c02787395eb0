"""Facets of a solid's faces, and the nearest of them to points: what stands for trimmed faces.

Facets say which face is nearest, and about where; where something is on a face, the face itself says.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray
from .facet_kernels import box_triangles, nearest_triangles


class Facets(NamedTuple):
    """Triangles of all faces: points (n, 3), triangles (t, 3) counter-clockwise from outside, the face (t,) of each."""

    points: FloatArray
    triangles: IntArray
    faces: IntArray

    def along(self, axes: FloatArray) -> Facets:
        """Those in coordinates along axes, the rows of (3, 3)."""
        return Facets(self.points @ axes.T, self.triangles, self.faces)

    def of(self, faces: IntArray) -> Facets:
        """Those of some faces."""
        kept = np.isin(self.faces, faces)
        return Facets(self.points, self.triangles[kept], self.faces[kept])


def sampled(corners: FloatArray, apart: float) -> tuple[FloatArray, IntArray]:
    """Points (s, 3) on triangles (t, 3, 3), about `apart` from each other, and the triangle (s,) of each."""
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    counts = np.clip(np.ceil(longest / apart), 1, 60).astype(np.int64)
    points, owners = [np.empty((0, 3))], [np.empty(0, dtype=np.int64)]
    for n in np.unique(counts).tolist():
        own = np.flatnonzero(counts == n)
        i, j = np.nonzero(np.add.outer(np.arange(n + 1), np.arange(n + 1)) <= n)
        weights = np.stack([n - i - j, i, j], axis=1) / n
        points.append(np.einsum("wc,tcd->twd", weights, corners[own]).reshape(-1, 3))
        owners.append(np.repeat(own, len(weights)))
    return np.concatenate(points), np.concatenate(owners)


class Nearest:
    """The nearest of some facets to points."""

    def __init__(self, facets: Facets) -> None:
        self.corners = facets.points[facets.triangles]
        self.faces = facets.faces
        normals = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        # Triangles without an area are lines of a seam or a pole: others lie around them.
        good = lengths > 1e-12 * max(float(lengths.max(initial=0.0)), 1e-300)
        self.corners, self.faces = np.ascontiguousarray(self.corners[good], dtype=np.float64), self.faces[good]
        self.normals = normals[good] / lengths[good, None]
        self.order, self.boxes = box_triangles(self.corners)

    def __call__(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Distances (m,) of points (m, 3), and the nearest triangle (m,) of each."""
        return nearest_triangles(np.ascontiguousarray(points, dtype=np.float64), self.corners, self.order, self.boxes)
