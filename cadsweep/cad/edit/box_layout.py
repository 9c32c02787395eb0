"""Where the boxes around the features of a block lie, and the planes at their sides.

Place in the flow: :mod:`.boxes` makes cutters of them. All coordinates are along three normals of the block.

Method: features that overlap share a box. A blind one is carried on to where the part ends, or to a cushion above what
is in the way. Then box by box each side moves out until it meets a face, another box, or half of the way to the next
feature; sides lie on planes that are there already where that leaves enough material.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid
from .axial import EVERY, Cluster, direction_of, find_clusters, hollow_beside, is_across, main_normals
from .circles import Rim, find_outlines
from .half_way import half_way

LEAST_FILL = 0.5
"""Share of its bounding box that a block fills: legs and webs of a bracket part better at their own faces."""
CUSHION_WALL = 0.35
"""Material that a box leaves around a cushion, in radii of its circle, where there is room."""
LEAST_SHARE = 0.25
"""Share of the gap between two features that is left to each of them, at least."""
SHARED = 1.6
"""Material around a cushion, in what it is else, up to which its box reaches a face or a plane that is there."""
DEPTHS = (0.6, 0.15)
"""Depth of a cushion in radii of its circle, at most and at least."""
DEEPER = (0.7, 1.1)
"""Shares of its depth between which a cushion may end on a plane that is there."""
SHARE = 0.6
"""Share of the gap to the next feature that a cushion takes, at most."""
TIGHT = 1e-6
"""Distance, as a share of the cell's size, below which two coordinates are one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Floor:
    """An edge on a plane across a feature's way, the material below it in the direction `down`, -1 or 1."""

    edge: int
    level: float
    down: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Site:
    """A feature with its box.

    Attributes
    ----------
    low, high : (3,) float64
        Along the normals.
    way : int
        Normal along which it goes; -1 where none suits it, or what it crosses.
    floors : tuple of Floor
    cushion : (Rim, float) or None
        The circle that ends inside, and the depth of the cells under it.
    """

    low: FloatArray
    high: FloatArray
    way: int
    floors: tuple[Floor, ...] = ()
    cushion: tuple[Rim, float] | None = None

    def meets(self, other: Site, tight: float) -> bool:
        """Whether two boxes have a part of space in common, or one way and a part of a side."""
        overlap = np.minimum(self.high, other.high) - np.maximum(self.low, other.low)
        if self.way >= 0 and self.way == other.way:
            overlap[self.way] += 2.0 * tight
        return bool((overlap > tight).all())

    def merged(self, other: Site) -> Site:
        """One box for both; they cross where they go different ways."""
        return Site(
            low=np.minimum(self.low, other.low),
            high=np.maximum(self.high, other.high),
            way=self.way if self.way == other.way else -1,
            floors=(*self.floors, *other.floors),
        )

    def bars(self, axis: int, level: float, tight: float) -> bool:
        """Whether a plane must not go through the box."""
        if not self.low[axis] + tight < level < self.high[axis] - tight:
            return False
        if axis != self.way:
            return True
        if self.cushion is None:
            return False
        depth = self.cushion[1]
        low, high = (
            (self.low[axis], self.low[axis] + depth) if self.down < 0 else (self.high[axis] - depth, self.high[axis])
        )
        return bool(low + tight < level < high - tight)

    @property
    def down(self) -> int:
        """Where the material is below its floors: -1 or 1."""
        return self.floors[0].down


class Block:
    """The part in the frame of its three normals."""

    def __init__(self, solid: Solid, normals: FloatArray, flat: float) -> None:
        self.solid, self.normals, self.flat = solid, normals, flat
        self.tight = TIGHT * solid.size
        places = solid.vertices @ normals.T
        self.low, self.high = places.min(axis=0), places.max(axis=0)
        at = np.linspace(0.0, 1.0, 9)
        self.planes: list[tuple[int, float, FloatArray, FloatArray]] = []
        for face in solid.faces:
            if any(hollow_beside(solid, face, e, flat) for e in face.edges):
                continue  # a box's side on it would leave a wedge of no angle beside the rounding that it goes on into
            for axis, normal in enumerate(normals):
                if is_across(face, normal):
                    along = np.concatenate([solid.edges[e].curve.evaluate(at) for e in face.edges]) @ normals.T
                    self.planes.append((axis, float(along[:, axis].mean()), along.min(axis=0), along.max(axis=0)))

    def site(self, cluster: Cluster) -> Site:
        """A feature as it is, without material around it."""
        low, high = np.array(cluster.spans).T
        way = next(iter(cluster.ways)) if len(cluster.ways) == 1 else -1
        return Site(low=low, high=high, way=way, floors=tuple(self.floors(cluster, way)) if way >= 0 else ())

    def floors(self, cluster: Cluster, way: int) -> Iterator[Floor]:
        for e in sorted(cluster.edges):
            edge = self.solid.edges[e]
            if edge.dihedral < pi - self.flat:
                continue
            for face in (self.solid.faces[f] for f in edge.faces):
                is_sharp = edge.dihedral > pi + self.flat
                if is_across(face, self.normals[way]) and (is_sharp or hollow_beside(self.solid, face, e, self.flat)):
                    down = -1 if float(face.normal @ self.normals[way]) > 0.0 else 1
                    yield Floor(edge=e, level=float(edge.midpoint @ self.normals[way]), down=down)

    def steps(self, cluster: Cluster) -> list[tuple[int, float]]:
        """Planes at the re-entrant edges of a feature that has faces across the normals alone."""
        found = []
        for e in sorted(cluster.edges):
            for face in (self.solid.faces[f] for f in self.solid.edges[e].faces):
                found += [(a, float(face.center @ n)) for a, n in enumerate(self.normals) if is_across(face, n)]
        return found


