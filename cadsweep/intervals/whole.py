"""Counts of all edges of a part of several cells, each edge once.

Place in the flow: after ``plan`` has chosen a sweep for every cell, before the skeleton is meshed.

Method: edges are known by their keys in the whole part. Opposite sides of every logical rectangle have equal sums,
edges of two caps that answer each other equal counts, all loops of a cell equal layers, and the loops of faces that
get free quads even sums. What must be equal is one unknown (union-find); :class:`.programme.Programme` settles the
rest, each component of edges that hang together by itself.

Not handled: levels of stacked sides that two rails of one cell cross at different places; ``surface`` refuses them.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy

from ..brep import Solid
from ..corner_blocks import CornerBlocks
from ..errors import SurfaceMeshError
from ..sweep import DirectedEdge, Intervals, LinkingSide, Sweep
from .balance import FIRM
from .corner_counts import corner_counts, corner_size
from .demands import find_conflict
from .levels import directed_ends
from .loops import alike, loop_edges, opposite_sides, submapped_sides
from .programme import Programme
from .sizes import (
    MOST_HEXES,
    SEGMENTS_ACROSS,
    SEGMENTS_AROUND,
    TURN_LAYER,
    TURN_SIZED,
    WANTED_HEXES,
    path_length,
    size_for,
    turning,
    wanted_counts,
)

LEAST_SHARE = 0.02
"""Share of the hexes that the smallest cell may have for its features, however small its volume is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CellSweep:
    """What the counts of one cell depend on.

    Attributes
    ----------
    fill : Sweep or CornerBlocks
    grids : tuple of LinkingSide
        All faces that are logical rectangles: the linking sides, and caps that are.
    free : tuple of int
        Faces that get free quads; their loops need even sums.
    """

    fill: Sweep | CornerBlocks
    grids: tuple[LinkingSide, ...]
    free: tuple[int, ...] = ()

    @property
    def solid(self) -> Solid:
        """The cell."""
        return self.fill.solid


@dataclass(frozen=True, kw_only=True, eq=False)
class KeyDemand:
    """A count demanded of edges together, by key; `label` says who wants it."""

    keys: tuple[int, ...]
    count: int
    label: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Wishes:
    """What the user asks for, working units.

    Attributes
    ----------
    size : float or None
    layers : int or None
        Layers that every cell should have along its own sweep.
    cell_sizes : mapping of cell to float
    edge_sizes : mapping of edge key to float
    most_sizes : mapping of edge key to float
        What edges may have at most, where nothing else makes them finer.
    least_counts : mapping of edge key to int
        Segments that edges should have at least.
    demands : sequence of KeyDemand
    alike : sequence of (int, int, bool)
        Edges with as many segments as each other, by key, and whether they run alike.
    """

    size: float | None = None
    layers: int | None = None
    cell_sizes: Mapping[int, float] = field(default_factory=dict)
    edge_sizes: Mapping[int, float] = field(default_factory=dict)
    most_sizes: Mapping[int, float] = field(default_factory=dict)
    least_counts: Mapping[int, int] = field(default_factory=dict)
    demands: Sequence[KeyDemand] = ()
    alike: Sequence[tuple[int, int, bool]] = ()


def assign_shared_intervals(cells: Sequence[CellSweep], wishes: Wishes) -> list[Intervals]:
    """Choose the number of segments of every edge of every cell; shared edges get one number.

    Returns
    -------
    list of Intervals
        By cell, by its own edge ids.

    Raises
    ------
    SurfaceMeshError
        No counts fit; names the demands that contradict each other, or the faces.
    """
    sizes = cell_sizes(cells, wishes)
    wanted, firm = _wanted(cells, sizes, wishes)
    counts = _settled(cells, wanted, firm, wishes.demands, wishes)
    if counts is None:
        guilty = find_conflict(wishes.demands, lambda some: _settled(cells, wanted, firm, some, wishes) is not None)
        if guilty:
            named = "; ".join(demand.label for demand in guilty)
            raise SurfaceMeshError(f"no mesh of the whole part has the counts demanded: {named}; drop one of them")
        raise SurfaceMeshError(
            "no counts of segments fit all cells of the part: the sides of some cell cannot have equal sums; "
            "try --interfaces separate, or other cuts"
        )
    return [_intervals_of(cell, counts, sizes[i]) for i, cell in enumerate(cells)]


