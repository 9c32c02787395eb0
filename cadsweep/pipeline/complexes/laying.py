"""What is settled of cells before a node is laid: their edges' divisions, sizes on their sources, rings of lone sides.

Place in the flow: :mod:`.cells` asks here, and hands it to the skeleton.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from ...arrays import FloatArray
from ...brep import Part
from ...corner_blocks import CornerBlocks
from ...intervals import CellSweep
from ...options import SweepOptions
from ...plan import Plan
from ...surface import Division, Rings, divided, graded_together, lay_rings, rails_abreast
from ...sweep import Intervals, Sweep
from ..nearness.cap_sizes import InsideSizes, least_of
from ..wishes.cell_asks import CellAsks
from ..wishes.leaving import heights_of
from ..wishes.local_sizes import Field
from ..wishes.size_divisions import least_along


def cell_sweeps(part: Part, plan: Plan) -> list[CellSweep]:
    """What the counts of the cells depend on: a cap gets free quads where it is a grid to nobody."""
    given = {
        int(solid.face_keys[f])
        for solid, way in zip(part.solids, plan.ways, strict=True)
        for f, role in enumerate(way.roles)
        if role in ("grid", "star")
    }
    own_sides = plan.by_themselves(part)
    return [
        CellSweep(
            fill=way.fill,
            grids=tuple(way.grids.values()),
            free=tuple(
                f for f, role in enumerate(way.roles) if role == "first" and int(solid.face_keys[f]) not in given
            ),
            by_itself=cell in own_sides,
        )
        for cell, (solid, way) in enumerate(zip(part.solids, plan.ways, strict=True))
    ]


def fractions_of(
    part: Part,
    cells: Sequence[CellSweep],
    counts: Sequence[Intervals],
    divisions: Mapping[int, Division],
    alike: Sequence[tuple[int, int, bool]],
) -> dict[int, FloatArray]:
    """Fractions of all edges that are not divided evenly, by key."""
    with_counts = list(zip(part.solids, counts, strict=True))
    n = {int(key): int(c) for solid, own in with_counts for key, c in zip(solid.edge_keys, own.counts, strict=True)}
    asked = divided(divisions, n)
    sweeps = [(own.fill, n) for own, n in zip(cells, counts, strict=True) if not isinstance(own.fill, CornerBlocks)]
    grids = [(own.solid, side) for own in cells for side in own.grids]
    return graded_together(part.solids, sweeps, grids, n, asked, alike)


def rails_of(part: Part, plan: Plan, options: SweepOptions, asks: CellAsks) -> dict[int, Division]:
    """How rails that wind around each other divide themselves, by key, where the user names no places of layers."""
    found: dict[int, Division] = {}
    for cell in sorted(plan.by_themselves(part)) if options.fractions is None else ():
        sweep, solid = plan.ways[cell].fill, part.solids[cell]
        assert isinstance(sweep, Sweep), "what is by itself is swept"
        if not any(int(solid.face_keys[f]) in asks.walls.layers for f in (*sweep.source, *sweep.target)):
            keys = solid.edge_keys.tolist()
            found |= {keys[e]: division for e, division in rails_abreast(sweep, options.bias).items()}
    return found


def sizes_on_sources(plan: Plan, field: Field | None, inside: InsideSizes | None) -> dict[int, InsideSizes]:
    """Wanted lengths on the sources of cells: what is asked for on the way to the target counts there, too."""
    found = {}
    for cell, way in enumerate(plan.ways):
        own = field
        if field is not None and isinstance(way.fill, Sweep):
            own = least_along(way.fill, field)
        least = least_of(own, inside)
        if least is not None:
            found[cell] = least
    return found


def rings_of_cells(  # noqa: PLR0917
    part: Part,
    plan: Plan,
    counts: Sequence[Intervals],
    options: SweepOptions,
    divisions: Mapping[int, Division],
    fractions: Mapping[int, FloatArray],
    asks: CellAsks,
) -> dict[int, Rings]:
    """Rings of the cells whose linking sides nobody else has."""
    uses = Counter(int(key) for solid in part.solids for key in solid.edge_keys.tolist())
    matched = {key for own in asks.partners for key in own.faces}
    found = {}
    for cell in sorted(plan.by_themselves(part)):
        sweep, own, solid = plan.ways[cell].fill, counts[cell], part.solids[cell]
        assert isinstance(sweep, Sweep), "what is by itself is swept"
        if not matched.isdisjoint(int(solid.face_keys[side.face]) for side in sweep.linking_sides):
            continue
        keys = solid.edge_keys.tolist()
        n = {key: int(c) for key, c in zip(keys, own.counts.tolist(), strict=True)}
        fixed = {
            e: fractions.get(key, np.linspace(0.0, 1.0, n[key] + 1))
            for e, key in enumerate(keys)
            if uses[key] > 1 or key in divisions
        }
        graded = {e: fractions[key] for e, key in enumerate(keys) if key in fractions}
        heights = {
            cap is sweep.source: heights_of(asks.walls.layers[int(solid.face_keys[f])])
            for cap in (sweep.target, sweep.source)
            for f in cap
            if int(solid.face_keys[f]) in asks.walls.layers
        }
        found[cell] = lay_rings(
            sweep, own, graded, fixed, bias=options.bias, fractions=options.fractions, heights=heights
        )
    return found
