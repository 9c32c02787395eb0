"""Which planes part a block with bores that cross: they go through all of it but what they would harm.

Place in the flow: :mod:`.grids` makes cutters of them. All coordinates are along three normals of the block.

Method: every feature says where no plane may go through it. Where bores cross, only the planes through the crossing
may; what ends in a cushion or a cone may be cut along its axis, other features anywhere but next to their sides.
Then every feature asks for a plane between itself and the next one that goes another way; the least room first. It
takes a plane that is there, else one that is free. A plane that still would harm a feature ends before it: on the
sides of what goes through, where its end is a line along the sweep, else one plane further away::

        |    .    |    .    |         a crossing or a cushion between the dots: the plane ends before the planes next to
    ----+    . . .|. . .    +----     these, so that its end lies on bricks and divides no side of the box
        |    .    |    .    |

Not handled: crossings that touch one another, and features among which no plane is free.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from ...arrays import FloatArray
from .box_layout import Block, Site

MARGIN = 0.12
"""Distance of a plane from a feature, in half of its width, at least."""
SIDE = 0.3
"""Distance of a plane in a feature that goes through from its side, in half of its width, at least."""
CORE = 0.27
"""Distance from the middle of a cushion, in half of its feature's width, up to which a plane may go through it."""
WALL = 0.45
"""Distance of a new plane from a feature, in half of its width, where there is room."""
WIDE = 1.5
"""The same, from which on a plane is too far to be the side of a box of cells."""
CLOSE = 0.012
"""Distance of two planes, as a share of the part's size, below which what is between them is thin."""
BEFORE = 0.8
"""Share of the way from a cone to the cushion below it, in one bore, before which a plane lies between them."""
BETWEEN = 3
"""Planes between two bores that cross a third, where those of one end before the other."""
PLACES = 61
"""Places of a new plane that are tried between two features."""


