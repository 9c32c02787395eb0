"""Cells, one or many, as near to the CAD model as is asked for: measured solid by solid, edges of what sags divided
finer, and caps inside.

The limits are those of :mod:`.nearer`: with a tolerance the distance from the CAD faces, without one
and without a size what a solid may lose of its volume and area. Nodes lie on their faces, so a mesh is off where its
quads sag: at the middles of their sides and their own.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import ceil, sqrt
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from ...blocks.cells import CellBlocks
from ...blocks.finish import by_face
from ...blocks.joined import JoinedMesh, neighbours_of
from ...blocks.naming import NamedFaces
from ...blocks.reference import make_references
from ...brep import Part
from ...errors import SurfaceMeshError
from ...intervals import Wishes
from ...options import SweepOptions
from ...plan import Plan
from ...quality import volume_and_area
from ...quality.deviation import quad_sags, side_sags
from ...quality.rims import is_rim, off_edges
from ...surface import Division
from ...sweep import Intervals
from ..complexes.cells import mesh_cells
from ..run import Run
from .cap_sizes import InsideSizes, least_of
from .cell_cap_sizes import caps_of, sizes_at_rims, sizes_in_caps
from .nearer import (
    COARSE,
    FINER,
    LOST_SIZED,
    MARGIN,
    MOST_HEXES,
    TooManyError,
    coarse,
    come_nearer,
    is_loose,
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


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """How far a mesh is off what is asked for.

    Attributes
    ----------
    shortfall : float
        In limits: above 1 it is too far.
    needed : dict of (int, int) to float
        How many times finer the quads should be on faces that are too far off, by cell and face.
    sags : dict of (int, int) to float
        How far each curved face is off, working units, by cell and face.
    """

    shortfall: float
    needed: dict[tuple[int, int], float]
    sags: dict[tuple[int, int], float]

    def beyond(self, rounds: int) -> Found:
        """More than is asked for, after some rounds: a mesher answers in whole quads, here and there."""
        return replace(self, needed={place: needed * MARGIN**rounds for place, needed in self.needed.items()})

    @property
    def most_needed(self) -> float:
        """How many times finer quads should be where they are farthest off."""
        return max(self.needed.values())

    @property
    def distance(self) -> float:
        """How far any face is off, working units."""
        return max(self.sags.values(), default=0.0)


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
        check_most(options, made[0].n_hexes * found.most_needed)
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
        finer_wishes = replace(wishes, edge_sizes={**wishes.edge_sizes, **sizes})
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


def keeps_shape(part: Part, joined: JoinedMesh | CellBlocks, options: SweepOptions) -> bool:
    """Whether a mesh of the size that is asked for is near enough as it is, no tolerance being asked for."""
    if options.tolerance is not None or options.size is None:
        return False
    return is_loose(options) or all(max(map(abs, lost)) <= LOST_SIZED for lost in _lost(part, joined).values())


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


def check_most(options: SweepOptions, n_hexes: float) -> None:
    """Refuse a finer mesh of more hexahedra than a part is given by itself.

    Raises
    ------
    TooManyError
    """
    if options.tolerance is None and n_hexes > MOST_HEXES:
        raise TooManyError


def check_coarse_solids(part: Part, joined: JoinedMesh | CellBlocks, names: NamedFaces, options: SweepOptions) -> None:
    """Refuse a mesh of which a solid is another one; what is still to be curved or refined comes nearer.

    Raises
    ------
    CoarseMeshError
        Names the solid that is farthest off.
    """
    if is_loose(options):
        return
    worst, said = COARSE, ""
    several = len(part.models) > 1
    suspects = {owner: lost for owner, lost in _lost(part, joined).items() if max(map(abs, lost)) > COARSE}
    references = make_references(part, names) if suspects else {}
    for owner, (volume, area) in suspects.items():
        name = part.models[owner].name
        doubt = references[name].volume_doubt / (part.models[owner].volume * part.scale**3)
        off = max(abs(volume) - doubt, abs(area))
        if off > worst:
            who, alone = (f"of '{name}' ", f" (--size {name}=S gives it a size of its own)") if several else ("", "")
            worst = off
            said = f"the volume {who}is {volume:+.1%} off the CAD's and the area {area:+.1%}{alone}"
    if said:
        raise coarse(said)


def _lost(part: Part, joined: JoinedMesh | CellBlocks) -> dict[int, tuple[float, float]]:
    """By solid of the model: its mesh's volume and area over the CAD's, less one."""
    owners = np.array(part.owners, dtype=np.int64)
    on_cut = np.zeros((len(part.solids), max(len(solid.faces) for solid in part.solids)), dtype=np.bool_)
    for (cell, face), (other, _) in neighbours_of(part).items():
        on_cut[cell, face] = owners[other] == owners[cell]
    meshed = np.zeros_like(on_cut)
    meshed[joined.quad_cells, joined.quad_faces] = True
    exposed = meshed & ~on_cut
    areas = np.zeros(len(part.models))
    for cell, face in zip(*np.nonzero(exposed), strict=True):
        areas[owners[cell]] += part.solids[cell].faces[face].area
    found = {}
    own = owners[joined.quad_cells]
    order = np.argsort(own, kind="stable")
    starts = np.flatnonzero(np.diff(own[order], prepend=-1))
    for rows in np.split(order, starts[1:]) if len(order) else ():
        owner, quads = int(own[rows[0]]), joined.quads[rows]
        volume, area = volume_and_area(joined.points, quads)
        seen = exposed[joined.quad_cells[rows], joined.quad_faces[rows]]
        if not seen.all():  # the rest lies on cuts
            _, area = volume_and_area(joined.points, quads[seen])
        found[owner] = volume / part.models[owner].volume - 1.0, area / float(areas[owner]) - 1.0
    return found


def measure(part: Part, joined: JoinedMesh | CellBlocks, options: SweepOptions) -> Found:
    """How far a mesh is off what is asked for, and which faces are to blame."""
    off = _sags(part, joined)
    lost = _lost(part, joined) if options.tolerance is None else {}
    shortfall = 0.0
    needed: dict[tuple[int, int], float] = {}
    for (cell, face), sag in off.items():
        limit = limit_of(options, scale=part.scale, size=part.solids[cell].size)
        much = limit.shortfall(sag, *lost.get(part.owners[cell], ()))
        shortfall = max(shortfall, much)
        if much > 1.0:
            needed[cell, face] = float(np.sqrt(MARGIN * much))
    return Found(
        shortfall=shortfall,
        needed=needed,
        sags=off,
    )


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


def boundary_distance(
    part: Part, joined: JoinedMesh | CellBlocks, names: NamedFaces, found: Found | None = None
) -> float:
    """Greatest distance of the boundary's and the contacts' quads from their curved faces, working units.

    `found`: how far the mesh is off its faces, where that is known.
    """
    sags = _sags(part, joined) if found is None else found.sags
    return max((sag for place, sag in sags.items() if names.of(place)), default=0.0)


def _sags(part: Part, joined: JoinedMesh | CellBlocks) -> dict[tuple[int, int], float]:
    """How far the quads on every curved face, by cell and face, are off it."""
    found: dict[tuple[int, int], float] = {}
    for (cell, face), quads in by_face(joined):
        own = part.solids[cell].faces[face]
        if own.kind != "plane":
            sags = (
                side_sags(own, joined.points[quads[:, :4]])
                if joined.roles.get((cell, face)) == "side"
                else quad_sags(own.surface, joined.points[quads[:, :4]])
            )
            found[cell, face] = float(sags.max())
    beyond = neighbours_of(part)
    for cell, solid in enumerate(part.solids):
        segments = {}
        for edge in solid.edges:
            # What a cut ends at goes on beyond it, and is no rim of the part.
            if is_rim(edge) and not any((cell, face) in beyond for face in edge.faces):
                nodes = joined.points[joined.edge_nodes[int(solid.edge_keys[edge.id])]]
                segments[edge.id] = nodes[:-1], nodes[1:]
        for e, off in off_edges(solid, segments).items():
            for place in ((cell, face) for face in solid.edges[e].faces):
                if place in found:
                    found[place] = max(found[place], off)
    return found


def edge_sag(part: Part, joined: JoinedMesh | CellBlocks, cell: int, edge: int) -> float:
    """Greatest distance of the middles of an edge's segments from it."""
    solid = part.solids[cell]
    if solid.edges[edge].kind == "line":
        return 0.0
    nodes = joined.points[joined.edge_nodes[int(solid.edge_keys[edge])]]
    return float(np.max(solid.edges[edge].curve.distance((nodes[1:] + nodes[:-1]) / 2)))


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
