"""Caps that go on into each other, and which of them must lie over which.

Place in the flow: before :mod:`.levels`.

Method: caps joined by an edge without a wall are one *sheet*, and so are flat caps and level stations of one height;
another station is a sheet of its own. Two caps of one sheet may lie over each other where there is nothing between
them: a passage whose floor and roof meet at its edges is a crack between two layers that stands open. At every vertex
of the arrangement, and in the middle of every edge, the sheets of all cells there are sorted by height: the same height
must be one sheet, another height another level, but for cracks. A node is then known by its place and its level alone,
whatever cells it is in.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray
from ..brep import Face
from ..disjoint import DisjointSets
from ..errors import NotSweepableError
from ..stack import Stack
from .along import heights_on_cap, heights_on_edge

TOLERANCE = 1e-6
"""Heights nearer to each other than this, in sizes of the part, are the same."""
_FLAT = 1e-9
_ALONG = np.linspace(0.0, 1.0, 9)
"""Where it is looked whether a station is level."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sheets:
    """What levels are assigned to.

    Attributes
    ----------
    caps, stations : dict of int to int
        Sheet of every cap, and of every station edge.
    heights : (n_sheets,) float64
        Mean height.
    over : dict of (int, int) to str
        Pairs (lower, upper) of sheets with at least a layer between them, and a place where they lie so.
    spans : dict of (int, int) to list of (float, float)
        Pairs of sheets with material and nothing else between them: how far apart, along which length.
    """

    caps: dict[int, int]
    stations: dict[int, int]
    heights: FloatArray
    over: dict[tuple[int, int], str] = field(default_factory=dict)
    spans: dict[tuple[int, int], list[tuple[float, float]]] = field(default_factory=dict)


def find_sheets(stack: Stack) -> Sheets:
    """Group the caps of a stack to sheets and compare their heights wherever they meet.

    Raises
    ------
    NotSweepableError
        Layers cannot follow the caps: a wall or a column runs out to nothing; says where.
    """
    tolerance = TOLERANCE * stack.solid.size + 2.0 * stack.solid.tolerance
    table = _Places(stack)
    n_faces = len(stack.solid.faces)
    union = DisjointSets(range(n_faces + len(stack.solid.edges)))
    sides = dict.fromkeys(stack.source, -1) | dict.fromkeys(stack.target, 1)
    for edge in stack.solid.edges:
        a, b = edge.faces
        if a in sides and b in sides:
            union.merge(a, b)
    _join_flat(stack, union, tolerance)
    _join_meeting(stack, table, union, sides, tolerance)
    # Sheets are numbered by their least cap or station, whatever the order in which they were joined.
    roots = list(dict.fromkeys(union.find(item) for item in sorted([*sides, *(n_faces + e for e in stack.stations)])))
    number = {root: j for j, root in enumerate(roots)}
    caps = {f: number[union.find(f)] for f in sides}
    stations = {e: number[union.find(n_faces + e)] for e in stack.stations}
    sums = np.zeros((2, len(roots)))
    found = Sheets(caps=caps, stations=stations, heights=np.zeros(len(roots)))
    for place in [*table.vertices, *table.middles]:
        groups = table.groups(place, tolerance)
        levels = [(number[union.find(group[0][1])], sum(h for h, _ in group) / len(group), group) for group in groups]
        for (low, bottom, one), (high, top, other) in pairwise(levels):
            if low == high:
                if table.has_material(place, (bottom + top) / 2.0):
                    where = stack.solid.units.place(table.points[place] + (bottom + top) / 2.0 * stack.direction)
                    below, above = _label(stack, one[0][1]), _label(stack, other[0][1])
                    raise NotSweepableError(
                        f"the wall between {below} and {above} at ({where}) runs out to a point, where they meet"
                    )
                continue
            if (low, high) not in found.over:
                where = stack.solid.units.place(table.points[place] + bottom * stack.direction)
                found.over[low, high] = where
            if place in table.weights and table.has_material(place, (bottom + top) / 2.0):
                found.spans.setdefault((low, high), []).append((top - bottom, table.weights[place]))
        for sheet, height, _ in levels:
            sums[:, sheet] += (height, 1.0)
    found.heights[:] = sums[0] / np.maximum(sums[1], 1.0)
    _refuse_flat_columns(stack, caps)
    return found


def told_heights(stack: Stack, sheets: Sheets) -> FloatArray:
    """Heights (n_sheets,) as a user knows them: of the widest flat cap of each sheet, else the mean."""
    heights, widest = sheets.heights.copy(), np.zeros(len(sheets.heights))
    for face, sheet in ((stack.solid.faces[f], sheet) for f, sheet in sheets.caps.items()):
        if is_flat(face, stack.direction) and face.area > widest[sheet]:
            heights[sheet], widest[sheet] = float(face.center @ stack.direction), face.area
    return heights


def is_flat(face: Face, direction: FloatArray) -> bool:
    """Whether a cap lies across the direction."""
    return face.kind == "plane" and bool(abs(face.normal @ direction) > 1.0 - _FLAT)


