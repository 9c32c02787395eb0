"""Turns and mirrors of a plane cap's outline, and what they ask of the counts of its edges.

Place in the flow: :mod:`.patterns` asks for segments around circles, :mod:`.loops` and :mod:`.equations` for edges of
equal and of even counts. With these the nodes of a symmetric outline are symmetric, and its mirrors meet it in nodes.

Method: every turn or mirror carries one of the fewest pieces that are alike (of one kind and length, equally far from
the middle) to another one of them; each such map is tried on all pieces. A circle of two halves is one piece, at its
centre: its nodes go to nodes where their number is a multiple of what the angles between its vertices, and those that
they are carried to, say.

Not handled: curved faces, circles that are divided in unequal pieces, caps of several faces as one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import lcm, pi
from typing import TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
import scipy

from ..arrays import BoolArray, FloatArray, IntArray, cross_product
from ..brep import Face, Solid, quarter_turns

_SAME = 1e-6
"""Distance, in sizes of the part, up to which places and lengths are alike."""
_MOST_ALIKE = 64
"""Pieces that are alike beyond which no symmetry is looked for: each may be the image of the first."""
_FEW = 100
"""Places up to which all distances are taken: SciPy's tree takes a fifth of a second to import, once."""
_MOST_PIECES = 2000
"""Edges and circles of a face beyond which no symmetry is looked for."""
_FINEST = 64
"""Greatest part of a whole turn that nodes of a circle can be asked to meet: a 64th."""
_TURN = 1e-6
"""Part of a whole turn by which angles may be off."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CircleLoop:
    """A loop of two halves of a circle: its edges, its middle, and the angle of one of its vertices, in the plane."""

    edges: tuple[int, ...]
    centre: FloatArray
    phase: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """A turn about the middle of an outline by `angle`, or the mirror at the line of that angle.

    `image`: which piece each one is carried to, the circles after the other edges.
    """

    angle: float
    is_mirror: bool
    image: IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Symmetry:
    """The turns and mirrors of an outline, the identity left out.

    Attributes
    ----------
    edges : tuple of int
        Edges that are pieces by themselves.
    circles : tuple of CircleLoop
    motions : tuple of Motion
    is_lattice : bool
        Whether the outer loop has right and re-entrant corners alone, so that holes take rectangles of a lattice.
    """

    edges: tuple[int, ...]
    circles: tuple[CircleLoop, ...]
    motions: tuple[Motion, ...]
    is_lattice: bool

    def orbits(self) -> list[list[int]]:
        """Edges that motions carry to each other, halves of circles among them; those of circles last."""
        pieces = [[e] for e in self.edges] + [list(circle.edges) for circle in self.circles]
        label, least = None, np.arange(len(pieces))
        while label is None or (least < label).any():
            label = least
            least = np.min([label, *(label[motion.image] for motion in self.motions)], axis=0)
        found: dict[int, list[int]] = {}
        for j, own in zip(label.tolist(), pieces, strict=True):
            found.setdefault(j, []).extend(own)
        return list(found.values())

    def even_sets(self) -> list[list[int]]:
        """Edges whose counts together must be even, so that mirrors meet nodes, and each turn's part is even."""
        mirrors = [motion.image for motion in self.motions if motion.is_mirror]
        if mirrors:
            return [[e] for j, e in enumerate(self.edges) if any(image[j] == j for image in mirrors)]
        own = set(self.edges)
        return [[orbit[0] for orbit in self.orbits() if orbit[0] in own]]

    def multiples(self, motions: Sequence[Motion], *, met: bool) -> dict[int, int] | None:
        """Of every edge of a circle, what the segments of the whole circle must be a multiple of.

        None where no number does. `met`: mirrors meet the circles about them in nodes, not between two.
        """
        key = (frozenset(map(id, motions)), met)
        if key not in self._known_multiples:
            self._known_multiples[key] = self._find_multiples(motions, met=met)
        return self._known_multiples[key]

    @cached_property
    def _known_multiples(self) -> dict[tuple[frozenset[int], bool], dict[int, int] | None]:
        """By the motions, which are this symmetry's own: counts are assigned several times."""
        return {}

    def _find_multiples(self, motions: Sequence[Motion], *, met: bool) -> dict[int, int] | None:
        first, n = len(self.edges), len(self.circles)
        found = [2] * n
        phases = np.array([circle.phase for circle in self.circles])
        for motion in motions:
            images = motion.image[first:] - first
            parts = _denominators(_carried_off(motion, phases, phases[images], met & (images == np.arange(n))))
            if (parts == 0).any():
                return None
            found = [lcm(count, part) for count, part in zip(found, parts.tolist(), strict=True)]
        mirrors = [motion.image for motion in motions if motion.is_mirror]
        if not mirrors:  # each turn's part of a circle about the middle is even
            turned = [all(motion.image[first + j] == first + j for motion in motions) for j in range(n)]
            found = [
                lcm(count, 2 * len(motions) + 2) if own else count for count, own in zip(found, turned, strict=True)
            ]
        if self.is_lattice:
            # The middle of each side of its square is a node.
            middles = [j for j in range(n) if sum(image[first + j] == first + j for image in mirrors) > 1]
            found = [lcm(count, 8) if j in middles else count for j, count in enumerate(found)]
        for _ in range(2):  # circles that are carried to each other have equal numbers
            for motion in motions:
                images = motion.image[first:] - first
                found = [lcm(count, found[k]) for count, k in zip(found, images.tolist(), strict=True)]
        return {e: count for circle, count in zip(self.circles, found, strict=True) for e in circle.edges}

    def subgroups(self) -> list[tuple[Motion, ...]]:
        """All motions, then fewer and fewer of them that are a group by themselves."""
        turns = [motion for motion in self.motions if not motion.is_mirror]
        mirrors = [motion for motion in self.motions if motion.is_mirror]
        n = len(turns) + 1
        groups: list[tuple[Motion, ...]] = []
        for d in sorted((d for d in range(1, n + 1) if n % d == 0), reverse=True):
            own = [t for t in turns if _is_whole(t.angle * d / (2.0 * pi))]
            seen: set[int] = set()
            for mirror in mirrors:
                family = [m for m in mirrors if _is_whole((m.angle - mirror.angle) * d / pi)]
                if id(family[0]) not in seen:
                    seen.add(id(family[0]))
                    groups.append((*own, *family))
            if own:
                groups.append(tuple(own))
        return groups


