r"""Rows of quads along the walls of a section, whose heights are asked for.

Place in the flow: ``filling`` lays them in a chart of the cap's face before it fills what is left.

Method: a column of nodes begins at every node of a wall and goes inward, so that its nodes have their heights from
both segments beside it. At a corner, convex or re-entrant, that is along the bisector; between corners the lean of the
columns fades from that of one corner to that of the other, so that they spread evenly and do not cross::

        o--o--o--o--o          a wall that ends at another edge: its rows
        |\ |  |  | /|          end at nodes of that edge, which is divided
        | i--i--i-i |          so that they have the rows' heights
        | |  |  | | |

Where another part of the outline is near, columns are shorter: the layers grow less, and only where that does not do
the first one is thinner, too. Columns whose quads would fold are shortened until they do not.

Corners sharper than some 8 degrees have thin layers around them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..asked import WallLayers, growth_sum, layer_heights
from ..polygons import signed_area
from .crossings import loops_cross
from .wall_columns import Columns, Wall, cross, firsts, make_columns, norm

_SLOPE = 0.5
"""Change of the thickness along the wall, per length."""
_LEAST_SINE = 0.15
"""Corner sine of a quad of the rows below which its columns are shortened; less between columns that lean as much."""
_OF_LEAN = 0.8
"""Part of the sine between a leaning column and its wall that the corners of its quads must have."""
_SHORTENED = 0.75
"""Part of its height that a folded column keeps in a round."""
_NEAR = 0.3
"""Part of its room from which on a column is looked at where rows run into each other."""
_ROUNDS = 40
"""Rounds of shortening: a column then has a hundred-thousandth of its height. Where rows run into each other those near
are shortened one after the other, so that a corner of 6 degrees takes 20."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Walls:
    """Which edges of the source cap are walls.

    Attributes
    ----------
    layers : mapping of int to WallLayers
        By edge, heights in working units.
    faces : frozenset of int
        The walls above them.
    """

    layers: Mapping[int, WallLayers]
    faces: frozenset[int]


@dataclass(frozen=True, kw_only=True, eq=False)
class LaidRows:
    """Rows of quads; ids run through the loops' nodes, then `inner`.

    Attributes
    ----------
    inner : (p, 2) float64
    quads : (q, 4) int64
        Counter-clockwise.
    left : tuple of int64 arrays
        Loops of what is left to be filled.
    base : (c,) int64
        Node of the outline at which each column of new nodes begins.
    nodes : (c, n) int64
    first, growth, room : (c,) float64
        What is asked of the columns, and how long they may be.
    lean : (c, 2) float64
        Step of a column for a height of one.
    heights : (c, n) float64
    thinned : (c,) bool
        Whether columns have less than is asked for in all.
    kept : (c,) float64
        First height over the one that is asked for.
    """

    inner: FloatArray
    quads: IntArray
    left: tuple[IntArray, ...]
    base: IntArray
    nodes: IntArray
    first: FloatArray
    growth: FloatArray
    room: FloatArray
    lean: FloatArray
    heights: FloatArray
    thinned: BoolArray
    kept: FloatArray


def lay_walls(loops: Sequence[FloatArray], walls: Sequence[Wall], n: int) -> LaidRows | None:
    """Lay n rows of quads along the walls of a polygon.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, holes clockwise.
    walls : sequence of Wall
        By loop; all walls have `n` layers.

    Returns
    -------
    LaidRows, or None where there is no room for the rows
    """
    columns = make_columns(loops, walls, n)
    if columns is None:
        return None
    boundary = np.concatenate(loops)
    thickness = np.minimum(columns.first * growth_sum(columns.growth, n), columns.room / norm(columns.lean))
    open_ = (columns.given < 0).all(axis=1)
    new = np.flatnonzero(open_)
    ids = columns.given.copy()
    ids[new] = len(boundary) + np.arange(len(new) * n).reshape(-1, n)
    along = np.flatnonzero(columns.after >= 0)
    before = np.concatenate([columns.base[:, None], ids], axis=1)
    quads = np.stack(
        [before[along, :-1], before[columns.after[along], :-1], before[columns.after[along], 1:], before[along, 1:]],
        axis=-1,
    )
    left = _left_loops(loops, walls, columns, before[:, -1], n)
    least = np.minimum(_LEAST_SINE, _OF_LEAN * np.minimum(columns.sine[along], columns.sine[columns.after[along]]))
    for _ in range(_ROUNDS):
        thickness = _even(boundary[columns.base], columns.after, thickness)
        heights = layer_heights(columns.first, columns.growth, n, thickness)
        inner = (boundary[columns.base[new], None] + heights[new, :, None] * columns.lean[new, None]).reshape(-1, 2)
        points = np.concatenate([boundary, inner])
        sines = _least_sines(points[quads.reshape(-1, 4)]).reshape(len(along), n).min(axis=1)
        folded = np.zeros(len(thickness), dtype=bool)
        for of in (along, columns.after[along]):
            folded[of[sines < least]] = True
        folded &= open_
        rest = [points[loop] for loop in left]
        crossed = sum(map(signed_area, rest)) <= 0 or loops_cross(rest)
        if not folded.any() and not crossed:
            wanted = columns.first * growth_sum(columns.growth, n)
            return LaidRows(
                inner=inner,
                quads=quads.reshape(-1, 4),
                left=tuple(left),
                base=columns.base[new],
                nodes=ids[new],
                first=(columns.first * columns.reach)[new],
                growth=columns.growth[new],
                room=np.minimum(columns.room, np.where(thickness < wanted, thickness * norm(columns.lean), np.inf))[
                    new
                ],
                lean=columns.lean[new],
                heights=heights[new],
                thinned=heights[new, -1] < (1 - 1e-9) * wanted[new],
                kept=(heights[:, 0] / columns.first * columns.reach)[new],
            )
        if crossed:  # where others are near, if they are anywhere
            near = thickness * norm(columns.lean) > _NEAR * columns.room
            folded |= near if near.any() else True
        thickness = np.where(folded, _SHORTENED * thickness, thickness)
    return None