def _join_meeting(
    stack: Stack, table: _Places, union: DisjointSets[int], sides: dict[int, int], tolerance: float
) -> None:
    """Join caps that meet along a line, and refuse those that meet in a point alone."""
    for place in [*table.middles, *table.vertices]:
        for group in table.groups(place, tolerance):
            height, first = group[0]
            for _, item in group[1:]:
                if union.find(item) == union.find(first):
                    continue
                if place in table.weights and item in sides and sides[item] == sides.get(first):
                    union.merge(item, first)
                    continue
                where = stack.solid.units.place(table.points[place] + height * stack.direction)
                one, other = _label(stack, first), _label(stack, item)
                raise NotSweepableError(
                    f"{one} and {other} meet in a point at ({where}), where the wall between them runs out"
                )


def _refuse_flat_columns(stack: Stack, caps: dict[int, int]) -> None:
    """Refuse a column whose two caps are one sheet."""
    faces = stack.solid.faces
    for a, b in (column for columns in stack.columns for column in columns):
        if caps[a] == caps[b]:
            raise NotSweepableError(
                f"{faces[a].label()} and {faces[b].label()} lie over each other and are joined around their column"
            )


def _label(stack: Stack, item: int) -> str:
    n = len(stack.solid.faces)
    return stack.solid.faces[item].label() if item < n else stack.solid.edges[item - n].label()


def _join_flat(stack: Stack, union: DisjointSets[int], tolerance: float) -> None:
    """Flat caps, and stations, of one height are one sheet: their levels can follow their heights."""
    flat = [
        (float(face.center @ stack.direction), face.id)
        for face in (stack.solid.faces[f] for f in (*stack.source, *stack.target))
        if is_flat(face, stack.direction)
    ]
    for e in stack.stations:
        heights = stack.solid.edges[e].curve.evaluate(_ALONG) @ stack.direction
        if np.ptp(heights) <= tolerance:
            flat.append((float(heights.mean()), len(stack.solid.faces) + e))
    flat.sort()
    for (a, f), (b, g) in pairwise(flat):
        if b - a <= tolerance:
            union.merge(f, g)


class _Places:
    """Heights of caps and stations over the vertices and the middles of the edges of the arrangement."""

    def __init__(self, stack: Stack) -> None:
        arrangement = stack.arrangement
        prism = arrangement.prism
        edges = list(arrangement.over)
        ends = [(prism.edges[e].start, prism.edges[e].end) for e in edges]
        used = sorted({v for pair in ends for v in pair})
        number = {v: j for j, v in enumerate(used)}
        self.vertices = range(len(used))
        self.middles = range(len(used), len(used) + len(edges))
        points = np.concatenate([prism.vertices[used], [prism.edges[e].midpoint for e in edges]])
        # Only the place matters: heights are measured from the origin along the direction.
        self.points = points - np.outer(points @ stack.direction, stack.direction)
        self.weights = {len(used) + j: prism.edges[e].length for j, e in enumerate(edges)}
        self._items: list[list[tuple[float, int]]] = [[] for _ in points]
        self._columns: dict[int, list[tuple[int, int]]] = {}
        place_of = {e: len(used) + j for j, e in enumerate(edges)}
        ends_of = {e: [place_of[e], *(number[v] for v in pair)] for e, pair in zip(edges, ends, strict=True)}
        rims = stack.rims
        at_cap: dict[int, set[int]] = {}
        for f, caps, columns in zip(arrangement.bottoms, arrangement.caps, stack.columns, strict=True):
            here: set[int] = set()
            for e in prism.faces[f].edges:
                here |= {place_of[e], number[prism.edges[e].start], number[prism.edges[e].end]}
            for place in here:
                self._columns.setdefault(place, []).extend(columns)
            for cap in caps:
                at_cap.setdefault(cap, set()).update(here)
        self._heights: dict[tuple[int, int], float] = {}
        for cap, some in at_cap.items():
            ids = sorted(some)
            face = stack.solid.faces[cap]
            curved = [] if face.kind == "plane" else rims[cap]
            own = [(stack.solid.edges[one], np.searchsorted(ids, ends_of[e])) for one, e in curved]
            heights = heights_on_cap(face, stack.direction, self.points[ids], own)
            for place, height in zip(ids, heights.tolist(), strict=True):
                self._items[place].append((height, cap))
                self._heights[place, cap] = height
        n_faces = len(stack.solid.faces)
        for e, over in arrangement.over.items():
            for station in set(over) & set(stack.stations):
                ids = [place_of[e], number[prism.edges[e].start], number[prism.edges[e].end]]
                heights = heights_on_edge(stack.solid.edges[station], stack.direction, self.points[ids])
                for place, height in zip(ids, heights.tolist(), strict=True):
                    if (place, n_faces + station) not in self._heights:
                        self._heights[place, n_faces + station] = height
                        self._items[place].append((height, n_faces + station))
        for items in self._items:
            items.sort()

    def groups(self, place: int, tolerance: float) -> list[list[tuple[float, int]]]:
        """Caps and stations at a place, lowest first, those of one height together."""
        found: list[list[tuple[float, int]]] = []
        for height, item in self._items[place]:
            if found and height - found[-1][-1][0] <= tolerance:
                found[-1].append((height, item))
            else:
                found.append([(height, item)])
        return found

    def has_material(self, place: int, height: float) -> bool:
        """Whether one of the cells at a place has material there in this height."""
        return any(self._heights[place, a] < height < self._heights[place, b] for a, b in self._columns.get(place, ()))