def _carried_off(motion: Motion, phases: FloatArray, there: FloatArray, met: BoolArray) -> FloatArray:
    """Angles between vertices of circles that a motion carries, and those of the circles there, or (`met`) its axis."""
    if not motion.is_mirror:
        return phases + motion.angle - there
    return np.where(met, motion.angle - phases, 2.0 * motion.angle - phases - there)


def _denominators(angles: FloatArray) -> IntArray:
    """The least number of parts of a whole turn that each angle is a multiple of; 0 where none up to `_FINEST` is."""
    shares = (angles / (2.0 * pi))[:, None]
    parts = np.arange(1, _FINEST + 1)
    fits = np.abs(shares - np.round(shares * parts) / parts) <= _TURN
    return np.where(fits.any(axis=1), 1 + np.argmax(fits, axis=1), 0)


def _is_whole(number: float) -> bool:
    return abs(number - round(number)) < _TURN * _FINEST


_known: WeakKeyDictionary[Solid, dict[int, Symmetry | None]] = WeakKeyDictionary()


def find_symmetry(solid: Solid, face: Face) -> Symmetry | None:
    """The symmetry of a face's outline; None where it has none, is not plane, or a pattern of concentric circles."""
    known = _known.setdefault(solid, {})  # counts are assigned several times, and several equations ask for it
    if face.id not in known:
        known[face.id] = _find_symmetry(solid, face)
    return known[face.id]


