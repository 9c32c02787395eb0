"""The equations between counts of edges of a part of several cells, and their solution.

Place in the flow: :mod:`.whole` makes them of cells and wishes. Edges are known by their keys in the whole part; those
that must have equal counts are one unknown, and :class:`.programme.Programme` settles the unknowns.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ..corner_blocks import CornerBlocks
from ..disjoint import DisjointSets
from ..errors import SurfaceMeshError
from ..sweep import DirectedEdge, Sweep
from .balance import FIRM
from .cell_sweeps import CellSweep, KeyDemand, Wishes
from .levels import Levels, directed_ends, find_levels
from .loops import (
    across_wall,
    alike,
    even_by_symmetry,
    every_second_side,
    fan_sides,
    least_counts,
    opposite_sides,
    squeezes,
    submapped_sides,
    symmetric_sides,
)
from .patterns import nearly, ring_sides, stepped
from .programme import Programme


class Equations:
    """Which keys are one unknown, which sums vanish, and which are even."""

    def __init__(
        self,
        cells: Sequence[CellSweep],
        wanted: Mapping[int, float],
        wishes: Wishes,
        *,
        align: bool,
        firm: Collection[int],
    ) -> None:
        self.least = wishes.least_counts
        self.firm = firm
        self.most_least = dict(wishes.needed_counts)
        self.classes = DisjointSets(wanted)
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
        self.evens += [
            [int(cell.solid.edge_keys[e]) for e in own]
            for cell in cells
            for f in (cell.free if align else ())
            for own in every_second_side(cell.solid.faces[f])
        ]
        self.symmetric_evens = [
            [int(cell.solid.edge_keys[e]) for e in own]
            for cell in cells
            for f in (cell.free if align else ())
            for own in even_by_symmetry(cell.solid, f)
        ]
        for cell in cells:
            # Between others an edge of a small cap has what they want: more would go on through all of them.
            if cell.by_itself:
                self._need({int(cell.solid.edge_keys[e]): n for e, n in least_counts(cell.solid, cell.free).items()})

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
            choices = find_levels(cell.fill) if cell.by_itself else []
            if choices:
                levels = choices[0 if align else -1]
                pairs += level_pairs(levels)
                self._need({int(keys[e]): levels.least[pair] for e, pair in levels.rails.items()})
            else:
                ways = [way_up(cell.fill, loop) for loop in cell.fill.source_loops]
                pairs += [(ways[0], other) for other in ways[1:]]
        if align:
            own = {e.id: wanted[int(keys[e.id])] for e in solid.edges}
            pairs += [pair for f in cell.free for pair in opposite_sides(solid.faces[f].loops, own)]
            pairs += [pair for f in cell.free for pair in submapped_sides(solid.faces[f].loops, own)]
            pairs += [pair for f in cell.free for pair in fan_sides(solid.faces[f], own)]
            pairs += [pair for f in cell.free for pair in symmetric_sides(solid, f, own)]
            rings = [pair for f in cell.free for pair in ring_sides(solid, solid.faces[f], own)]
            if isinstance(cell.fill, Sweep):
                walls = [pair for f in cell.free for pair in across_wall(cell.fill, f, own)]
                # Rims that want very different counts would be made equal by what of them a neighbour has.
                rings += [pair for pair in walls if cell.by_itself or nearly(pair, own)]
            wished = {e for e in own if int(keys[e]) in self.firm}
            pairs += [] if any(squeezes(*pair, own, wished) for pair in rings) else rings
        for one, other in pairs:
            if len(one) == len(other) == 1:
                self.classes.merge(int(keys[one[0]]), int(keys[other[0]]))
            else:
                self.opposite.append(([int(keys[e]) for e in one], [int(keys[e]) for e in other]))

    def _need(self, least: Mapping[int, int]) -> None:
        """Segments that edges, by key, need at least."""
        for key, n in least.items():
            self.most_least[key] = max(n, self.most_least.get(key, 1))

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
        self,
        wanted: Mapping[int, float],
        firm: Collection[int],
        demands: Sequence[KeyDemand],
        steps: Mapping[int, int],
    ) -> dict[int, int] | None:
        """Counts by key, None where there are none. `steps`: what those of keys in patterns should be multiples of."""
        members: dict[int, list[int]] = {}
        for key in wanted:
            members.setdefault(self.classes.find(key), []).append(key)
        column = {root: j for j, root in enumerate(members)}
        of = {key: column[root] for root, keys in members.items() for key in keys}
        kept = {of[key] for key in firm}
        want, weight = [], []
        for keys in members.values():
            leading = [key for key in keys if key in firm] or keys
            mean = float(np.exp(np.mean(np.log([wanted[key] for key in leading]))))
            mean = max(mean, *(float(self.least.get(key, 0)) for key in keys))
            in_patterns = [steps[key] for key in keys if key in steps]
            want.append(max(1.0, round(mean)) if of[keys[0]] in kept else stepped(mean, in_patterns))
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
        asked = kept | {of[key] for demand in demands for key in demand.keys}
        sets = [*self.evens, *(keys for keys in self.symmetric_evens if not any(of[key] in asked for key in keys))]
        evens = [{j: n for j, n in Counter(of[key] for key in keys).items() if n % 2} for keys in sets]
        least: dict[int, int] = {}
        for key, n in self.most_least.items():
            least[of[key]] = max(n, least.get(of[key], 1))
        counts = Programme(
            want=np.array(want),
            weight=np.array(weight),
            demanded=demanded,
            firm=kept,
            sums=rows,
            evens=[odd for odd in evens if odd],
            least=least,
        ).solve()
        return None if counts is None else {key: counts[j] for key, j in of.items()}


def level_pairs(levels: Levels) -> list[tuple[list[int], list[int]]]:
    """Edges along a sweep whose counts have equal sums: those between two levels, and around all cycles of levels."""
    between: dict[tuple[int, int], list[int]] = {}
    for e, pair in levels.rails.items():
        between.setdefault(pair, []).append(e)
    pairs = [([own[0]], [other]) for own in between.values() for other in own[1:]]
    ways: dict[int, tuple[list[int], list[int]]] = {0: ([], [])}  # up and down, from the source
    left = dict(between)
    while left:
        step = next(((a, b) for a, b in left if a in ways or b in ways), None)
        if step is None:
            break  # levels that no chain of rails joins to the source: whoever lays the sides refuses them
        rail, (a, b) = left.pop(step)[0], step
        if a in ways and b in ways:
            (up, down), (other_up, other_down) = ways[a], ways[b]
            pairs.append(([*up, rail, *other_down], [*other_up, *down]))
        elif a in ways:
            ways[b] = ([*ways[a][0], rail], ways[a][1])
        else:
            ways[a] = (ways[b][0], [*ways[b][1], rail])
    return pairs


def way_up(sweep: Sweep, loop: Sequence[DirectedEdge]) -> list[int]:
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
