"""What the user asks of the cells of a part beyond counts: sizes at places, biases, matched faces, wall layers."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace

from ...brep import Part
from ...errors import InputError
from ...intervals import CellSweep, Wishes, cell_sizes
from ...options import SweepOptions
from ...plan import Plan
from ...surface import Division, Partners
from ...sweep import Sweep
from .biases import divisions_of, resolve_biases, splits_of
from .cell_walls import CellWalls, plan_cell_walls
from .local_sizes import Field, size_field
from .periodic import find_matches, partners_of
from .size_divisions import divide_beside, divide_by_sizes
from .wall_corners import finer_in_cells


@dataclass(frozen=True, kw_only=True, eq=False)
class CellAsks:
    """Wishes resolved to keys of a part with a plan.

    Attributes
    ----------
    wishes : Wishes
        For the counts, with what the others add.
    divisions : dict of int to callable
        How edges divide themselves that are not divided evenly.
    biased : frozenset of int
        Edges among them that the user graded.
    partners : list of Partners
    walls : CellWalls
    field : callable or None
        Wanted lengths inside caps.
    """

    wishes: Wishes
    divisions: dict[int, Division] = field(default_factory=dict)
    biased: frozenset[int] = frozenset()
    partners: list[Partners] = field(default_factory=list)
    walls: CellWalls = field(default_factory=CellWalls)
    field: Field | None = None


def resolve_asks(  # noqa: PLR0917
    part: Part, model: Part, plan: Plan, cells: Sequence[CellSweep], options: SweepOptions, wishes: Wishes
) -> CellAsks:
    """Find the edges and faces that the user means; `model` is the part before it was cut.

    Raises
    ------
    InputError
        Nothing has such a name, or two wishes contradict each other.
    SurfaceMeshError
        The cells divide matched faces in different places.
    """
    partners = partners_of(part, find_matches(part, model, options))
    biases = divisions_of(resolve_biases(part, options, model))
    field = None if options.local_sizes is None else size_field(part, options, max(cell_sizes(cells, wishes)))
    asks = divided_asks(part, cells, options, wishes, biases, partners, field)
    wishes, divisions = asks.wishes, asks.divisions
    walls = plan_cell_walls(part, model, plan, options)
    if options.fractions is not None:
        _refuse_on_rails(part, _rails_of(cells), walls, biases)
    clash = sorted(walls.ends.keys() & biases.keys())
    if clash:
        edges = [e for solid in part.solids for e in solid.edges if int(solid.edge_keys[e.id]) == clash[0]]
        raise InputError(f"{edges[0].label()}: a bias, and wall layers that end there, cannot both be")
    if walls.layers and not partners:
        kept = {*walls.ends, *biases, *(key for demand in wishes.demands for key in demand.keys)}
        sizes, finer = finer_in_cells(part, plan, walls.layers, cell_sizes(cells, wishes), divisions, kept)
        wishes, divisions = replace(wishes, most_sizes={**wishes.most_sizes, **sizes}), divisions | finer
    if walls.ends:
        divisions |= walls.divisions(part)
        wishes = replace(wishes, least_counts=walls.least_counts(part, max(cell_sizes(cells, wishes))))
    return replace(asks, wishes=wishes, divisions=divisions, walls=walls)


def divided_asks(  # noqa: PLR0917
    part: Part,
    cells: Sequence[CellSweep],
    options: SweepOptions,
    wishes: Wishes,
    biases: dict[int, Division],
    partners: list[Partners],
    field: Field | None,
) -> CellAsks:
    """What biases, matched faces, sizes at places and sizes of edges make of wishes, by keys; without walls.

    Raises
    ------
    InputError
        Two of them contradict each other.
    """
    wishes = replace(
        wishes,
        alike=[(a, b, same) for own in partners for a, (b, same) in own.edges.items()],
        splits=splits_of(biases),
    )
    _refuse_unlike(part, wishes)
    sweeps = [own.fill for own in cells if isinstance(own.fill, Sweep)]
    grids = [(own.solid, grid) for own in cells for grid in own.grids]
    divisions = dict(biases)
    if field is not None:
        if options.layers is not None or options.fractions is not None:
            raise InputError("local_sizes divide edges along the sweep, too: without layers and fractions")
        most, divided = divide_by_sizes(part.solids, sweeps, grids, field, alike=wishes.alike)
        wishes, divisions = replace(wishes, most_sizes=most), divided | divisions
    elif wishes.edge_sizes and not (options.wall_layers or partners):
        # Where rows along walls end, and what answers another face, is settled elsewhere.
        kept = {*_rails_of(cells), *biases, *(key for demand in wishes.demands for key in demand.keys)}
        size = max(cell_sizes(cells, wishes))
        most, divided = divide_beside(part.solids, sweeps, grids, wishes.edge_sizes, size, kept=kept)
        wishes, divisions = replace(wishes, most_sizes=most), divided | divisions
    return CellAsks(
        wishes=wishes,
        divisions=divisions,
        biased=frozenset(biases),
        field=field,
        partners=partners,
    )


def _rails_of(cells: Sequence[CellSweep]) -> set[int]:
    """Edges along the sweeps of cells, by key."""
    return {int(own.solid.edge_keys[e]) for own in cells if isinstance(own.fill, Sweep) for e in own.fill.rails}


def _refuse_unlike(part: Part, wishes: Wishes) -> None:
    """Refuse unlike counts of edges that answer each other on matched faces."""
    single = {own.keys[0]: own.count for own in wishes.demands if len(own.keys) == 1}
    for a, b, _ in wishes.alike:
        if single.get(a, 0) != single.get(b, 0) and a in single and b in single:
            edges = {int(key): e for solid in part.solids for key, e in zip(solid.edge_keys, solid.edges, strict=True)}
            labels = " and ".join(edges[key].label() for key in (a, b))
            raise InputError(f"periodic: {labels} answer each other, and are asked to have unlike counts")


def _refuse_on_rails(part: Part, rails: Collection[int], walls: CellWalls, biases: Collection[int]) -> None:
    """Refuse what divides edges along a sweep besides fractions."""
    for solid in part.solids:
        for edge, key in zip(solid.edges, solid.edge_keys.tolist(), strict=True):
            if key in rails and (key in walls.ends or key in biases):
                what = "wall layers that end there" if key in walls.ends else "a bias"
                raise InputError(
                    f"{edge.label()} runs along the sweep, where fractions place the layers: {what} cannot divide it "
                    "besides"
                )