def cell_sizes(cells: Sequence[CellSweep], wishes: Wishes) -> list[float]:
    """Target edge length of every cell, working units.

    Without a wish: what gives the whole part some thousand hexes, less where a cell has small features, as long as
    the whole stays below some ten thousand.
    """
    volumes = np.array([cell.solid.volume for cell in cells])
    total = float(volumes.sum())
    n_wanted = min(float(MOST_HEXES), WANTED_HEXES * len(cells) ** 0.5)
    common = (total / n_wanted) ** (1.0 / 3.0)
    sizes = []
    for i, cell in enumerate(cells):
        size = wishes.cell_sizes.get(i, wishes.size)
        if size is None:
            share = max(float(volumes[i]) / total, LEAST_SHARE)
            if isinstance(cell.fill, CornerBlocks):
                sizes.append(corner_size(cell.fill, common, MOST_HEXES * share))
                continue
            sweep = cell.fill
            area = sum(cell.solid.faces[f].area for f in sweep.source)
            perimeters = [sum(cell.solid.edges[e].length for e, _ in loop) for loop in sweep.source_loops]
            feature = min(2.0 * area / sum(perimeters) / SEGMENTS_ACROSS, *(p / SEGMENTS_AROUND for p in perimeters))
            size = min(common, max(feature, size_for(area, path_length(sweep), MOST_HEXES * share)))
        sizes.append(float(size))
    return sizes


def _wanted(cells: Sequence[CellSweep], sizes: Sequence[float], wishes: Wishes) -> tuple[dict[int, float], set[int]]:
    """Wanted count of every edge key, the greatest of what its cells want; and the keys that the user has sized."""
    wanted: dict[int, float] = {}
    firm: set[int] = set()
    for i, cell in enumerate(cells):
        sized = wishes.size is not None or i in wishes.cell_sizes
        keys = cell.solid.edge_keys
        if isinstance(cell.fill, CornerBlocks):
            own = corner_counts(cell.fill, sizes[i], sized=sized)
        else:
            own = wanted_counts(cell.fill, loop_edges(cell.fill), sizes[i], {}, sized=sized)
            own |= _rail_counts(cell.fill, sizes[i], wishes.layers, sized=sized)
            if wishes.layers is not None:
                firm.update(int(keys[e]) for e in cell.fill.rails)
        for e, n in own.items():
            wanted[int(keys[e])] = max(n, wanted.get(int(keys[e]), 1.0))
        for edge in cell.solid.edges:
            key = int(keys[edge.id])
            if key in wishes.least_counts:
                wanted[key] = max(wanted[key], float(wishes.least_counts[key]))
                firm.add(key)
            if key in wishes.most_sizes and edge.length / wishes.most_sizes[key] > wanted[key]:
                wanted[key] = edge.length / wishes.most_sizes[key]
                firm.add(key)
            if key in wishes.edge_sizes:
                wanted[key] = max(1.0, edge.length / wishes.edge_sizes[key])
                firm.add(key)
    for demand in wishes.demands:
        for key in demand.keys:
            wanted[key] = max(1.0, demand.count / len(demand.keys))
            firm.add(key)
    return wanted, firm


def _rail_counts(sweep: Sweep, size: float, layers: int | None, *, sized: bool) -> dict[int, float]:
    """Wanted layers of every rail: its share of those of the whole way."""
    solid = sweep.solid
    if layers is not None:
        n = float(layers)
    else:
        turn = max(sum(max(turning(solid, solid.edges[e]) for e in span) for span in loop) for loop in sweep.spans)
        n = max(path_length(sweep) / size, 1.0 if sized else 2.0, turn / (TURN_SIZED if sized else TURN_LAYER))
    totals = {e: sum(ls) for loop, ls in zip(sweep.spans, sweep.span_lengths, strict=True) for s in loop for e in s}
    return {e: max(1.0, n * solid.edges[e].length / totals[e]) for e in sweep.rails}


