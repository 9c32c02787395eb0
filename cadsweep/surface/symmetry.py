"""Mirrors of the nodes of an outline in a plane, and the wedge between two of them of which the whole is made.

Place in the flow: :mod:`.symmetric` meshes the wedge and copies it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray

_SAME = 1e-9
"""Distance, in sizes of the outline, up to which a node lies where another one is carried."""
_MOST_MIRRORS = 64
"""Nodes at one distance from the middle beyond which mirrors are not looked for: every pair of them may be one."""
_AT_CENTRE = 1e-6
"""Distance from the centre, in sizes of the outline, below which a node is in it."""
_TURN = 1e-7
"""Angle up to which two mirrors are one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Wedge:
    """A part of the plane between two rays from a centre that mirrors copy all around.

    Attributes
    ----------
    centre : (2,) float64
    start : float
        Angle of the first ray.
    n : int
        Half as many copies fill the plane: the angle between the rays is pi / n.
    """

    centre: FloatArray
    start: float
    n: int

    @property
    def angle(self) -> float:
        """Between the two rays."""
        return np.pi / self.n

    def elements(self) -> list[FloatArray]:
        """All rotations and reflections about the centre, (2, 2) matrices, the identity first."""
        mirror = _reflection(self.start)
        turns = [_rotation(2.0 * self.angle * k) for k in range(self.n)]
        return [*turns, *(turn @ mirror for turn in turns)]

    def carry(self, element: FloatArray, places: FloatArray) -> FloatArray:
        """Places (m, 2) under one of the elements."""
        return np.asarray(self.centre + (places - self.centre) @ element.T)

    def polar(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angles from the first ray, in [0, 2 pi) but for rounding, and distances from the centre."""
        off = places - self.centre
        angles = np.mod(np.arctan2(off[:, 1], off[:, 0]) - self.start + 1e-9, 2.0 * np.pi) - 1e-9
        return angles, np.linalg.norm(off, axis=1)


def find_wedges(loops: Sequence[FloatArray]) -> list[Wedge]:
    """Wedges between mirrors of an outline's nodes that meet it in nodes only, the smallest first."""
    points = np.concatenate(loops)
    size = float(np.max(np.ptp(points, axis=0)))
    centre = points.mean(axis=0)
    off = points - centre
    radius = np.linalg.norm(off, axis=1)
    if radius.min() < _AT_CENTRE * size:
        return []
    classes = np.unique(np.round(radius / (_SAME * size * 100.0)), return_inverse=True)[1].ravel()
    sizes = np.bincount(classes)
    group = np.flatnonzero(classes == int(np.argmin(sizes)))
    if len(group) > _MOST_MIRRORS:
        return []
    angles = np.arctan2(off[group, 1], off[group, 0])
    following = np.concatenate([np.roll(ids, -1) for ids in _ids(loops)])
    tree = scipy.spatial.cKDTree(off)
    good = []
    for angle in np.unique(np.mod((angles + angles[0]) / 2.0, np.pi).round(12)):
        far, image = tree.query(off @ _reflection(angle).T)
        # Segments go to segments, run backwards; a segment that goes to itself has its middle on the mirror.
        if far.max() <= _SAME * size and (following[image[following]] == image).all() and (image != following).all():
            good.append(float(angle))
    wedges = []
    for n in range(len(good), 0, -1):
        beside = [np.mod(start + np.pi / n - np.array(good) + _TURN, np.pi) for start in good]
        starts = [start for start, others in zip(good, beside, strict=True) if (others < 2.0 * _TURN).any()]
        wedges += [Wedge(centre=centre, start=starts[0], n=n)] if starts else []
    return wedges


def _ids(loops: Sequence[FloatArray]) -> list[IntArray]:
    ends = np.cumsum([0, *(len(loop) for loop in loops)])
    return [np.arange(a, b) for a, b in pairwise(ends.tolist())]


def _reflection(angle: float) -> FloatArray:
    c, s = np.cos(2.0 * angle), np.sin(2.0 * angle)
    return np.array([[c, s], [s, -c]])


def _rotation(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
