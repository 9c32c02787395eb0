"""Cells, one or many, as near to the CAD model as is asked for: measured solid by solid, edges of what sags divided
finer, and caps inside.

The limits are those of :mod:`.nearer`: with a tolerance the distance from the CAD faces, without one
and without a size what a solid may lose of its volume and area.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from math import ceil, sqrt
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from ...blocks.cells import CellBlocks
from ...brep import Part
from ...errors import SurfaceMeshError
from ...intervals import Wishes
from ...options import SweepOptions
from ...plan import Plan
from ...surface import Division
from ...sweep import Intervals
from ..complexes.cells import mesh_cells
from ..run import Run
from .cap_sizes import InsideSizes, least_of
from .cell_cap_sizes import caps_of, sizes_at_rims, sizes_in_caps
from .measured import Found, edge_sag, keeps_shape, measure
from .nearer import (
    FINER,
    MARGIN,
    TooManyError,
    check_most,
    come_nearer,
    limit_of,
    missed_tolerance,
)
from .uneven import divide_unevenly

LEAST_MORE = 2
"""Segments that an edge gets more at least: loops of quads alone take them in pairs."""
MOST_POWER = 2.0
"""Power by which quads are asked to be finer than the sag asks for, where finer ones brought less than they should."""
FAR = 1.5
"""Shortfall beyond which that is done: nearer, a quarter finer may be enough, and counts jump as they like."""
SHARE = 0.1
"""An edge whose segments sag less than this part of what its face is off stays as it is."""

Meshed = tuple[CellBlocks, list[Intervals], list[str]]


class Asks(NamedTuple):
    """What is asked of edges, of the inside of caps, and how edges divide themselves, by key."""

    wishes: Wishes
    inside: InsideSizes | None
    divisions: dict[int, Division]


Made = TypeVar("Made")
Asked = TypeVar("Asked")


class Judged(NamedTuple, Generic[Made]):
    """What was made, and how far it is off."""

    made: Made
    found: Found

    @property
    def shortfall(self) -> float:
        """In limits."""
        return self.found.shortfall


def accurate_cells(  # noqa: PLR0917
    part: Part, plan: Plan, options: SweepOptions, run: Run, wishes: Wishes, model: Part
) -> tuple[Meshed, Found | None]:
    """Mesh all cells of a part as near to the CAD faces as is asked for; `model` is the part before it was cut.

    With how far the mesh is off, where that was asked.

    Raises
    ------
    InputError, SurfaceMeshError, ProjectionError
        As by :func:`~..complexes.cells.mesh_cells`.
    """
    first = mesh_cells(part, plan, options, run, wishes, model)
    if keeps_shape(part, first[0], options):
        return first, None

    caps = caps_of(part, plan)
    # The places of rows along walls, and of nodes that answer others, are settled elsewhere.
    apart = set[int]() if options.wall_layers or options.periodic else plan.by_themselves(part)

    def finer(last: Judged[Meshed], asked: Asks, rounds: int) -> Asks | None:
        made, found = last.made, last.found.beyond(rounds)
        wishes, before, divisions = asked
        check_most(options, len(part.models), _expected(made[0], found))
        inside = sizes_in_caps(part, plan, made[0], found.needed, found.sags, before)
        sizes = finer_sizes(part, made[1], _blamed(part, made[0], found, caps), wishes)
        kept = {key for demand in wishes.demands for key in demand.keys}
        if apart and (sizes or inside is not None):
            limit = min(limit_of(options, scale=part.scale, size=solid.size).distance for solid in part.solids)
            if np.isfinite(limit):
                lengths, more = divide_unevenly(
                    part, plan, made[1], sizes, inside, divisions, limit / MARGIN, kept={*kept, *named}
                )
                sizes, divisions = sizes | lengths, divisions | more
        if inside is not None:
            own = [place for place in caps.intersection(found.needed) if place[0] not in apart]
            for key, size in sizes_at_rims(part, made[1], own, inside, kept=kept).items():
                sizes[key] = min(size, sizes.get(key, np.inf), wishes.edge_sizes.get(key, np.inf))
        elif not sizes:
            return None
        needed = {**wishes.needed_counts, **_not_had(part, made[1], sizes, wishes)}
        finer_wishes = replace(wishes, edge_sizes={**wishes.edge_sizes, **sizes}, needed_counts=needed)
        return Asks(finer_wishes, least_of(before, inside), divisions)

    def judged(made: Meshed) -> Judged[Meshed]:
        return Judged(made, measure(part, made[0], options))

    named = frozenset(wishes.edge_sizes)
    asked = Asks(wishes, None, {})
    best, notes = nearest(
        part,
        judged(first),
        asked,
        options,
        run,
        make=lambda asked: judged(
            mesh_cells(part, plan, options, run, asked.wishes, model, asked.inside, asked.divisions)
        ),
        finer=finer,
    )
    blocks, counts, said = best.made
    return (blocks, counts, [*said, *notes]), best.found


def nearest(
    part: Part,
    first: Judged[Made],
    asked: Asked,
    options: SweepOptions,
    run: Run,
    *,
    make: Callable[[Asked], Judged[Made]],
    finer: Callable[[Judged[Made], Asked, int], Asked | None],
) -> tuple[Judged[Made], list[str]]:
    """As :func:`~.nearer.come_nearer`, with notes on what failed, on a size that is not kept, and on a tolerance."""
    before: Found | None = None
    said: list[str] = []

    def told(asked: Asked) -> Judged[Made]:
        try:
            return make(asked)
        except SurfaceMeshError as error:
            said.append(f"finer quads for a nearer boundary could not be made: {error.message}")
            raise

    def much_finer(last: Judged[Made], asked: Asked, rounds: int) -> Asked | None:
        nonlocal before
        here, before = before, last.found
        if here is not None and last.shortfall >= FAR:
            more = _as_it_falls(last.found, here)
            with suppress(TooManyError):
                wishes = finer(last._replace(found=more), asked, rounds)
                before = more
                return wishes
        return finer(last, asked, rounds)

    best, stop = come_nearer(first, asked, make=told, finer=much_finer, is_over=partial(run.ends_refining, options))
    reached = best.found.distance * part.scale
    if options.tolerance is not None:
        # What failed is why the tolerance is missed, and said once.
        return best, [missed_tolerance(reached, options, stop)] if reached > options.tolerance else said
    if best is not first and options.size is not None:
        said.append(FINER.format(size=options.size))
    return best, said


def _as_it_falls(present: Found, before: Found) -> Found:
    """What is found, and finer quads needed where those that were asked `before` brought less than their square.

    Counts are whole, and a mesher's quads seldom as small as asked for: to ask the same again takes many rounds.
    """
    brought = np.log(before.shortfall / present.shortfall) / np.log(before.most_needed)
    power = 2.0 / np.clip(brought, 2.0 / MOST_POWER, 2.0)
    return replace(present, needed={place: float(needed**power) for place, needed in present.needed.items()})


def _expected(joined: CellBlocks, found: Found) -> float:
    """About how many hexahedra a finer mesh has: only cells with faces that are too far off get more."""
    more: dict[int, float] = {}
    for (cell, _), needed in found.needed.items():
        more[cell] = max(more.get(cell, 1.0), needed)
    return sum(own.n_hexes * more.get(own.cell, 1.0) for own in joined.cells)


def _blamed(part: Part, joined: CellBlocks, found: Found, caps: Collection[tuple[int, int]]) -> dict[int, float]:
    """By how much edges should be finer, by key: those that bend of the faces that are too far off.

    Of the sides of these all, where none bends: a cap's quads inside are wished for by themselves.
    """
    factors: dict[int, float] = {}
    for (cell, face), needed in found.needed.items():
        solid = part.solids[cell]
        sags = {e: edge_sag(part, joined, cell, e) for e in solid.faces[face].edges}
        blamed = [e for e, own in sags.items() if own > SHARE * found.sags[cell, face]]
        is_cap = (cell, face) in caps
        if not blamed and not is_cap:
            blamed = list(sags)
        for e in blamed:
            # Quads inside a cap are no longer than is wished for there, whatever the segments of its rim are.
            own = needed * sqrt(min(1.0, sags[e] / found.sags[cell, face])) if is_cap else needed
            key = int(solid.edge_keys[e])
            if own > 1.0:
                factors[key] = max(factors.get(key, 1.0), own)
    return factors


def _not_had(part: Part, counts: Sequence[Intervals], sizes: Collection[int], asked: Wishes) -> dict[int, int]:
    """Segments, by key, that edges were asked to have and have not, as most that go with them want fewer."""
    needed: dict[int, int] = {}
    for solid, own in zip(part.solids, counts, strict=True):
        for edge in solid.edges:
            key = int(solid.edge_keys[edge.id])
            if key in sizes and key in asked.edge_sizes:
                n = ceil(edge.length / asked.edge_sizes[key])
                if int(own.counts[edge.id]) < n:
                    needed[key] = n
    return needed


def finer_sizes(part: Part, counts: Sequence[Intervals], factors: dict[int, float], asked: Wishes) -> dict[int, float]:
    """Sizes of edges, by key, that make them as much finer; not of those whose count the user gave."""
    spoken = {key for demand in asked.demands for key in demand.keys}
    sizes: dict[int, float] = {}
    for solid, own in zip(part.solids, counts, strict=True):
        for edge in solid.edges:
            key = int(solid.edge_keys[edge.id])
            if key in factors and key not in spoken:
                count = max(1, int(own.counts[edge.id]))
                more = count + max(LEAST_MORE, ceil(count * (factors[key] - 1.0)))
                # What was asked for before may not have been had, as counts are whole, loops even and neighbours want
                # others: it is asked for the more.
                finer = min(edge.length, asked.edge_sizes.get(key, np.inf) * count) / more
                sizes[key] = min(finer, sizes.get(key, np.inf))
    return sizes
