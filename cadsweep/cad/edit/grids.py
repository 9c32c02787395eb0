"""Planes through all of a block whose bores cross beside other features, and cells under what ends inside of it.

Place in the flow: a candidate of :mod:`.cutters` where :mod:`.boxes` finds none.

Method: no plane ends inside of the block (:mod:`.grid_layout` says where they lie), so the cells agree without a
search. Bores that cross lie in a box of eight cells, with the planes of the crossing through it; what is blind is
carried on to where the part ends. Where another feature is in the way, a circle with a bore in it ends in a cone to
the wall of the bore (:mod:`.countersinks`), any other outline in a cushion (:mod:`.cushions`)::

        |    |:|    |
    ----+----|:|----+---      a counterbore over a crossing: the circle of its floor ends in the cone, the bore goes on
        |   /|:|\\   |         in its own box
    ----+----|:|----+---
    .........|:|.........     the bore that crosses it
    ----+----|:|----+---

Not handled: crossings of what is no whole bore, bores of one radius that cross, and bores that end inside of others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise
from math import pi
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid
from .axes import Axis, find_axes
from .axial import EVERY, Cluster, is_across
from .box_layout import DEPTHS, Block, Floor, read_block
from .boxes import MOST_BRICKS, carry_on, fit_cushion, planes_of
from .central import Cutter
from .circles import Rim, find_outlines
from .countersinks import LEAST_SLOPE, SHARE, countersink, seam_in
from .crossings import find_crossings, plain_planes
from .cushions import WIDEST
from .grid_layout import CORE, MARGIN, End, Zone, box_of, find_planes, holes_in, is_whole, with_core
from .half_way import half_way
from .slots import find_passages

SLOPE, STEEP = 1.0, 0.87
"""Depth of a cone to a bore, in the width of the ring between bore and circle, as it is wanted, and from which on what
is beside it is swept along the bore as if its wall were straight."""
DEEPEST = 1.2
"""Depth of a cushion in radii of its circle, at most."""


@dataclass(kw_only=True, eq=False)
class _Column:
    """A stretch of one width of a feature, with what ends there."""

    zone: Zone
    number: int
    carried: list[tuple[Floor, float]] = field(default_factory=list)
    cushions: list[tuple[Rim, int]] = field(default_factory=list)
    cones: list[tuple[Rim, Axis, FloatArray, float]] = field(default_factory=list)


def on_grid(solid: Solid, flat: float) -> list[Cutter]:
    """Planes through everything that part a block with crossing bores; none where they cannot be had.

    Parameters
    ----------
    solid : Solid
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    found = read_block(solid, flat)
    if found is None:
        return []
    block, clusters = found
    grid = _Grid(block, clusters)
    tools = grid.tools() if grid.read() and grid.is_worth() else None
    if not tools:
        return []
    reason = "planes through all of the part, and cells under what ends inside of it"
    return [Cutter(kind="boxes", reason=reason, tools=tuple(tools), weight=solid.size, leads=True)]


