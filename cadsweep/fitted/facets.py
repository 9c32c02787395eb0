"""Facets of a solid's faces, and the nearest of them to points: what stands for trimmed faces.

Facets say which face is nearest, and about where; where something is on a face, the face itself says.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import FloatArray, IntArray

_LOOKED_AT = 6
"""Samples near a point whose facets are looked at: six share a node in most triangulations."""


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
    """The nearest of some facets to points, by samples of these and their exact distances."""

    def __init__(self, facets: Facets, apart: float) -> None:
        self.corners = facets.points[facets.triangles]
        self.faces = facets.faces
        normals = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        # Triangles without an area are lines of a seam or a pole: others lie around them.
        good = lengths > 1e-12 * max(float(lengths.max(initial=0.0)), 1e-300)
        self.corners, self.faces = self.corners[good], self.faces[good]
        self.normals = normals[good] / lengths[good, None]
        samples, self.owners = sampled(self.corners, apart)
        self.tree = cKDTree(samples)

    def __call__(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Distances (m,) of points (m, 3), and the nearest triangle (m,) of each."""
        k = min(_LOOKED_AT, len(self.owners))
        seen = self.owners[self.tree.query(points, k=list(range(1, k + 1)))[1]]
        away = np.stack([_distances(points, self.corners[seen[:, j]]) for j in range(k)], axis=1)
        best = np.argmin(away, axis=1)
        rows = np.arange(len(points))
        return away[rows, best], seen[rows, best]


def _distances(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Distances (m,) of points (m, 3) from triangles (m, 3, 3)."""
    first, along, across = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    off = points - first
    a, b, c = (np.einsum("md,md->m", x, y) for x, y in ((along, along), (along, across), (across, across)))
    d, e = np.einsum("md,md->m", off, along), np.einsum("md,md->m", off, across)
    area = np.maximum(a * c - b * b, 1e-300)
    u, v = (c * d - b * e) / area, (a * e - b * d) / area
    inside = (u >= 0) & (v >= 0) & (u + v <= 1)
    u, v = np.where(inside, (u, v), 0.0)  # of needles they overflow
    flat = np.linalg.norm(off - u[:, None] * along - v[:, None] * across, axis=1)
    sides = [_off_segment(points, corners[:, j], corners[:, j - 2]) for j in range(3)]
    return np.where(inside, flat, np.min(sides, axis=0))


def _off_segment(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    step = end - start
    share = np.einsum("md,md->m", points - start, step) / np.maximum(np.einsum("md,md->m", step, step), 1e-300)
    return np.asarray(np.linalg.norm(points - start - np.clip(share, 0.0, 1.0)[:, None] * step, axis=1))