def _find_symmetry(solid: Solid, face: Face) -> Symmetry | None:
    if face.kind != "plane":
        return None
    frame = _frame(face.normal)
    near = _SAME * solid.size
    vertices = solid.vertices @ frame.T
    edges: list[int] = []
    circles: list[CircleLoop] = []
    for loop in face.loops:
        own = _circle(solid, loop.edges, frame, vertices, near)
        if own is None:
            edges += loop.edges
        else:
            circles.append(own)
    if len(edges) + len(circles) > _MOST_PIECES or len(set(edges)) < len(edges):
        return None
    middles = [frame @ solid.edges[e].midpoint for e in edges]
    ends = [vertices[[solid.edges[e].start, solid.edges[e].end]] for e in edges]
    lengths = [solid.edges[e].length for e in edges]
    around = [sum(solid.edges[e].length for e in circle.edges) for circle in circles]
    places = np.array([*middles, *(circle.centre for circle in circles)]).reshape(-1, 2)
    weights = np.array([*lengths, *around])
    # A curve's middle of mass is not at hand; its ends and its middle are carried with it, too.
    masses = [(2.0 * middle + end.sum(axis=0)) / 4.0 for middle, end in zip(middles, ends, strict=True)]
    centre = weights @ np.array([*masses, *(circle.centre for circle in circles)]).reshape(-1, 2) / weights.sum()
    kinds = np.array([0] * len(edges) + [1] * len(circles))
    outline = _Pieces(
        places=places - centre,
        ends=np.array(ends).reshape(-1, 2, 2) - centre,
        keys=np.stack([kinds, weights], axis=1),
        near=near,
    )
    motions = tuple(outline.motions())
    if not motions:
        return None
    lattice = quarter_turns(face.loops[0].angles)
    return Symmetry(
        edges=tuple(edges),
        circles=tuple(circles),
        motions=motions,
        is_lattice=lattice is not None and sum(lattice) == 4,
    )


def needs_even_sides(face: Face, symmetry: Symmetry) -> bool:
    """Whether counts must be even for the sake of symmetry: not where a grid or a lattice fills the whole."""
    return len(face.loops) > 1 or not (symmetry.is_lattice or len(face.loops[0].edges) == 4)


def symmetric_pairs(symmetry: Symmetry, wanted: Mapping[int, float], same: float) -> list[tuple[list[int], list[int]]]:
    """Pairs of edges that are alike by symmetry, of those that want equal counts but for rounding (`same`)."""
    pairs = [pair for orbit in symmetry.orbits() for pair in pairwise(orbit)]
    return [([a], [b]) for a, b in pairs if abs(wanted[a] - wanted[b]) < same * wanted[b]]