def _settled(
    cells: Sequence[CellSweep],
    wanted: Mapping[int, float],
    firm: Collection[int],
    demands: Sequence[KeyDemand],
    wishes: Wishes,
) -> dict[int, int] | None:
    """Counts by key, None where there are none: with alike edges tied if that can be, else without."""
    for align in (True, False):
        counts = _Equations(cells, wanted, wishes, align=align).solve(wanted, firm, demands)
        if counts is not None:
            return counts
    return None


class _Equations:
    """Which keys are one unknown, which sums vanish, and which are even."""

    def __init__(
        self,
        cells: Sequence[CellSweep],
        wanted: Mapping[int, float],
        wishes: Wishes,
        *,
        align: bool,
    ) -> None:
        self.least = wishes.least_counts
        self.classes = scipy.cluster.hierarchy.DisjointSet(wanted)
        for a, b, _ in wishes.alike:
            self.classes.merge(a, b)
        self.opposite: list[tuple[list[int], list[int]]] = []
        self.crossed: list[tuple[list[int], tuple[int, int], tuple[int, int]]] = []
        for i, cell in enumerate(cells):
            self._tie_cell(cell, wanted, align=align)
            if isinstance(cell.fill, CornerBlocks):
                self.crossed += [
                    ([int(cell.solid.edge_keys[e]) for e, _ in chain], (i, start), (i, end))
                    for chain, (start, end) in zip(cell.fill.chains, cell.fill.across, strict=True)
                ]
        self.evens = [
            [int(cell.solid.edge_keys[e]) for e in loop.edges]
            for cell in cells
            for f in cell.free
            for loop in cell.solid.faces[f].loops
        ]

    def _tie_cell(self, cell: CellSweep, wanted: Mapping[int, float], *, align: bool) -> None:
        solid, keys = cell.solid, cell.solid.edge_keys
        pairs: list[tuple[list[int], list[int]]] = []
        for grid in cell.grids:
            for near, far in ((grid.bottom, grid.top), (grid.left, grid.right)):
                if align and len(near) == len(far) > 1 and alike(solid, near, far):
                    pairs += [([a], [b]) for (a, _), (b, _) in zip(near, far, strict=True)]
                else:
                    pairs.append(([e for e, _ in near], [e for e, _ in far]))
        if isinstance(cell.fill, Sweep):
            pairs += [([a], [b]) for a, (b, _) in cell.fill.target_edges.items()]
            ways = [_way_up(cell.fill, loop) for loop in cell.fill.source_loops]
            pairs += [(ways[0], other) for other in ways[1:]]
        if align:
            own = {e.id: wanted[int(keys[e.id])] for e in solid.edges}
            pairs += [pair for f in cell.free for pair in opposite_sides(solid.faces[f].loops, own)]
            pairs += [pair for f in cell.free for pair in submapped_sides(solid.faces[f].loops, own)]
        for one, other in pairs:
            if len(one) == len(other) == 1:
                self.classes.merge(int(keys[one[0]]), int(keys[other[0]]))
            else:
                self.opposite.append(([int(keys[e]) for e in one], [int(keys[e]) for e in other]))

    def _cross(
        self,
        of: Mapping[int, int],
        wanted: Mapping[int, float],
        want: list[float],
        weight: list[float],
        rows: list[dict[int, float]],
    ) -> None:
        """Add the sheets of cells with a block at every corner to the unknowns, and the sums that they make."""
        sheets: dict[tuple[int, int], int] = {}
        halves: dict[tuple[int, int], list[float]] = {}
        for keys, *both in self.crossed:
            for sheet in both:
                halves.setdefault(sheet, []).append(0.5 * sum(wanted[key] for key in keys))
        for keys, *both in self.crossed:
            # Segments of a chain are as many as the two sheets that it crosses are thick.
            crossing = {j: float(n) for j, n in Counter(of[key] for key in keys).items()}
            for sheet in both:
                if sheet not in sheets:
                    sheets[sheet] = len(want)
                    # Blocks are well shaped where they meet half way along every chain.
                    mean = float(np.mean(halves[sheet]))
                    want.append(mean)
                    weight.append(len(halves[sheet]) / mean)
                crossing[sheets[sheet]] = crossing.get(sheets[sheet], 0.0) - 1.0
            rows.append(crossing)

    def solve(
        self, wanted: Mapping[int, float], firm: Collection[int], demands: Sequence[KeyDemand]
    ) -> dict[int, int] | None:
        """Counts by key, None where there are none."""
        members: dict[int, list[int]] = {}
        for key in wanted:
            members.setdefault(self.classes[key], []).append(key)
        column = {root: j for j, root in enumerate(members)}
        of = {key: column[root] for root, keys in members.items() for key in keys}
        kept = {of[key] for key in firm}
        want, weight = [], []
        for keys in members.values():
            leading = [key for key in keys if key in firm] or keys
            mean = float(np.exp(np.mean(np.log([wanted[key] for key in leading]))))
            mean = max(mean, *(float(self.least.get(key, 0)) for key in keys))
            want.append(max(1.0, round(mean)) if of[keys[0]] in kept else mean)
            weight.append(len(keys) / mean * (FIRM if of[keys[0]] in kept else 1.0))
        rows: list[dict[int, float]] = []
        for one, other in self.opposite:
            row: Counter[int] = Counter()
            for sign, keys in ((1, one), (-1, other)):
                for key in keys:
                    row[of[key]] += sign
            if any(row.values()):
                rows.append({j: float(v) for j, v in row.items() if v})
        self._cross(of, wanted, want, weight, rows)
        demanded: dict[int, int] = {}
        for demand in demands:
            parts = Counter(of[key] for key in demand.keys)
            if list(parts.values()) == [1]:
                if demanded.setdefault(next(iter(parts)), demand.count) != demand.count:
                    return None
                continue
            # The sum of several edges is one more unknown, whose count is known.
            rows.append({**{j: float(n) for j, n in parts.items()}, len(want): -1.0})
            demanded[len(want)] = demand.count
            want.append(float(demand.count))
            weight.append(0.0)
        evens = [{j: n for j, n in Counter(of[key] for key in keys).items() if n % 2} for keys in self.evens]
        counts = Programme(
            want=np.array(want),
            weight=np.array(weight),
            demanded=demanded,
            firm=kept,
            sums=rows,
            evens=[odd for odd in evens if odd],
        ).solve()
        return None if counts is None else {key: counts[j] for key, j in of.items()}