@dataclass(frozen=True, kw_only=True, eq=False)
class End:
    """The floor of a cushion or the end of a cone, and the plane that is wanted below it.

    Attributes
    ----------
    level : float
    down : int
        -1 or 1.
    depths : (float, float, float)
        Of the plane below it, at least, as it is wanted, and at most.
    """

    level: float
    down: int
    depths: tuple[float, float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class Zone:
    """A feature, and where planes may go through it.

    Attributes
    ----------
    low, high : (3,) float64
        Along the normals, as far as it was carried on.
    way : int
        Normal along which it goes; -1 where bores cross.
    lines : frozenset of int
        Bores that cross here or elsewhere.
    free : three tuples of (float, float)
        Along each normal, where planes may go through all the same.
    closed : tuple of (float, float)
        Along its way, where none may: cushions and cones.
    ends : tuple of End
        What ends inside of it, along its way.
    is_round : bool
        No plane may go through it but where it is free: a cone, or what is tight.
    is_tight : bool
        Nor may a plane end on its sides: a crossing or a cushion.
    """

    low: FloatArray
    high: FloatArray
    way: int
    lines: frozenset[int] = frozenset()
    free: tuple[tuple[tuple[float, float], ...], ...] = ((), (), ())
    closed: tuple[tuple[float, float], ...] = ()
    ends: tuple[End, ...] = ()
    is_round: bool = False
    is_tight: bool = False

    def half(self, axis: int) -> float:
        """Half of its width."""
        return 0.5 * float(self.high[axis] - self.low[axis])

    def forbids(self, axis: int, level: float, tight: float) -> bool:
        """Whether a plane harms it."""
        if axis == self.way:
            return any(low + tight < level < high - tight for low, high in self.closed)
        margin = MARGIN * self.half(axis)
        if not self.low[axis] - margin + tight < level < self.high[axis] + margin - tight:
            return False
        if any(low - tight <= level <= high + tight for low, high in self.free[axis]):
            return False
        inner = SIDE * self.half(axis)
        return self.is_round or not self.low[axis] + inner <= level <= self.high[axis] - inner

    def beside(self, other: Zone, axis: int, tight: float) -> bool:
        """Whether it lies next to another one along a normal."""
        overlap = (np.minimum(self.high, other.high) - np.maximum(self.low, other.low)).tolist()
        return all(overlap[k] > tight for k in range(3) if k != axis)

    def needs_apart(self, other: Zone) -> bool:
        """Whether a plane must lie between it and another one."""
        return self.is_round or other.is_round or self.way != other.way or bool(self.lines or other.lines)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Want:
    """A plane that is asked for beyond the side of a feature, up to the next one or to the part's end."""

    gap: float
    axis: int
    start: float
    sign: int
    zone: Zone
    depths: tuple[float, float, float]
    is_last: bool


def find_planes(
    block: Block, zones: Sequence[Zone], fixed: Sequence[Zone], steps: Iterable[tuple[int, float]]
) -> list[list[float]] | None:
    """Coordinates of planes along each normal, in order; None where they cannot be had.

    Parameters
    ----------
    block : Block
    zones : sequence of Zone
        Features.
    fixed : sequence of Zone
        Steps and pockets of planes along the normals: no plane harms them.
    steps : iterable of (int, float)
        Planes that must be there, by normal.
    """
    tight = block.tight
    levels: list[list[float]] = [[], [], []]
    for axis, level in steps:
        is_inside = block.low[axis] + tight < level < block.high[axis] - tight
        if not is_inside or any(abs(level - known) <= tight for known in levels[axis]):
            continue
        levels[axis].append(level)
    wants = [want for zone in zones for want in _wants(block, zone, (*zones, *fixed))]
    for want in sorted(wants, key=lambda want: (want.is_last, want.gap)):
        if not _is_served(want, levels[want.axis], block):
            new = _new_level(want, levels[want.axis], zones, block)
            if new is None:
                return None
            levels[want.axis].append(new)
    for axis, start, end in _bores_between(zones, block.tight):
        own = levels[axis]
        while sum(start - block.tight <= level <= end + block.tight for level in own) < BETWEEN:
            ends = [start, *sorted(level for level in own if start < level < end), end]
            low, high = max(pairwise(ends), key=lambda pair: pair[1] - pair[0])
            places = np.linspace(low, high, PLACES)[1:-1]
            free = [at for at in places if not any(zone.forbids(axis, float(at), block.tight) for zone in zones)]
            if not free:
                return None
            own.append(float(min(free, key=lambda at: abs(at - 0.5 * (low + high)))))
    return [sorted(own) for own in levels]


def _bores_between(zones: Sequence[Zone], tight: float) -> Iterator[tuple[int, float, float]]:
    """Stretches of a bore, as normal, start and end, between two that cross it where a plane of one harms the other.

    The planes of both end in between: of what lies there no cell may have the end of one at either of its own ends.
    """
    for a, b in combinations([zone for zone in zones if zone.way < 0], 2):
        ends = (
            (one, other, axis, at) for one, other in ((a, b), (b, a)) for axis in range(3) for at, _ in one.free[axis]
        )
        if not a.lines & b.lines or not any(other.forbids(axis, at, tight) for _, other, axis, at in ends):
            continue
        gaps = np.maximum(a.low - b.high, b.low - a.high)
        axis = int(gaps.argmax())
        if gaps[axis] > tight:
            start = float(min(a.high[axis], b.high[axis]))
            yield axis, start, start + float(gaps[axis])


def box_of(zone: Zone, levels: Sequence[Sequence[float]], block: Block) -> tuple[FloatArray, FloatArray]:
    """The box that the planes next to a feature make around it; along its way the feature with what ends in it."""
    low, high = zone.low.copy(), zone.high.copy()
    for axis in range(3):
        if axis != zone.way:
            free = [c for c in levels[axis] if not (zone.is_tight and zone.forbids(axis, c, block.tight))]
            low[axis] = max([c for c in free if c <= low[axis] + block.tight], default=block.low[axis])
            high[axis] = min([c for c in free if c >= high[axis] - block.tight], default=block.high[axis])
    for end in zone.ends:
        beyond = [c for c in levels[zone.way] if end.down * (c - end.level) > -block.tight]
        if beyond and end.down < 0:
            low[zone.way] = min(low[zone.way], max(beyond))
        elif beyond:
            high[zone.way] = max(high[zone.way], min(beyond))
    return low, high


def holes_in(
    zones: Sequence[Zone], levels: Sequence[Sequence[float]], block: Block, axis: int, level: float
) -> list[Site]:  # fmt: skip
    """The boxes in which a plane would harm a feature: it ends on the sides of what goes through, and before all
    others at the next plane, so that what is beside these is bricks.

    What it would divide where bores cross it does not divide in all of their length, and what it parts there it parts
    beyond.
    """
    found = []
    harmed = [zone for zone in zones if zone.forbids(axis, level, block.tight)]
    lines = frozenset[int]().union(*(zone.lines for zone in harmed if zone.is_tight))
    parted = [z for z in zones if z.way < 0 and any(abs(level - at) < block.tight for at, _ in z.free[axis])]
    own = frozenset[int]().union(*(zone.lines for zone in parted))
    for zone in zones:
        low, high = box_of(zone, levels, block)
        is_beside = axis != zone.way and bool(zone.lines & lines)
        if (zone.lines & own and not zone.is_round) or zone in parted:
            continue
        if not low[axis] < level < high[axis] or not (is_beside or zone in harmed):
            continue
        if zone.is_tight:
            for other in range(3):
                if other != axis:
                    low[other] = max(
                        [c for c in levels[other] if c < low[other] - block.tight], default=block.low[other]
                    )
                    high[other] = min(
                        [c for c in levels[other] if c > high[other] + block.tight], default=block.high[other]
                    )
        elif axis == zone.way:
            continue
        found.append(Site(low=low, high=high, way=zone.way))
    return found


def is_whole(
    zones: Sequence[Zone], fixed: Sequence[Zone], levels: Sequence[Sequence[float]], block: Block
) -> bool:  # fmt: skip
    """Whether every plane is there where it is the side of a feature, or goes through where bores cross."""
    for zone in (*(zone for zone in zones if zone.is_tight), *fixed):
        low, high = (zone.low, zone.high) if zone in fixed else box_of(zone, levels, block)
        if zone.is_tight and zone.way >= 0:
            # Of a blind feature the cells under its floor alone.
            floors = [end.level for end in zone.ends]
            if all(end.down < 0 for end in zone.ends):
                high[zone.way] = max(floors)
            elif all(end.down > 0 for end in zone.ends):
                low[zone.way] = min(floors)
        for axis in range(3):
            if axis == zone.way:
                continue
            needed = [low[axis], high[axis], *(at for at, _ in zone.free[axis] if zone.way < 0)]
            for level in (c for c in levels[axis] if any(abs(c - at) < block.tight for at in needed)):
                for hole in holes_in(zones, levels, block, axis, level):
                    overlap = np.delete(np.minimum(high, hole.high) - np.maximum(low, hole.low), axis)
                    if (overlap > block.tight).all():
                        return False
    return True


def _wants(block: Block, zone: Zone, others: Sequence[Zone]) -> Iterator[_Want]:
    if zone.way < 0:
        return
    for axis in range(3):
        if axis == zone.way:
            continue
        wide = WIDE * zone.half(axis)
        for sign in (-1, 1):
            start = float((zone.low if sign < 0 else zone.high)[axis])
            room = sign * (float((block.low if sign < 0 else block.high)[axis]) - start)
            gap, is_last = _gap(zone, others, (axis, sign, start), block.tight)
            if is_last and not ((zone.is_round or zone.lines) and room > wide):
                continue
            gap = min(gap, room)
            most = wide if is_last or zone.is_tight else gap
            wanted = min(WALL * zone.half(axis), 0.5 * gap)
            yield _Want(
                gap=gap, axis=axis, start=start, sign=sign, zone=zone, depths=(0.0, wanted, most), is_last=is_last
            )
    for end in zone.ends:
        gap, is_last = _gap(zone, others, (zone.way, end.down, end.level), block.tight)
        below = [
            end.down * (floor.level - end.level)
            for other in others
            if other.is_tight and other.way == zone.way and zone.beside(other, zone.way, block.tight)
            for floor in other.ends
            if floor.down == end.down
        ]
        inside = [depth for depth in below if block.tight < depth < gap]
        if inside:
            room = min(inside)
            # The bore under a cone ends in a cushion: its sides must not go on through the cone.
            depths = (0.0, 0.5 * room, BEFORE * room)
            yield _Want(
                gap=room, axis=zone.way, start=end.level, sign=end.down, zone=zone, depths=depths, is_last=False
            )
        elif not is_last or zone.is_tight:
            yield _Want(
                gap=gap, axis=zone.way, start=end.level, sign=end.down, zone=zone, depths=end.depths, is_last=False
            )


def _gap(zone: Zone, others: Sequence[Zone], side: tuple[int, int, float], tight: float) -> tuple[float, bool]:
    """Distance from a side of a feature to the next one that must be kept apart; whether there is none.

    A side is its normal, whether it is the upper one, 1, or the lower, -1, and its place.
    """
    axis, sign, start = side
    gaps = []
    for other in others:
        is_own = zone.lines & other.lines and axis != zone.way
        if other is zone or is_own or not zone.needs_apart(other) or not zone.beside(other, axis, tight):
            continue
        gap = sign * (float((other.low if sign > 0 else other.high)[axis]) - start)
        if gap > -tight:
            gaps.append(gap)
    return min(gaps, default=np.inf), not gaps


def _is_served(want: _Want, levels: Sequence[float], block: Block) -> bool:
    """Whether a plane is there already."""
    least, _, most = want.depths
    return any(
        least - block.tight <= want.sign * (level - want.start) <= min(most, want.gap) + block.tight for level in levels
    )


def _new_level(want: _Want, levels: Sequence[float], zones: Sequence[Zone], block: Block) -> float | None:
    """Where a plane harms no feature, as near as may be to where it is wanted."""
    least, wanted, most = want.depths
    is_near = want.zone.is_tight or want.depths[0] > 0.0
    end = min(want.gap, most) if is_near else want.gap
    places = [float(gap) for gap in np.linspace(least, end, PLACES)[1:-1]]
    marks = [at for zone in zones for a, b in zone.free[want.axis] for at in (a, 0.5 * (a + b), b)]
    places += [gap for gap in (want.sign * (at - want.start) for at in marks) if least < gap < end]
    close = CLOSE * block.solid.size
    # A plane may end before some features, where there is no other way.
    tight = [zone for zone in zones if zone.is_tight or zone is want.zone]
    for harmed, apart in ((zones, close), (zones, 0.0), (tight, close), (tight, 0.0), ([want.zone], close)):
        free = [
            gap
            for gap in places
            if all(abs(want.start + want.sign * gap - known) > apart for known in levels)
            and not any(zone.forbids(want.axis, want.start + want.sign * gap, block.tight) for zone in harmed)
        ]
        if free:
            return want.start + want.sign * min(free, key=lambda gap: abs(gap - wanted))
    return None


def with_core(zone: Zone, center: FloatArray, share: float) -> Zone:
    """A feature that may be cut near its middle alone."""
    free = tuple(
        () if axis == zone.way else ((float(center[axis]) - share * zone.half(axis),
                                      float(center[axis]) + share * zone.half(axis)),)
        for axis in range(3)
    )  # fmt: skip
    return replace(zone, free=free, is_round=True)


__all__ = ["CORE", "MARGIN", "End", "Zone", "box_of", "find_planes", "holes_in", "is_whole", "with_core"]
