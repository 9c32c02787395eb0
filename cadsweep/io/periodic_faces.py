"""Boundaries whose nodes answer each other: the motion between them, and their quads in one order."""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError


def rigid_motion(points: FloatArray, images: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotation (3, 3) and shift (3,) that carry points (p, 3) to their images best (Kabsch)."""
    centers = points.mean(axis=0), images.mean(axis=0)
    U, _, Vt = np.linalg.svd((points - centers[0]).T @ (images - centers[1]))
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ Vt))])
    matrix = (U @ sign @ Vt).T
    return matrix, centers[1] - matrix @ centers[0]


def answering_quads(first: IntArray, second: IntArray, pairs: IntArray) -> tuple[IntArray, IntArray]:
    """Which quad of the second answers each of the first (q,), and these (q, 4), from the image of its first node on.

    Raises
    ------
    InputError
        A quad has no partner.
    """
    image = np.full(int(max(first.max(), pairs.max())) + 1, -1, dtype=np.int64)
    image[pairs[:, 0]] = pairs[:, 1]
    wanted = image[first]
    known = {tuple(sorted(quad)): j for j, quad in enumerate(second.tolist())}
    order = np.array([known.get(tuple(sorted(quad)), -1) for quad in wanted.tolist()], dtype=np.int64)
    if len(first) != len(second) or (order < 0).any():
        raise InputError("the quads of two periodic boundaries do not answer each other, though their nodes do")
    quads = second[order]
    start = np.argmax(quads == wanted[:, :1], axis=1)
    return order, np.take_along_axis(quads, (start[:, None] + np.arange(4)) % 4, axis=1)
