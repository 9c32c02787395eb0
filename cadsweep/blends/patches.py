"""Faces that run smoothly into each other across blends: patches, each as one surface.

Place in the flow: a mesh of the design is carried onto the patches of the model (:mod:`.carrying`).

Method: what is nearest to a point of all members within their borders; parameters are those of the member and, in a
third column, its number. What is outside of all borders is on the border nearest to it.

Not handled: parameters between which one may go straight from one member to another.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from ..arrays import BoolArray, FloatArray, IntArray
from ..brep import Face, Solid, Surface
from ..disjoint import DisjointSets
from .finding import Blend

_SAMPLES = 25
"""Points of every edge in the outline of a member."""
_GRID = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 7)] * 2), axis=-1).reshape(-1, 2)
"""Where a member is looked at to know how far it may reach, as shares of its parameters."""
_WIDER = 0.02
"""Share of its diagonal by which a member's box is wider than what was looked at."""
_NEAR = 12
"""Points of borders whose edges are asked which is nearest: long ones have their points far apart."""
_ON = 1e-9
"""Share of the solid's size within which a point is on a surface: what was put there is found there again."""
_CLOSE = 2e-3
"""Share of an edge's length by which outlines of chords are off the edge at most: who is so near is within the face."""


def find_patches(
    solid: Solid, blends: Collection[Blend], gone: Collection[int], united: Collection[Collection[int]] = ()
) -> IntArray:
    """Patch (n_faces,) of every face: the least face of those that hang together through blends that are `gone`.

    Pieces of one face that was divided are in one patch, and faces that are `united` in the design.
    """
    sets = DisjointSets(range(len(solid.faces)))
    by_key: dict[str, list[int]] = {}
    for face in solid.faces:
        by_key.setdefault(face.key or f"face {face.id}", []).append(face.id)
    around = [(*blend.faces, *(f for side in blend.supports for f in side)) for blend in blends
              if set(blend.faces) <= set(gone)]  # fmt: skip
    for group in (*by_key.values(), *map(list, united), *around):
        for member in group:
            low, high = sorted((sets.find(group[0]), sets.find(member)))
            sets.merge(high, low)
    return np.array([sets.find(face.id) for face in solid.faces], dtype=np.int64)


