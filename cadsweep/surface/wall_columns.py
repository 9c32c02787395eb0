"""Columns of nodes at the walls of a section: where they begin, along what they lean, and how long they may be.

Place in the flow: :mod:`.walls` makes them before it lays rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray

_BESIDE_WALL, _BESIDE_OTHERS = 0.4, 0.6
"""Part of the way to the outline across that a column may take, where there is a wall, too, and where there is none."""
_AROUND = 2.5
"""Way along the outline, in distances, from which on a node belongs to another part of it."""
_CORNER = np.radians(25)
"""Turn of the outline from which on a node is a corner."""
_LONGEST = 15.0
"""Length of a column at a corner over the height of its layers, at most (8 degrees between the walls)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Wall:
    """Layers along the segments of an outline: what is asked of each, 0 layers where it is no wall.

    Attributes
    ----------
    n : (m,) int64
        Number of layers along the segment from node i to its successor.
    first, growth : (m,) float64
    """

    n: IntArray
    first: FloatArray
    growth: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Columns:
    """Columns at the nodes of all walls: where, along what, and which segments run from one to the next."""

    base: IntArray
    after: IntArray
    """The next column along the wall, -1 at its end."""
    given: IntArray
    """(c, n) nodes of the outline that a column at the end of a wall consists of, -1 elsewhere."""
    lean: FloatArray
    """(c, 2) step of a column for a height of one."""
    sine: FloatArray
    """Least sine (c,) of the angles between a column and its walls."""
    reach: FloatArray
    """Part (c,) of its heights that a column has in the end: less than all at a sharp corner."""
    first: FloatArray
    growth: FloatArray
    room: FloatArray


def column_length(half: float) -> float:
    """Length of a column for a height of one where two walls have it between them, with half their angle to each."""
    return min(1.0 / max(float(np.sin(half)), 1e-300), _LONGEST)


def make_columns(loops: Sequence[FloatArray], walls: Sequence[Wall], n: int) -> Columns | None:
    parts: list[Columns] = []
    first = 0
    for loop, wall in zip(loops, walls, strict=True):
        part = _columns_of(loop, wall, n)
        if part is None:
            return None
        parts.append(replace(part, base=part.base + first, given=np.where(part.given >= 0, part.given + first, -1)))
        first += len(loop)
    starts = np.concatenate([[0], np.cumsum([len(part.base) for part in parts])])
    joined = Columns(
        base=np.concatenate([part.base for part in parts]),
        after=np.concatenate(
            [np.where(part.after >= 0, part.after + s, -1) for part, s in zip(parts, starts, strict=False)]
        ),
        given=np.concatenate([part.given for part in parts]),
        lean=np.concatenate([part.lean for part in parts]),
        sine=np.concatenate([part.sine for part in parts]),
        reach=np.concatenate([part.reach for part in parts]),
        first=np.concatenate([part.first for part in parts]),
        growth=np.concatenate([part.growth for part in parts]),
        room=np.concatenate([part.room for part in parts]),
    )
    return replace(joined, room=_room(loops, walls, joined))