def read_block(solid: Solid, flat: float) -> tuple[Block, list[Cluster]] | None:
    """Read a block and its features; None for what is none, and where one direction suits all features.

    Parameters
    ----------
    solid : Solid
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    axes = [direction_of(solid, face) for face in solid.faces]
    normals = main_normals(solid, axes)
    if len(normals) < 3:
        return None
    if float(np.linalg.det(normals)) < 0.0:
        normals = normals * np.array([[1.0], [1.0], [-1.0]])
    clusters = find_clusters(solid, axes, normals, flat)
    block = Block(solid, normals, flat)
    is_slender = solid.volume < LEAST_FILL * float(np.prod(block.high - block.low))
    return None if is_slender or EVERY.intersection(*(cluster.ways for cluster in clusters)) else (block, clusters)


def apart(sites: Sequence[Site], tight: float) -> list[Site]:
    """Features whose boxes overlap are one."""
    found: list[Site] = []
    for site in sites:
        own = site
        while (other := next((one for one in found if one.meets(own, tight)), None)) is not None:
            found.remove(other)
            own = own.merged(other)
        found.append(own)
    return found


def carried(block: Block, sites: Sequence[Site], fixed: Sequence[Site]) -> list[Site] | None:
    """Blind features carried on along their ways to where the part ends, or to a cushion; None where neither goes."""
    done: list[Site] = []
    rims = find_outlines(block.solid, block.flat)
    for j, site in enumerate(sites):
        others = [*done, *sites[j + 1 :], *fixed]
        own: Site | None = site
        for down in (-1, 1):
            if own is not None and any(floor.down == down for floor in own.floors):
                own = _carried_down(block, own, down, others, rims)
        if own is None:
            return None
        done.append(own)
    return done


def _carried_down(block: Block, site: Site, down: int, others: Sequence[Site], rims: Sequence[Rim]) -> Site | None:
    """A blind feature carried on one way."""
    far = _reaching(site, down, (block.low if down < 0 else block.high)[site.way])
    ends = [
        float((other.high if down < 0 else other.low)[site.way]) for other in others if _is_met(far, other, block.tight)
    ]
    return _cushioned(block, site, down, max(ends) if down < 0 else min(ends), rims) if ends else far


def _is_met(site: Site, other: Site, tight: float) -> bool:
    """Whether boxes overlap; a flat one does where it lies inside."""
    flat = other.high - other.low <= tight
    overlap = np.minimum(site.high, other.high) - np.maximum(site.low, other.low)
    inside = (site.low + tight < other.low) & (other.high < site.high - tight)
    return bool(np.where(flat, inside, overlap > tight).all())


def _reaching(site: Site, down: int, end: float) -> Site:
    low, high = site.low.copy(), site.high.copy()
    (low if down < 0 else high)[site.way] = end
    return replace(site, low=low, high=high)


def _cushioned(block: Block, site: Site, down: int, end: float, rims: Sequence[Rim]) -> Site | None:
    """A feature whose one circle gets a cushion above what is in the way at `end`."""
    normal = block.normals[site.way]
    own = [rim for rim in rims if _is_of(block, rim, site)]
    if len(own) != 1 or len({round(floor.level / block.tight) for floor in site.floors}) != 1:
        return None
    rim = half_way(block.solid, own[0], block.flat)
    if rim is None or float(rim.normal @ normal) * down > -1.0 + 1e-6:
        return None
    level = float(rim.around @ normal)
    depth = min(DEPTHS[0] * rim.radius, SHARE * (abs(level - end) - rim.sunk))
    if depth < DEPTHS[1] * rim.radius:
        return None
    depth += rim.sunk
    return replace(_reaching(site, down, level + down * depth), cushion=(rim, depth))


def _is_of(block: Block, rim: Rim, site: Site) -> bool:
    at = block.normals @ rim.center
    return bool((site.low - block.tight < at).all() and (at < site.high + block.tight).all())


class Levels:
    """Coordinates of planes along each normal; those of boxes that nearly agree are one."""

    def __init__(self, block: Block, steps: Iterable[tuple[int, float]]) -> None:
        self.block = block
        self.own: list[list[float]] = [[], [], []]
        for axis, level in steps:
            self.add(axis, level)

    def add(self, axis: int, level: float) -> None:
        """Keep a coordinate, once."""
        if all(abs(level - known) > self.block.tight for known in self.own[axis]):
            self.own[axis].append(level)

    def near(self, axis: int, start: float, end: float) -> float | None:
        """A coordinate between two others, the first one from `start`."""
        between = [c for c in self.own[axis] if min(start, end) <= c <= max(start, end)]
        return min(between, key=lambda c: abs(c - start), default=None)

    def inner(self) -> list[list[float]]:
        """Coordinates inside the part, in order."""
        low, high, tight = self.block.low, self.block.high, self.block.tight
        return [sorted(c for c in own if low[a] + tight < c < high[a] - tight) for a, own in enumerate(self.own)]


def with_walls(block: Block, sites: Sequence[Site], fixed: Sequence[Site], levels: Levels) -> list[Site] | None:
    """Boxes with material around their features; None where two of them would overlap."""
    grown = list(sites)
    for j, one in enumerate(sites):
        site = _levelled(block, one, levels)
        low, high = site.low.copy(), site.high.copy()
        for axis in range(3):
            for sign, side in ((-1, low), (1, high)):
                if axis == site.way:
                    if block.low[axis] + block.tight < side[axis] < block.high[axis] - block.tight:
                        levels.add(axis, float(side[axis]))
                    continue
                own = replace(site, low=low, high=high)
                side[axis] = _side(levels, own, axis, sign, boxes=grown[:j], features=[*sites[j + 1 :], *fixed])
                levels.add(axis, float(side[axis]))
        if site.cushion is not None:
            levels.add(site.way, float(site.cushion[0].center @ block.normals[site.way]))
        grown[j] = replace(site, low=low, high=high)
    for j, site in enumerate(grown):
        if any(site.meets(other, block.tight) for other in grown[j + 1 :]):
            return None
        if any(_is_met(site, other, block.tight) for other in fixed):
            return None
    return grown


def _levelled(block: Block, site: Site, levels: Levels) -> Site:
    """A cushion that ends on a plane that is there already, where one is near its end: nothing thin is left between."""
    if site.cushion is None:
        return site
    rim, depth = site.cushion
    start = float(rim.around @ block.normals[site.way])
    least, most = (start + share * site.down * depth for share in DEEPER)
    level = levels.near(site.way, least, most)
    if level is None:
        return site
    return replace(_reaching(site, site.down, level), cushion=(rim, abs(level - start)))


def _side(
    levels: Levels, site: Site, axis: int, sign: int, *, boxes: Sequence[Site], features: Sequence[Site]
) -> float:
    """Where a side of a box lies: on a face, on a box that is there already, or half way to the next feature."""
    block = levels.block
    start = float((site.low if sign < 0 else site.high)[axis])
    across = [a for a in range(3) if a != axis]

    def beside(low: FloatArray, high: FloatArray) -> bool:
        return all(min(site.high[a], high[a]) - max(site.low[a], low[a]) > -block.tight for a in across)

    def nearest(ends: Iterable[float], beyond: float = -block.tight) -> float:
        gaps = [sign * (end - start) for end in ends]
        return min((gap for gap in gaps if gap > beyond), default=np.inf)

    def ends(others: Sequence[Site]) -> Iterator[float]:
        return (float((o.low if sign > 0 else o.high)[axis]) for o in others if beside(o.low, o.high))

    # Round features may reach beyond all corners of the part.
    end = max(sign * start, sign * float((block.low if sign < 0 else block.high)[axis])) * sign
    # A cushion needs material beside the plane walls of its own feature.
    least = -block.tight if site.cushion is None else block.tight
    levels_of_faces = (level for a, level, low, high in block.planes if a == axis and beside(low, high))
    face = nearest([end, *levels_of_faces], least)
    box, feature = nearest(ends(boxes)), nearest(ends(features))
    known = levels.near(axis, start + LEAST_SHARE * sign * feature, start + (1.0 - LEAST_SHARE) * sign * feature)
    half = 0.5 * feature if known is None or not np.isfinite(feature) else sign * (known - start)
    gap = max(0.0, min(face, box, half))
    if site.cushion is not None:
        wall = CUSHION_WALL * site.cushion[0].radius
        if gap > SHARED * wall:
            near = levels.near(axis, start + 0.5 * sign * wall, start + sign * SHARED * wall)
            return near if near is not None else start + sign * wall
    return start + sign * gap


__all__ = ["TIGHT", "Block", "Levels", "Site", "apart", "carried", "read_block", "with_walls"]