def lay_all_walls(loops: Sequence[FloatArray], walls: Sequence[Wall]) -> list[LaidRows] | None:
    """Lay the rows of walls of any numbers of layers, those of one number after those of another.

    Returns
    -------
    list of LaidRows
        The ids of each run through the loops' nodes, then the inner nodes of all of them in order; the last one's
        loops are what is left. None where there is no room.
    """
    points = np.concatenate(loops)
    left = [np.arange(len(loop), dtype=np.int64) + s for loop, s in zip(loops, firsts(loops), strict=True)]
    of_segment = {
        (int(a), int(b)): (wall, i)
        for ids, wall in zip(left, walls, strict=True)
        for i, (a, b) in enumerate(zip(ids, np.roll(ids, -1), strict=True))
    }
    laid: list[LaidRows] = []
    for n in sorted({int(n) for wall in walls for n in wall.n if n}):
        own = []
        for ids in left:
            known = [of_segment.get((int(a), int(b))) for a, b in zip(ids, np.roll(ids, -1), strict=True)]
            is_wall = np.array([pair is not None and int(pair[0].n[pair[1]]) == n for pair in known])
            own.append(
                Wall(
                    n=np.where(is_wall, n, 0),
                    first=np.array([pair[0].first[pair[1]] if pair is not None else 0.0 for pair in known]),
                    growth=np.array([pair[0].growth[pair[1]] if pair is not None else 1.0 for pair in known]),
                )
            )
        rows = lay_walls([points[ids] for ids in left], own, n)
        if rows is None:
            return None
        number = np.concatenate([*left, len(points) + np.arange(len(rows.inner), dtype=np.int64)])
        points = np.concatenate([points, rows.inner])
        left = [number[loop] for loop in rows.left]
        laid.append(
            replace(rows, quads=number[rows.quads], left=tuple(left), base=number[rows.base], nodes=number[rows.nodes])
        )
    return laid


def _even(places: FloatArray, after: IntArray, thickness: FloatArray) -> FloatArray:
    """Thickness that changes no faster than `_SLOPE` along the walls."""
    out = thickness.copy()
    columns = np.flatnonzero(after >= 0)
    nexts = after[columns]
    rise = _SLOPE * norm(places[nexts] - places[columns])
    for _ in range(len(out)):
        old = out.copy()
        np.minimum.at(out, nexts, old[columns] + rise)
        np.minimum.at(out, columns, old[nexts] + rise)
        if np.array_equal(out, old):
            break
    return out


def _left_loops(
    loops: Sequence[FloatArray], walls: Sequence[Wall], columns: Columns, inner: IntArray, n: int
) -> list[IntArray]:
    """Loops of what the rows leave: the innermost nodes of the columns, and the outline where there is no wall."""
    image = dict(zip(columns.base.tolist(), inner.tolist(), strict=True))
    taken = {node for column, base in zip(columns.given.tolist(), columns.base.tolist(), strict=True)
             for node in [base, *column[:-1]] if column[0] >= 0}  # fmt: skip
    found = []
    for loop, start in zip(loops, firsts(loops), strict=True):
        ids: list[int] = []
        for node in range(start, start + len(loop)):
            place = image.get(node)
            if place is None and node not in taken:
                place = node
            if place is not None and (not ids or ids[-1] != place):
                ids.append(place)
        if len(ids) > 1 and ids[0] == ids[-1]:
            ids.pop()
        found.append(np.array(ids, dtype=np.int64))
    return found


def _least_sines(corners: FloatArray) -> FloatArray:
    """Least corner sine (q,) of quads (q, 4, 2)."""
    step = np.roll(corners, -1, axis=1) - corners
    step /= np.maximum(norm(step), 1e-300)[..., None]
    sines: FloatArray = cross(np.roll(step, 1, axis=1), step).min(axis=1)
    return sines
