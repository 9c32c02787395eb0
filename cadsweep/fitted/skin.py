"""Small questions about the boundary of a mesh of hexahedra."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray


def sides_around(quads: IntArray) -> IntArray:
    """Sides (4 q, 2) of quads (q, 4), in the order in which these are run around."""
    return np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)


def keys_of(sides: IntArray, n: int) -> IntArray:
    """A number for each directed side (s, 2) between n nodes."""
    return sides[:, 0] * n + sides[:, 1]


def outward_at(points: FloatArray, quads: IntArray) -> FloatArray:
    """Unit normals (n, 3) at the nodes of the quads, zero where they cancel."""
    corners = points[quads]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    total = np.zeros_like(points)
    np.add.at(total, quads.ravel(), np.repeat(normals, 4, axis=0))
    lengths = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(lengths > 1e-9, total / np.maximum(lengths, 1e-9), 0.0)