class _Grid:
    """The features of a block, and the planes through it."""

    def __init__(self, block: Block, clusters: Sequence[Cluster]) -> None:
        self.block, self.clusters = block, clusters
        self.bores = find_axes(block.solid)
        self.rims = find_outlines(block.solid, block.flat)
        self.columns: list[_Column] = []
        self.fixed: list[Zone] = []
        self.steps: list[tuple[int, float]] = []

    def read(self) -> bool:
        """Read all features; False where one is of no kind that this knows."""
        passages = find_passages(self.block.solid)
        crossings = find_crossings(passages)
        planes = plain_planes(self.block.solid, passages, crossings)
        if planes is None:
            return False
        crossed = frozenset(line for crossing in crossings for line in crossing.lines)
        through = {frozenset(crossing.lines): own for crossing, own in zip(crossings, planes, strict=True)}
        for number, cluster in enumerate(self.clusters):
            low, high = np.array(cluster.spans).T
            if cluster.is_crossing:
                zone = self.crossing(low, high, cluster.axes, through[cluster.axes])
                if zone is None:
                    return False
                for slot in (axis for axis in passages if axis.is_slot and axis.line in cluster.axes):
                    zone, rest = self.clipped(zone, slot, passages)
                    self.columns += [_Column(zone=own, number=len(self.clusters) + slot.line) for own in rest]
                self.columns.append(_Column(zone=zone, number=number))
            elif cluster.ways == EVERY:
                self.fixed.append(Zone(low=low, high=high, way=-1))
                self.steps += self.block.steps(cluster)
            elif len(cluster.ways) == 1:
                (way,) = cluster.ways
                whole = Zone(low=low, high=high, way=way)
                slots = [axis.line for axis in passages if axis.is_slot and axis.line in cluster.axes]
                if slots:
                    lines = crossed.intersection(slots)
                    column = _Column(zone=replace(whole, lines=lines), number=len(self.clusters) + slots[0])
                    self.columns.append(column)
                    continue
                self.columns += self.stretches(whole, number, crossed)
            else:
                return False
        self.columns = _joined(self.columns, self.block.tight)
        zones = [column.zone for column in self.columns]
        if any(_overlap(a, b, self.block.tight) for a, b in combinations(zones, 2)):
            return False
        return all(self.end(column) for column in self.columns)

    def is_worth(self) -> bool:
        """Whether bores cross beside other features or twice, or a cone is needed: others part better with less."""
        n_crossings = sum(column.zone.way < 0 for column in self.columns)
        is_alone = not self.fixed and all(column.zone.lines for column in self.columns)
        return any(column.cones for column in self.columns) or n_crossings > is_alone

    def crossing(
        self, low: FloatArray, high: FloatArray, lines: frozenset[int], planes: Sequence[tuple[FloatArray, FloatArray]]
    ) -> Zone | None:
        """The zone of a crossing; None where its planes are slanted."""
        free: list[list[tuple[float, float]]] = [[], [], []]
        for normal, place in planes:
            along = np.abs(self.block.normals @ normal)
            axis = int(along.argmax())
            if along[axis] < 1.0 - 1e-9:
                return None
            level = float(self.block.normals[axis] @ place)
            free[axis].append((level, level))
            self.steps.append((axis, level))
        one, two, three = map(tuple, free)
        return Zone(low=low, high=high, way=-1, lines=lines, free=(one, two, three), is_round=True, is_tight=True)

    def clipped(self, zone: Zone, slot: Axis, passages: Sequence[Axis]) -> tuple[Zone, list[Zone]]:
        """A crossing as far as the planes beside the bore, where that ends in a slot's sides, and the slot beyond."""
        normals, tight = self.block.normals, self.block.tight
        way = int(np.abs(normals @ slot.direction).argmax())
        long = int(np.abs(normals @ slot.spread).argmax())
        other = next(axis for axis in passages if axis.line in zone.lines - {slot.line})
        if abs(float(normals[long] @ other.direction)) > 0.5:
            return zone, []
        at = float(normals[long] @ other.place)
        rest = []
        for level, _ in zone.free[long]:
            if abs(level - at) < other.radius + tight:
                continue
            low, high = zone.low.copy(), zone.high.copy()
            places = normals @ slot.place
            beyond = np.array([places - slot.radius, places + slot.radius])
            beyond[0, way], beyond[1, way] = zone.low[way], zone.high[way]
            if level > at:
                beyond[:, long], high[long] = (level, zone.high[long]), level
            else:
                beyond[:, long], low[long] = (zone.low[long], level), level
            zone = replace(zone, low=low, high=high)
            rest.append(Zone(low=beyond[0], high=beyond[1], way=way, lines=frozenset([slot.line])))
        return zone, rest

    def stretches(self, whole: Zone, number: int, crossed: frozenset[int]) -> Iterator[_Column]:
        """A feature in pieces of one width each, where it is of whole cylinders about one line: all of one number."""
        normals, way, tight = self.block.normals, whole.way, self.block.tight
        reach: list[tuple[float, float, FloatArray, Axis]] = []
        for bore in self.bores:
            along = float(normals[way] @ bore.direction)
            if abs(along) < 1.0 - 1e-9:
                continue
            at = normals @ bore.place
            ends = sorted(at[way] + along * t for t in (bore.low, bore.high))
            middle = at.copy()
            middle[way] = 0.5 * (ends[0] + ends[1])
            within = (whole.low - tight < at) & (at < whole.high + tight)
            if all(within[a] for a in range(3) if a != way) and ends[0] < whole.high[way] and ends[1] > whole.low[way]:
                reach.append((max(ends[0], whole.low[way]), min(ends[1], whole.high[way]), at, bore))
        places = [at for _, _, at, _ in reach]
        is_one = all(np.delete(np.abs(at - places[0]), way).max() < tight for at in places)
        widest = max((bore.radius for *_, bore in reach), default=0.0)
        is_all = all(whole.half(a) < widest + tight for a in range(3) if a != way)
        if not reach or not is_one or not is_all:
            yield _Column(zone=whole, number=number)
            return
        line = reach[0][3].line
        lines = crossed & {line}
        marks = np.unique(np.round([end for low, high, _, _ in reach for end in (low, high)], 12))
        marks[0], marks[-1] = whole.low[way], whole.high[way]
        for start, end in pairwise(marks):
            if end - start < tight:
                continue
            inside = (b.radius for low, high, _, b in reach if low < end - tight and high > start + tight)
            radius = max(inside, default=widest)
            low, high = places[0] - radius, places[0] + radius
            low[way], high[way] = start, end
            zone = replace(whole, low=low, high=high, lines=lines)
            yield _Column(zone=zone, number=len(self.clusters) + line)

    def end(self, column: _Column) -> bool:
        """Carry what is blind on to where the part ends, or close it; False where neither goes."""
        return column.zone.way < 0 or all(self.end_down(column, down) for down in (-1, 1))

    def end_down(self, column: _Column, down: int) -> bool:
        zone, tight = column.zone, self.block.tight
        floors = [floor for floor in self.floors(zone) if floor.down == down]
        if not floors:
            return True
        way = zone.way
        stop = float((self.block.low if down < 0 else self.block.high)[way])
        start = max((floor.level for floor in floors), key=lambda level: -down * level)
        span = np.sort([start, stop])
        far = replace(zone, low=zone.low.copy(), high=zone.high.copy())
        far.low[way], far.high[way] = span
        others = [c.zone for c in self.columns if c.zone.way != way or c.number != column.number]
        met = [
            float((other.high if down < 0 else other.low)[way])
            for other in (*others, *self.fixed)
            if _overlap(far, other, -MARGIN * min(far.half(a) for a in range(3) if a != way))
        ]
        if not met:
            column.carried += [(floor, stop) for floor in floors]
            low, high = np.minimum(zone.low, far.low), np.maximum(zone.high, far.high)
            column.zone = replace(zone, low=low, high=high)
            return True
        obstacle = max(met) if down < 0 else min(met)
        own = [rim for rim in self.rims if self.is_of(rim, zone, down)]
        levels = {round(floor.level / tight) for floor in floors}
        if len(own) != len(levels):
            return False
        return all(self.close(column, rim, down, obstacle) for rim in own)

    def close(self, column: _Column, rim: Rim, down: int, obstacle: float) -> bool:
        """Put a cone or a cushion under an outline, above what is in the way; False where there is no room."""
        zone = column.zone
        normal = self.block.normals[zone.way]
        level = float(rim.center @ normal)
        room = down * (obstacle - level)
        center = self.block.normals @ rim.center
        for bore in self.bores:
            seam = seam_in(self.block.solid, rim, bore)
            if seam is None or not self.goes_on(bore, zone.way, level, down):
                continue
            width = rim.radius - bore.radius
            depth = min(SLOPE * width, SHARE * room)
            if depth < LEAST_SLOPE * width:
                return False
            column.cones.append((rim, bore, seam, depth))
            low, high = sorted((level, level + down * depth))
            left = room - depth
            end = End(level=level + down * depth, down=down, depths=(0.0, 0.5 * left, left))
            if depth < STEEP * width:
                # What is beside a flat cone has corners at both of its ends.
                self.steps += [(zone.way, low), (zone.way, high)]
            column.zone = replace(
                with_core(zone, center, 0.0), closed=(*zone.closed, (low, high)), ends=(*zone.ends, end)
            )
            return True
        found = half_way(self.block.solid, rim, self.block.flat)
        depth = min(DEPTHS[0] * rim.radius, SHARE * room)
        if found is None or depth < DEPTHS[1] * rim.radius:
            return False
        column.cushions.append((found, down))
        self.steps.append((zone.way, float(found.center @ normal)))
        level = float(found.around @ normal)
        depths = found.sunk + np.array([DEPTHS[1] * rim.radius, depth, DEEPEST * rim.radius])
        end = End(level=level, down=down, depths=tuple(depths.tolist()))
        column.zone = replace(with_core(zone, center, CORE), ends=(*zone.ends, end), is_tight=True)
        return True

    def goes_on(self, bore: Axis, way: int, level: float, down: int) -> bool:
        """Whether a bore reaches further down than a level."""
        along = float(self.block.normals[way] @ bore.direction)
        ends = [float(self.block.normals[way] @ bore.place) + along * t for t in (bore.low, bore.high)]
        return max(down * (end - level) for end in ends) > self.block.tight

    def floors(self, zone: Zone) -> Iterator[Floor]:
        """Re-entrant edges of a feature on planes across its way."""
        normals, tight = self.block.normals, self.block.tight
        for edge in self.block.solid.edges:
            if edge.dihedral < pi + self.block.flat:
                continue
            at = normals @ edge.midpoint
            if not ((zone.low - tight < at) & (at < zone.high + tight)).all():
                continue
            for face in (self.block.solid.faces[f] for f in edge.faces):
                if is_across(face, normals[zone.way]):
                    down = -1 if float(face.normal @ normals[zone.way]) > 0.0 else 1
                    yield Floor(edge=edge.id, level=float(at[zone.way]), down=down)

    def is_of(self, rim: Rim, zone: Zone, down: int) -> bool:
        """Whether an outline belongs to a feature, the material below it in a direction."""
        at, tight = self.block.normals @ rim.center, self.block.tight
        if float(rim.normal @ self.block.normals[zone.way]) * down > -1.0 + 1e-6:
            return False
        return bool(((zone.low - tight < at) & (at < zone.high + tight)).all()) and all(
            rim.radius < zone.half(a) + tight for a in range(3) if a != zone.way
        )

    def tools(self) -> list[Any] | None:
        """Planes, cones, cushions and what is carried on; None where there is no room for them."""
        zones, block = [column.zone for column in self.columns], self.block
        planes = find_planes(block, zones, self.fixed, self.steps)
        if planes is None or np.prod([len(own) + 1 for own in planes]) > MOST_BRICKS:
            return None
        if not is_whole(zones, self.fixed, planes, block):
            return None
        tools = list(planes_of(block, planes, lambda axis, level: holes_in(zones, planes, block, axis, level)))
        for column in self.columns:
            for rim, bore, seam, depth in column.cones:
                tools += countersink(block.solid, rim, bore, seam, depth)
            for rim, down in column.cushions:
                made = self.cushion(column.zone, rim, down, planes)
                if made is None:
                    return None
                tools += made
            for floor, stop in column.carried:
                tools += carry_on(block, floor, column.zone.way, stop)
        return tools

    def cushion(self, zone: Zone, rim: Rim, down: int, planes: Sequence[Sequence[float]]) -> list[Any] | None:
        """The cells under an outline, out to the planes around it."""
        block = self.block
        low, high = box_of(zone, planes, block)
        level = float(block.normals[zone.way] @ rim.around)
        depth = min(down * (at - level) for at in planes[zone.way] if down * (at - level) > block.tight)
        return fit_cushion(block, rim, zone.way, (low, high), depth, widest=WIDEST + 1.0)


def _joined(columns: Sequence[_Column], tight: float) -> list[_Column]:
    """Features of one way that overlap are one."""
    found: list[_Column] = []
    for column in columns:
        own = column
        while (other := next((c for c in found if _is_one(c.zone, own.zone, tight)), None)) is not None:
            found.remove(other)
            a, b = own.zone, other.zone
            low, high = np.minimum(a.low, b.low), np.maximum(a.high, b.high)
            lines, number = a.lines | b.lines, max(own.number, other.number)
            own = _Column(zone=replace(a, low=low, high=high, lines=lines), number=number)
        found.append(own)
    return found


def _is_one(a: Zone, b: Zone, tight: float) -> bool:
    return a.way >= 0 and a.way == b.way and _overlap(a, b, tight)


def _overlap(a: Zone, b: Zone, tight: float) -> bool:
    """Whether two features share a part of space; a flat one does where it lies inside."""
    flat = (b.high - b.low <= tight) | (a.high - a.low <= tight)
    overlap = np.minimum(a.high, b.high) - np.maximum(a.low, b.low)
    inside = (a.low + tight < b.low) & (b.high < a.high - tight)
    return bool(np.where(flat, inside, overlap > tight).all())


__all__ = ["on_grid"]
