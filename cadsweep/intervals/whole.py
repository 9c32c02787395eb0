"""Counts of all edges of a part of several cells, each edge once.

Place in the flow: after ``plan`` has chosen a sweep for every cell, before the skeleton is meshed.

Method: edges are known by their keys in the whole part. Opposite sides of every logical rectangle have equal sums,
edges of two caps that answer each other equal counts, all loops of a cell equal layers, and the loops of faces that
get free quads even sums. What must be equal is one unknown (union-find); :class:`.programme.Programme` settles the
rest, each component of edges that hang together by itself.

Not handled: levels of stacked sides that two rails of one cell cross at different places; ``surface`` refuses them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import lcm, pi, radians

import numpy as np

from ..arrays import IntArray
from ..corner_blocks import CornerBlocks
from ..errors import CadSweepError, InputError, SurfaceMeshError
from ..sweep import Intervals, Sweep
from .cell_sweeps import CellSweep, KeyDemand, Wishes
from .corner_counts import corner_counts, corner_size
from .demands import find_conflict
from .equations import Equations, way_up
from .levels import find_levels, n_least
from .loops import loop_edges
from .patterns import symmetric_counts
from .sizes import (
    MOST_HEXES,
    SEGMENTS_ACROSS,
    SEGMENTS_AROUND,
    TURN_LAYER,
    TURN_SIZED,
    WANTED_HEXES,
    default_layers,
    greatest_turn,
    path_length,
    size_for,
    split_counts,
    wanted_counts,
)

LEAST_SHARE = 0.01
"""Share of the hexes that the smallest cell may have for its features, however small its volume is."""
TANGENT = radians(1.0)
"""Angle of two sides below which they part tangent: at such a tip a cell has no thickness, whatever its size, and the
shorter the segments are there the flatter the first quad is."""
_MOST_SEGMENTS = 1e6
"""Segments of one edge above which a size is a slip."""
_IN_ALL = "layers"
"""What the layers of the only sweep are called among demands."""
_PASSES = 3
"""Times that a pattern may go on from a cell to its neighbours."""


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
    if len(cells) == 1 and wishes.layers is not None and isinstance(cells[0].fill, Sweep):
        wishes = replace(wishes, demands=[*wishes.demands, _all_layers(cells[0].fill, wishes.layers)])
    wanted, firm, steps = _wanted(cells, sizes, wishes)
    _check_most(cells, wanted)

    def settled(demands: Sequence[KeyDemand]) -> dict[int, int] | None:
        """Counts by key, None where there are none: with alike edges tied if that can be, else without."""
        for align in (True, False):
            counts = Equations(cells, wanted, wishes, align=align, firm=firm).solve(wanted, firm, demands, steps)
            if counts is not None:
                return counts
        return None

    counts = settled(wishes.demands)
    if counts is None:
        guilty = find_conflict(wishes.demands, lambda some: settled(some) is not None)
        if guilty:
            raise _contradiction(cells, guilty)
        raise SurfaceMeshError(
            "no counts of segments fit all cells of the part: the sides of some cell cannot have equal sums"
        )
    return [_intervals_of(cell, counts, sizes[i]) for i, cell in enumerate(cells)]


def _check_most(cells: Sequence[CellSweep], wanted: Mapping[int, float]) -> None:
    """Refuse counts that no mesh has.

    Raises
    ------
    InputError
    """
    key = max(wanted, key=wanted.__getitem__)
    if wanted[key] > _MOST_SEGMENTS:
        labels = (cell.solid.edges[e].label() for cell in cells for e in np.flatnonzero(cell.solid.edge_keys == key))
        raise InputError(f"{next(labels)} would get {wanted[key]:.3g} segments: take a larger size")


def _contradiction(cells: Sequence[CellSweep], guilty: Sequence[KeyDemand]) -> CadSweepError:
    """The refusal of demands that contradict each other: of layers, which no other sweep mends, as wrong input."""
    labels = {int(k): cell.solid.edges[e].label() for cell in cells for e, k in enumerate(cell.solid.edge_keys)}
    rails = {int(c.solid.edge_keys[e]) for c in cells if isinstance(c.fill, Sweep) for e in c.fill.rails}
    total = "".join(f"{own.count} layers in all: " for own in guilty if own.label == _IN_ALL)
    named = ", and ".join(
        f"{own.count} on {', '.join(labels[key] for key in own.keys)}" for own in guilty if own.label != _IN_ALL
    )
    along = all(rails.issuperset(own.keys) for own in guilty)
    stations = [_stations(c.fill) for c in cells if isinstance(c.fill, Sweep) and c.fill.stations] if along else []
    rule = (
        ", ".join(["edges along the sweep between the same stations need equal counts", *stations])
        if along
        else "edges that answer each other need equal counts, opposite sides of a linking side equal sums, and the "
        "loops of a cap even ones"
    )
    return (InputError if along else SurfaceMeshError)(f"the counts contradict each other: {total}{named}; {rule}")


def _stations(sweep: Sweep) -> str:
    """Where layers of a sweep must be, in words."""
    return "; ".join(
        f"station {k} of edges {', '.join(map(str, ring[:6]))}{', ...' if len(ring) > 6 else ''}"
        for k, ring in enumerate(sweep.stations, 1)
    )


def cell_sizes(cells: Sequence[CellSweep], wishes: Wishes) -> list[float]:
    """Target edge length of every cell, working units.

    Without a wish: what gives the whole part some thousand hexes, less where a cell has small features, as long as
    the whole stays below some ten thousand.
    """
    volumes = np.array([cell.solid.volume for cell in cells])
    total = float(volumes.sum())
    n_wanted = min(float(MOST_HEXES), WANTED_HEXES * len(cells) ** 0.5)
    common = (total / n_wanted) ** (1.0 / 3.0)
    if len(cells) == 1 and isinstance(cells[0].fill, Sweep):
        area = sum(cells[0].solid.faces[f].area for f in cells[0].fill.source)
        common = size_for(area, path_length(cells[0].fill), WANTED_HEXES)
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
            feature = min(p / SEGMENTS_AROUND for p in perimeters)
            angles = [cell.solid.edges[e].dihedral for e in sweep.rails]
            if min((min(angle, 2.0 * pi - angle) for angle in angles), default=pi) > TANGENT:  # 0 may be read as 2 pi
                feature = min(feature, 2.0 * area / sum(perimeters) / SEGMENTS_ACROSS)
            size = min(common, max(feature, size_for(area, path_length(sweep), MOST_HEXES * share)))
        sizes.append(float(size))
    return sizes


def _wanted(
    cells: Sequence[CellSweep], sizes: Sequence[float], wishes: Wishes
) -> tuple[dict[int, float], set[int], dict[int, int]]:
    """Wanted count of every edge key, the greatest of what its cells want; keys that the user has sized; and steps.

    The steps are those of keys in patterns: a count there should be a multiple.
    """
    wanted: dict[int, float] = {}
    firm: set[int] = set()
    coarsest: dict[str | None, float] = {}
    for cell, size in zip(cells, sizes, strict=True):
        coarsest[cell.solid.name] = max(size, coarsest.get(cell.solid.name, 0.0))
    for i, cell in enumerate(cells):
        sized = wishes.size is not None or i in wishes.cell_sizes
        keys = cell.solid.edge_keys
        if isinstance(cell.fill, CornerBlocks):
            own = corner_counts(cell.fill, sizes[i], sized=sized)
        else:
            own = wanted_counts(cell.fill, loop_edges(cell.fill), sizes[i], {}, sized=sized)
            # Layers of a cell with small features are those of all cells of its solid, which have no use for as many.
            along = sizes[i] if sized else coarsest[cell.solid.name]
            own |= _rail_counts(
                cell.fill, along, wishes.layers, sized=sized, alone=len(cells) == 1, on_levels=cell.by_itself
            )
            if wishes.layers is not None:
                firm.update(int(keys[e]) for e in cell.fill.rails)
        for e, n in own.items():
            wanted[int(keys[e])] = max(n, wanted.get(int(keys[e]), 1.0))
    steps = _in_patterns(cells, wanted)
    for cell in cells:
        for edge in cell.solid.edges:
            key = int(cell.solid.edge_keys[edge.id])
            if key in wishes.most_sizes and edge.length / wishes.most_sizes[key] > wanted[key]:
                wanted[key] = edge.length / wishes.most_sizes[key]
                firm.add(key)
            if key in wishes.edge_sizes:
                wanted[key] = max(1.0, edge.length / wishes.edge_sizes[key])
                firm.add(key)
            least = max(wishes.least_counts.get(key, 0), wishes.needed_counts.get(key, 0))
            if least:
                wanted[key] = max(wanted[key], float(least))
                firm.add(key)
    for demand in wishes.demands:
        total = sum(wanted[key] for key in demand.keys)
        wanted |= {key: max(1.0, demand.count * wanted[key] / total) for key in demand.keys}
        firm.update(demand.keys)
    shared = split_counts(wanted, wishes.splits)
    wanted |= shared
    firm.update(shared)
    return wanted, firm, steps


def _all_layers(sweep: Sweep, n: int) -> KeyDemand:
    """Layers of a part of one sweep, which are not only wanted.

    Raises
    ------
    InputError
        They are fewer than the sweep's spans need.
    """
    least = min((n_least(levels) for levels in find_levels(sweep)), default=1)
    if n < least:
        named = _stations(sweep)
        raise InputError(
            f"layers={n} is fewer than the {least} that the spans of this sweep need (two where it turns back)"
            + (f"; a layer must meet {named}" if named else "")
        )
    keys = tuple(int(sweep.solid.edge_keys[e]) for e in way_up(sweep, sweep.source_loops[0]))
    return KeyDemand(keys=keys, count=n, label=_IN_ALL)


def _in_patterns(cells: Sequence[CellSweep], wanted: dict[int, float]) -> dict[int, int]:
    """Circles in a pattern in one cell are one in its neighbours, too, which may have wanted more of some of them."""
    steps: dict[int, int] = {}
    for _ in range(_PASSES):
        before = dict(wanted)
        for cell in cells:
            if isinstance(cell.fill, Sweep):
                keys = cell.solid.edge_keys
                own = {e: wanted[int(keys[e])] for e in loop_edges(cell.fill)}
                given = {e: steps[int(keys[e])] for e in own if int(keys[e]) in steps}
                for e, (n, step) in symmetric_counts(cell.fill, own, given).items():
                    steps[int(keys[e])] = lcm(step, steps.get(int(keys[e]), 1))
                    wanted[int(keys[e])] = max(n, wanted[int(keys[e])])
        if wanted == before:
            break
    return steps


def _rail_counts(
    sweep: Sweep, size: float, layers: int | None, *, sized: bool, alone: bool, on_levels: bool
) -> dict[int, float]:
    """Wanted layers of every rail: its share of those of the whole way."""
    solid = sweep.solid
    if layers is not None:
        n = float(layers)
    else:
        turns = greatest_turn(sweep) / (TURN_SIZED if sized else TURN_LAYER)
        # A long part is a few thick layers if it is alone; what touches others follows their edges.
        plain = default_layers(sweep, size) if alone and not sized else path_length(sweep) / size
        n = max(plain, 1.0 if sized else 2.0, turns)
    totals = {e: sum(ls) for loop, ls in zip(sweep.spans, sweep.span_lengths, strict=True) for s in loop for e in s}
    shares = {e: n * solid.edges[e].length / totals[e] for e in sweep.rails}
    choices = find_levels(sweep) if on_levels else []
    if choices:  # rails between the same two levels have one count: of all of them the mean, so that the whole is n
        between: dict[tuple[int, int], list[float]] = {}
        for e, pair in choices[0].rails.items():
            between.setdefault(pair, []).append(shares[e])
        means = {pair: float(np.mean(own)) for pair, own in between.items()}
        whole = sum(means[choices[0].rails[e]] for e in way_up(sweep, sweep.source_loops[0]))
        shares = {e: n / whole * means[pair] for e, pair in choices[0].rails.items()}
    return {e: max(1.0, own) for e, own in shares.items()}


def _intervals_of(cell: CellSweep, counts: Mapping[int, int], size: float) -> Intervals:
    sweep = cell.fill
    own = np.array([counts[int(key)] for key in cell.solid.edge_keys], dtype=np.int64)
    if isinstance(sweep, CornerBlocks):
        return Intervals(counts=own, n_layers=0, size=size)
    n_layers = int(sum(own[e] for e in way_up(sweep, sweep.source_loops[0])))
    return Intervals(counts=own, n_layers=n_layers, size=size, span_layers=_span_layers(sweep, own, n_layers))


def _span_layers(sweep: Sweep, counts: IntArray, n_layers: int) -> tuple[tuple[int, ...], ...]:
    """Layers of every span of every loop; of all together where spans are not told apart by levels."""
    choices = find_levels(sweep)
    if not choices:
        return tuple((n_layers,) for _ in sweep.spans)
    rails, at = choices[-1].rails, {0: 0}
    while len(at) < choices[-1].n:
        known = len(at)
        for e, (low, high) in rails.items():
            if low in at:
                at[high] = at[low] + int(counts[e])
            elif high in at:
                at[low] = at[high] - int(counts[e])
        assert len(at) > known, "rails join all levels"
    return tuple(
        tuple(max(at[rails[e][1]] for e in span) - min(at[rails[e][0]] for e in span) for span in loop)
        for loop in sweep.spans
    )