def _columns_of(loop: FloatArray, wall: Wall, n: int) -> Columns | None:
    """Columns of one loop; None where an edge that a wall ends at has too few nodes for its rows."""
    m = len(loop)
    is_wall = wall.n > 0
    nodes = np.flatnonzero(is_wall | np.roll(is_wall, 1))
    number = np.full(m, -1, dtype=np.int64)
    number[nodes] = np.arange(len(nodes))
    after = np.where(is_wall[nodes], number[(nodes + 1) % m], -1)
    tangent = np.roll(loop, -1, axis=0) - loop
    steps = norm(tangent)
    tangent = tangent / steps[:, None]
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)  # inward: the polygon lies on the left
    given = np.full((len(nodes), n), -1, dtype=np.int64)
    lean, sine, reach = np.empty((len(nodes), 2)), np.ones(len(nodes)), np.ones(len(nodes))
    first, growth = np.empty(len(nodes)), np.empty(len(nodes))
    for c, i in enumerate(nodes.tolist()):
        sides = [s for s in (i - 1, i) if is_wall[s]]
        first[c], growth[c] = wall.first[sides].mean(), wall.growth[sides].mean()
        if len(sides) == 2:
            one, other = normal[i - 1], normal[i]
            sine[c] = np.sqrt(max(0.0, 0.5 + 0.5 * float(one @ other)))
            length = column_length(float(np.arcsin(sine[c])))
            reach[c] = min(1.0, length * sine[c])
            lean[c] = (one + other) / max(1.0 + float(one @ other), 2.0 / length**2)
            continue
        # The wall ends here: its rows end at the nodes of the edge that goes on.
        ways = (i + np.arange(1, n + 1)) % m if is_wall[i - 1] else (i - np.arange(1, n + 1)) % m
        if is_wall[ways[:-1]].any() or (n > 0 and number[ways[-1]] >= 0):
            return None
        given[c] = ways
        step = loop[ways[-1]] - loop[i]
        height = float(step @ normal[sides[0]])
        if height <= 0:
            return None
        lean[c] = step / height
    last = np.roll(tangent, 1, axis=0)
    turn = np.abs(np.arctan2(cross(last, tangent), (last * tangent).sum(axis=1)))
    fixed = (turn[nodes] > _CORNER) | (given >= 0).any(axis=1)
    lean = _spread(nodes, after, lean, fixed, loop)
    return Columns(
        base=nodes,
        after=after,
        given=given,
        lean=lean,
        sine=np.minimum(sine, 1.0 / norm(lean)),
        reach=reach,
        first=first,
        growth=growth,
        room=np.full(len(nodes), np.inf),
    )


def _spread(nodes: IntArray, after: IntArray, lean: FloatArray, fixed: np.ndarray, loop: FloatArray) -> FloatArray:
    """Fade the lean of columns along the wall, from that of one corner to that of the next."""
    tangent = np.roll(loop, -1, axis=0) - loop
    steps = norm(tangent)
    tangent /= steps[:, None]
    out = lean.copy()
    for c in np.flatnonzero(fixed & (after >= 0)).tolist():
        run = [c]
        while after[run[-1]] >= 0 and (len(run) == 1 or not fixed[run[-1]]) and len(run) <= len(nodes):
            run.append(int(after[run[-1]]))
        if len(run) < 3 or not fixed[run[-1]]:
            continue
        segments = nodes[run[:-1]]
        share = np.cumsum(steps[segments]) / steps[segments].sum()
        begin, end = float(lean[run[0]] @ tangent[segments[0]]), float(lean[run[-1]] @ tangent[segments[-1]])
        for place, column, segment in zip(share[:-1], run[1:-1], segments[1:], strict=True):
            along = tangent[segment] + tangent[segment - 1]
            along /= np.linalg.norm(along)
            out[column] = lean[column] + ((1 - place) * begin + place * end) * along
    return out


def _room(loops: Sequence[FloatArray], walls: Sequence[Wall], columns: Columns) -> FloatArray:
    """How long each column may be, from what its line meets of the outline."""
    boundary = np.concatenate(loops)
    starts = boundary
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops])
    nexts = nexts_of(loops)
    before = np.argsort(nexts)
    share = np.where(np.concatenate([wall.n for wall in walls]) > 0, _BESIDE_WALL, _BESIDE_OTHERS)
    # Rows end at the edges that begin where a wall does: those are in nobody's way.
    ended = columns.given[(columns.given >= 0).all(axis=1)]
    beside = np.isin(np.arange(len(boundary)), ended)
    share = np.where(beside | beside[nexts], np.inf, share)
    room = np.full(len(columns.base), np.inf)
    direction = columns.lean / norm(columns.lean)[:, None]
    for c, i in enumerate(columns.base.tolist()):
        along, across = ends - starts, starts - boundary[i]
        turn = cross(np.broadcast_to(direction[c], along.shape), along)
        safe = np.where(np.abs(turn) > 1e-300, turn, np.inf)
        way = cross(across, along) / safe
        place = cross(across, np.broadcast_to(direction[c], along.shape)) / safe
        met = (way > 0) & (place >= -1e-9) & (place <= 1 + 1e-9)
        met[[i, before[i]]] = False
        met &= np.isfinite(share)
        room[c] = np.min(share[met] * way[met], initial=np.inf)
    return np.minimum(room, _room_beside(loops, share, columns.base, direction))