def _way_up(sweep: Sweep, loop: Sequence[DirectedEdge]) -> list[int]:
    """Rails of a way from a source loop to the target: up along rails, level along edges around the loops."""
    solid = sweep.solid
    up: dict[int, list[DirectedEdge]] = {}
    level: dict[int, list[int]] = {}
    for side in sweep.linking_sides:
        for rail in (*side.left, *side.right):
            up.setdefault(directed_ends(solid, rail)[0], []).append(rail)
        for around in (*side.bottom, *side.top):
            a, b = directed_ends(solid, around)
            level.setdefault(a, []).append(b)
            level.setdefault(b, []).append(a)
    goals = {directed_ends(solid, d)[0] for ring in sweep.target_loops for d in ring}
    start = directed_ends(solid, loop[0])[0]
    came: dict[int, tuple[int, int | None]] = {start: (start, None)}
    waiting = [start]
    while waiting:
        vertex = waiting.pop(0)
        if vertex in goals:
            way: list[int] = []
            while vertex != start:
                vertex, below = came[vertex]
                if below is not None:
                    way.append(below)
            return way
        for rail in up.get(vertex, ()):
            end = directed_ends(solid, rail)[1]
            if end not in came:
                came[end] = (vertex, rail[0])
                waiting.append(end)
        for other in level.get(vertex, ()):
            if other not in came:
                came[other] = (vertex, None)
                waiting.append(other)
    raise SurfaceMeshError(f"no rail leads from the source to the target above {solid.edges[loop[0][0]].label()}")


def _intervals_of(cell: CellSweep, counts: Mapping[int, int], size: float) -> Intervals:
    sweep = cell.fill
    own = np.array([counts[int(key)] for key in cell.solid.edge_keys], dtype=np.int64)
    if isinstance(sweep, CornerBlocks):
        return Intervals(counts=own, n_layers=0, size=size)
    n_layers = int(sum(own[e] for e in _way_up(sweep, sweep.source_loops[0])))
    return Intervals(counts=own, n_layers=n_layers, size=size, span_layers=tuple((n_layers,) for _ in sweep.spans))