def _frame(normal: FloatArray) -> FloatArray:
    """Two axes (2, 3) of a plane."""
    x = cross_product(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    x /= np.linalg.norm(x)
    return np.array([x, cross_product(normal, x)])


def _circle(
    solid: Solid, loop: Sequence[int], frame: FloatArray, vertices: FloatArray, near: float
) -> CircleLoop | None:
    edges = [solid.edges[e] for e in loop]
    if len(edges) != 2 or any(edge.kind != "circle" for edge in edges):
        return None
    if abs(edges[0].length - edges[1].length) > near:
        return None
    centre = frame @ (edges[0].midpoint + edges[1].midpoint) / 2.0
    x, y = vertices[edges[0].start] - centre
    if abs(np.hypot(x, y) * pi - edges[0].length) > near:
        return None
    return CircleLoop(edges=tuple(loop), centre=centre, phase=float(np.arctan2(y, x)))


class _Few:
    """What is asked of a tree, for few places (n, 2)."""

    def __init__(self, places: FloatArray) -> None:
        self.places = places

    def query(self, points: FloatArray) -> tuple[FloatArray, IntArray]:
        """Distance to the nearest place, and which it is, for each point."""
        away = self._away(points)
        nearest = away.argmin(axis=1)
        return away[np.arange(len(points)), nearest], nearest

    def query_ball_point(self, points: FloatArray, r: float) -> list[list[int]]:
        """All places within a radius of each point."""
        return [np.flatnonzero(row <= r).tolist() for row in self._away(points)]

    def _away(self, points: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.norm(points[:, None] - self.places, axis=2))


_Tree: TypeAlias = "_Few | scipy.spatial.cKDTree"


@dataclass(frozen=True, kw_only=True, eq=False)
class _Pieces:
    """Pieces of an outline about its middle: places (n, 2), ends (m, 2, 2) of the first m, what is alike (n, 2)."""

    places: FloatArray
    ends: FloatArray
    keys: FloatArray
    near: float

    def motions(self) -> list[Motion]:
        """All turns and mirrors but the identity."""
        away = np.linalg.norm(self.places, axis=1)
        group = self._fewest(away)
        if group is None:
            return []
        angles = np.arctan2(self.places[group, 1], self.places[group, 0])
        tree = _Few(self.places) if len(self.places) <= _FEW else scipy.spatial.cKDTree(self.places)
        found = []
        for is_mirror in (False, True):
            for angle in angles:
                turn = (angle + angles[0]) / 2.0 if is_mirror else angle - angles[0]
                if not is_mirror and angle == angles[0]:
                    continue
                image = self._image(_matrix(turn, is_mirror=is_mirror), tree)
                if image is not None:
                    found.append(Motion(angle=float(turn), is_mirror=is_mirror, image=image))
        return found

    def _fewest(self, away: FloatArray) -> IntArray | None:
        """The fewest pieces off the middle that are alike; None where there are none, or too many."""
        features = np.column_stack([self.keys, away])
        best: IntArray | None = None
        left = np.flatnonzero(away > 10.0 * self.near)
        while len(left):
            alike = (np.abs(features[left] - features[left[0]]) <= 10.0 * self.near).all(axis=1)
            if best is None or alike.sum() < len(best):
                best = left[alike]
            left = left[~alike]
        return best if best is not None and len(best) <= _MOST_ALIKE else None

    def _image(self, matrix: FloatArray, tree: _Tree) -> IntArray | None:
        """Which piece each is carried to; None where one is carried to none."""
        near = 10.0 * self.near
        far, image = tree.query(self.places @ matrix.T)
        if far.max() > near:
            return None
        if len(np.unique(image)) < len(image) or (np.abs(self.keys - self.keys[image]) > near).any():
            return self._image_of_shared_places(matrix, tree)
        return np.asarray(image, dtype=np.int64) if self._ends_agree(matrix, image) else None

    def _image_of_shared_places(self, matrix: FloatArray, tree: _Tree) -> IntArray | None:
        """The same where several pieces have one place, as concentric circles have: the one that is alike."""
        near = 10.0 * self.near
        image = np.empty(len(self.places), dtype=np.int64)
        for j, beside in enumerate(tree.query_ball_point(self.places @ matrix.T, near)):
            alike = [k for k in beside if (np.abs(self.keys[j] - self.keys[k]) <= near).all()]
            if len(alike) != 1:
                return None
            image[j] = alike[0]
        return image if len(np.unique(image)) == len(image) and self._ends_agree(matrix, image) else None

    def _ends_agree(self, matrix: FloatArray, image: IntArray) -> bool:
        n = len(self.ends)
        if not n:
            return True
        carried, there = self.ends @ matrix.T, self.ends[image[:n]]
        straight = np.linalg.norm(carried - there, axis=2).max(axis=1)
        turned = np.linalg.norm(carried - there[:, ::-1], axis=2).max(axis=1)
        return bool(np.minimum(straight, turned).max() <= 10.0 * self.near)


def _matrix(angle: float, *, is_mirror: bool) -> FloatArray:
    if is_mirror:
        c, s = np.cos(2.0 * angle), np.sin(2.0 * angle)
        return np.array([[c, s], [s, -c]])
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])
