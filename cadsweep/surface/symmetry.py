"""Mirrors and turns of the nodes of an outline in a plane, and the wedge of which the whole is made.

Place in the flow: :mod:`.symmetric` meshes the wedge and copies it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..polygons import next_corners

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
    """A part of the plane between two rays from a centre that mirrors, or turns alone, copy all around.

    Attributes
    ----------
    centre : (2,) float64
    start : float
        Angle of the first ray.
    n : int
        Turns that carry the outline to itself, the whole one among them.
    has_mirrors : bool
        Whether each ray is a mirror: the angle between them is pi / n then, and 2 pi / n else.
    """

    centre: FloatArray
    start: float
    n: int
    has_mirrors: bool = True

    @property
    def angle(self) -> float:
        """Between the two rays."""
        return (1.0 if self.has_mirrors else 2.0) * np.pi / self.n

    def elements(self) -> list[FloatArray]:
        """All rotations and reflections about the centre, (2, 2) matrices, the identity first."""
        turns = [_rotation(2.0 * np.pi * k / self.n) for k in range(self.n)]
        if not self.has_mirrors:
            return turns
        mirror = _reflection(self.start)
        return [*turns, *(turn @ mirror for turn in turns)]

    def carry(self, element: FloatArray, places: FloatArray) -> FloatArray:
        """Places (m, 2) under one of the elements."""
        return np.asarray(self.centre + (places - self.centre) @ element.T)

    def polar(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angles from the first ray, in [0, 2 pi) but for rounding, and distances from the centre."""
        off = places - self.centre
        angles = np.mod(np.arctan2(off[:, 1], off[:, 0]) - self.start + 1e-9, 2.0 * np.pi) - 1e-9
        return angles, np.linalg.norm(off, axis=1)


def find_wedges(loops: Sequence[FloatArray], *, between: bool = False) -> list[Wedge]:
    """Wedges between mirrors of an outline's nodes that meet it in nodes only (or `between` them), smallest first."""
    found = _Nodes.of(loops)
    if found is None:
        return []
    good = []
    for angle in np.unique(np.mod((found.angles + found.angles[0]) / 2.0, np.pi).round(12)):
        image = found.image(_reflection(angle))
        if image is None:
            continue
        # Segments go to segments, run backwards; a segment that goes to itself has its middle on the mirror.
        following = found.following
        if (following[image[following]] == image).all() and (between or (image != following).all()):
            good.append(float(angle))
    wedges, mirrors = [], np.array(good)
    for n in range(len(good), 0, -1):
        beside = np.mod((mirrors + np.pi / n)[:, None] - mirrors + _TURN, np.pi)
        starts = np.flatnonzero((beside < 2.0 * _TURN).any(axis=1))
        wedges += [Wedge(centre=found.centre, start=good[starts[0]], n=n)] if len(starts) else []
    return wedges


def find_turns(loops: Sequence[FloatArray]) -> Wedge | None:
    """The wedge that turns copy to all of an outline's nodes, the smallest one; None where only the whole turn does."""
    found = _Nodes.of(loops)
    for n in range(0 if found is None else len(found.angles), 1, -1):
        assert found is not None
        image = found.image(_rotation(2.0 * np.pi / n))
        if image is not None and (image[found.following] == found.following[image]).all():
            return Wedge(centre=found.centre, start=0.0, n=n, has_mirrors=False)
    return None


@dataclass(frozen=True, kw_only=True, eq=False)
class _Nodes:
    """Nodes of an outline about their centre, the angles of the fewest at one distance, and the node after each."""

    off: FloatArray
    centre: FloatArray
    near: float
    angles: FloatArray
    following: IntArray
    tree: scipy.spatial.cKDTree

    @staticmethod
    def of(loops: Sequence[FloatArray]) -> _Nodes | None:
        """None where a node is in the centre, or too many are at one distance."""
        points = np.concatenate(loops)
        size = float(np.max(np.ptp(points, axis=0)))
        centre = points.mean(axis=0)
        off = points - centre
        radius = np.linalg.norm(off, axis=1)
        if radius.min() < _AT_CENTRE * size:
            return None
        classes = np.unique(np.round(radius / (_SAME * size * 100.0)), return_inverse=True)[1].ravel()
        group = np.flatnonzero(classes == int(np.argmin(np.bincount(classes))))
        if len(group) > _MOST_MIRRORS:
            return None
        return _Nodes(
            off=off,
            centre=centre,
            near=_SAME * size,
            angles=np.arctan2(off[group, 1], off[group, 0]),
            following=next_corners(loops),
            tree=scipy.spatial.cKDTree(off),
        )

    def image(self, matrix: FloatArray) -> IntArray | None:
        """The node that each is carried to; None where one is carried to none."""
        far, image = self.tree.query(self.off @ matrix.T)
        return np.asarray(image, dtype=np.int64) if far.max() <= self.near else None


def _reflection(angle: float) -> FloatArray:
    c, s = np.cos(2.0 * angle), np.sin(2.0 * angle)
    return np.array([[c, s], [s, -c]])


def _rotation(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