class PatchSurface:
    """Faces of a solid as one surface: parameters (m, 3) are those of a member and its number."""

    def __init__(self, solid: Solid, members: Sequence[int]) -> None:
        self.solid = solid
        self.members = tuple(members)
        self.surfaces: list[Surface] = [solid.faces[f].surface for f in members]
        self.outlines = [_outline(solid, solid.faces[f]) for f in members]
        boxes = [_box(solid, solid.faces[f], own) for f, own in zip(members, self.outlines, strict=True)]
        self.boxes = np.stack(boxes)

    @property
    def periods(self) -> tuple[float | None, float | None]:
        """None: as a whole it closes nowhere that parameters would tell."""
        return None, None

    @cached_property
    def _border(self) -> tuple[cKDTree, IntArray]:
        """Points of all edges of the members, and which edge each is of."""
        edges = sorted({e for f in self.members for e in self.solid.faces[f].edges})
        at = np.linspace(0.0, 1.0, _SAMPLES)
        points = np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in edges])
        return cKDTree(points), np.repeat(np.array(edges, dtype=np.int64), _SAMPLES)

    def project(self, points: FloatArray) -> FloatArray:
        """Parameters (m, 3) of the nearest points."""
        return self._nearest(points)[0]

    def distance(self, points: FloatArray, *, close: float = np.inf) -> FloatArray:
        """Distances (m,) of `points` (m, 3) from the patch within its borders."""
        return self._nearest(points)[1]

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3) at parameters (m, 3)."""
        found = np.empty((len(uv), 3))
        for k, at in _groups(uv[:, 2]):
            found[at] = self.surfaces[k].evaluate(uv[at, :2])
        return found

    def normals(self, uv: FloatArray) -> FloatArray:
        """Unit normals (m, 3) out of the solid."""
        found = np.empty((len(uv), 3))
        for k, at in _groups(uv[:, 2]):
            found[at] = self.surfaces[k].normals(uv[at, :2])
        return found

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Partial derivatives (m, 3) by both parameters of the member."""
        by_u, by_v = np.empty((len(uv), 3)), np.empty((len(uv), 3))
        for k, at in _groups(uv[:, 2]):
            by_u[at], by_v[at] = self.surfaces[k].derivatives(uv[at, :2])
        return by_u, by_v

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        """Parameters (m, 3) of an edge's points; `edge` is one of the solid's."""
        return self.project(self.solid.edges[edge].curve.evaluate(fractions))

    def face_at(self, points: FloatArray) -> IntArray:
        """The face (m,) of the solid that what is nearest to points (m, 3) is on."""
        return np.array(self.members, dtype=np.int64)[self.project(points)[:, 2].astype(np.int64)]

    def _nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        uv, best = np.zeros((len(points), 3)), np.full(len(points), np.inf)
        over = np.maximum(np.maximum(self.boxes[:, 0] - points[:, None], points[:, None] - self.boxes[:, 1]), 0.0)
        away = np.linalg.norm(over, axis=2)
        order = np.argsort(away, axis=1, kind="stable")
        for turn in range(len(self.members)):
            member = order[:, turn]
            asked = np.flatnonzero(away[np.arange(len(points)), member] < best)
            if not len(asked):
                break
            for k, at in _groups(member[asked]):
                rows = asked[at]
                feet, off = self._feet(k, points[rows])
                better = off < best[rows]
                inside = _inside(feet, self.outlines[k])
                beside = np.flatnonzero(better & ~inside & (off <= _ON * self.solid.size))
                inside[beside] = self._is_close(k, points[rows[beside]])
                own = inside & better
                uv[rows[own], :2], uv[rows[own], 2], best[rows[own]] = feet[own], k, off[own]
        # A wall on the other side is nearer to nothing than a border that is passed by a little.
        outside = np.flatnonzero(best > self._border[0].query(points)[0])
        if len(outside):
            uv[outside], best[outside] = self._on_border(points[outside])
        return uv, best

    def _feet(self, k: int, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        feet = self.surfaces[k].project(points)
        return feet, np.linalg.norm(self.surfaces[k].evaluate(feet) - points, axis=1)

    def _is_close(self, k: int, points: FloatArray) -> BoolArray:
        """Whether points (m, 3) are as close to the border of a member as the chords of its outline are off it."""
        close = np.zeros(len(points), dtype=bool)
        for e in self.solid.faces[self.members[k]].edges if len(points) else ():
            edge = self.solid.edges[e]
            close |= edge.curve.distance(points) <= _CLOSE * edge.length
        return close

    def _on_border(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Parameters (m, 3) and distances (m,) of what is nearest on the borders, or in a gap between two outlines."""
        tree, edges = self._border
        uv, best = np.zeros((len(points), 3)), np.full(len(points), np.inf)
        near = edges[tree.query(points, k=min(_NEAR, len(edges)))[1]].reshape(len(points), -1)
        for e in np.unique(near).tolist():
            edge, at = self.solid.edges[e], np.flatnonzero((near == e).any(axis=1))
            there = edge.curve.nearest(points[at])
            for k in [self.members.index(f) for f in set(edge.faces) if f in self.members]:
                own, off = self._feet(k, points[at])
                beside = np.linalg.norm(self.surfaces[k].evaluate(own) - there, axis=1) > _CLOSE * edge.length
                if beside.any():
                    own[beside] = self.surfaces[k].project(there[beside])
                    off[beside] = np.linalg.norm(points[at][beside] - there[beside], axis=1)
                better = off < best[at]
                rows = at[better]
                uv[rows, :2], uv[rows, 2], best[rows] = own[better], k, off[better]
        return uv, best


def _groups(numbers: npt.NDArray[np.generic]) -> Iterator[tuple[int, IntArray]]:
    for number in np.unique(numbers):
        yield int(number), np.flatnonzero(numbers == number)


def _outline(solid: Solid, face: Face) -> FloatArray:
    """Segments (s, 2, 2) of a face's border in its parameters, the end of each the start of another to the last bit."""
    at = np.linspace(0.0, 1.0, _SAMPLES)
    found = []
    for loop in face.loops:
        uv = [face.surface.edge_uv(e, at)[:: 1 if ahead else -1][:-1] for e, ahead in loop.directed]
        ring = np.concatenate(uv)
        found.append(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1))
    return np.concatenate(found)


def _box(solid: Solid, face: Face, outline: FloatArray) -> FloatArray:
    """Corners (2, 3) of a box that a face is in."""
    low, high = outline.min(axis=(0, 1)), outline.max(axis=(0, 1))
    inside = low + _GRID * (high - low)
    inside = inside[_inside(inside, outline)]
    points = np.concatenate([face.surface.evaluate(inside), face.surface.evaluate(outline[:, 0])])
    wider = _WIDER * np.linalg.norm(np.ptp(points, axis=0))
    return np.stack([points.min(axis=0) - wider, points.max(axis=0) + wider])


def _inside(places: FloatArray, outline: FloatArray) -> BoolArray:
    """Whether places (m, 2) lie inside an outline of segments (n, 2, 2): crossings of a ray, counted."""
    (ax, ay), (bx, by) = outline[:, 0].T, outline[:, 1].T
    x, y = places[:, :1], places[:, 1:]
    spans = (ay > y) != (by > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = x < ax + (y - ay) / (by - ay) * (bx - ax)
    inside: BoolArray = (spans & right).sum(axis=1) % 2 == 1
    return inside


__all__ = ["PatchSurface", "find_patches"]