def _room_beside(loops: Sequence[FloatArray], share: FloatArray, base: IntArray, direction: FloatArray) -> FloatArray:
    """The same from the balls that touch the outline where a column begins, and reach another part of it."""
    boundary = np.concatenate(loops)
    owner = np.repeat(np.arange(len(loops)), [len(loop) for loop in loops])
    steps = [norm(np.roll(loop, -1, axis=0) - loop) for loop in loops]
    run = np.concatenate([np.cumsum(own) - own for own in steps])
    around = np.array([own.sum() for own in steps])
    room = np.full(len(base), np.inf)
    inward = np.concatenate([_inward_of(loop) for loop in loops])
    sides = _sides_of(loops)
    for c, i in enumerate(base.tolist()):
        step = boundary - boundary[i]
        ahead, distance = step @ direction[c], norm(step)
        way = np.abs(run - run[i])
        way = np.where(owner == owner[i], np.minimum(way, around[owner] - way), np.inf)
        # Near a corner the other wall is near, too, and the columns lean away from it. One that leans out over a tip
        # does not come nearer to the tip's other side.
        other = (ahead > 1e-9 * distance) & (way > _AROUND * distance) & (step @ inward[i] > 0.0)
        other &= np.isfinite(share) & ~_share_corner(sides, i)
        radius = distance[other] ** 2 / (2.0 * ahead[other])
        room[c] = np.min(2.0 * share[other] * radius, initial=np.inf)
    return room


def _inward_of(loop: FloatArray) -> FloatArray:
    """Vectors (m, 2) to the left of a loop at its nodes, halfway between those of both segments."""
    along = np.roll(loop, -1, axis=0) - loop
    along = along / norm(along)[:, None]
    along = along + np.roll(along, 1, axis=0)
    return np.stack([-along[:, 1], along[:, 0]], axis=1)


def _sides_of(loops: Sequence[FloatArray]) -> tuple[IntArray, IntArray]:
    """Numbers (m, 2) of the straight or curved sides before and behind every node, and the next side (s,) after each.

    A side that no convex corner joins to the one after it has none, -1.
    """
    before, behind, after = [], [], []
    first = 0
    for loop in loops:
        tangent = np.roll(loop, -1, axis=0) - loop
        last = np.roll(tangent, 1, axis=0)
        turn = np.arctan2(cross(last, tangent), (last * tangent).sum(axis=1))
        corner = np.abs(turn) > _CORNER
        n = max(int(corner.sum()), 1)
        # The side that runs across the first node is the last one.
        own = (np.cumsum(corner) - 1) % n
        behind.append(first + own)
        before.append(first + np.where(corner, (own - 1) % n, own))
        convex = np.roll(turn[corner] > 0, -1) if corner.any() else np.zeros(1, dtype=bool)
        after.append(np.where(convex, first + (np.arange(n) + 1) % n, -1))
        first += n
    return np.stack([np.concatenate(before), np.concatenate(behind)], axis=1), np.concatenate(after)


def _share_corner(sides: tuple[IntArray, IntArray], node: int) -> BoolArray:
    """Whether nodes (m,) are on a side that a convex corner joins to a node's own: columns lean out of that corner."""
    of, after = sides
    own = set(of[node].tolist())
    joined = {int(after[side]) for side in own} | {side for side, other in enumerate(after.tolist()) if other in own}
    return np.asarray(np.isin(of, sorted(joined - own)).any(axis=1))


def firsts(loops: Sequence[FloatArray]) -> list[int]:
    return [0, *np.cumsum([len(loop) for loop in loops])[:-1].tolist()]


def nexts_of(loops: Sequence[FloatArray]) -> IntArray:
    """Number of the node after each, in its loop."""
    return np.concatenate(
        [np.roll(np.arange(len(loop)), -1) + s for loop, s in zip(loops, firsts(loops), strict=True)]
    ).astype(np.int64)


def norm(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=-1))


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
