"""Parts that are no plain sweep as stacks: columns of material along one direction, meshed on one arrangement.

For a part without a sweep, every direction along which all faces are walls or caps is a candidate. ``cad`` carries the
outlines of the caps on a plane, ``intervals`` and ``surface`` mesh what they divide it into as if it were the source
cap of a sweep, and ``stacks`` gives every node its heights.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ... import cad, estimate, intervals, stacks, surface
from ...blocks.joined import JoinedMesh
from ...brep import Part, Solid
from ...errors import CadSweepError, InputError, NotSweepableError, SurfaceMeshError
from ...mesh import HexMesh, QuadMesh
from ...options import SweepOptions
from ...stack import Stack, name_direction
from ...stack_mesh import StackMesh
from ...sweep import Intervals, Sweep
from ..candidates import GOOD_ENOUGH, SMOOTH_BELOW
from ..complexes.laying import cell_sweeps, fractions_of
from ..complexes.several import finish
from ..complexes.swept import alone
from ..finished.pairs import with_pairs
from ..nearness.stack_accuracy import MadeStack, accurate_stack
from ..origin import AnyMesh
from ..parts import only_solid
from ..run import Run, Tries
from ..wishes.cell_asks import CellAsks
from ..wishes.stack_hints import StackHints, grade_levels, resolve_stack_hints, weigh_layers
from ..wishes.stack_walls import StackWalls, plan_stack_walls
from .islands import without_islands
from .stack_merging import merged_stack
from .stack_narrow import narrow_hints
from .stack_plane import mesh_plane
from .straight_stacks import blocks_of

log = logging.getLogger(__name__)

MOST_DIRECTIONS = 6
"""Directions whose outlines are divided by each other, those with the flattest and fewest caps first."""

MOST_UNASKED = 500_000
"""Hexahedra of a stack where nobody says how large they are to be."""

_SAME = 1.0 - 1e-9
"""Cosine from which on two directions are one."""

MOST_STACKS = 3
"""Stacks of one solid that are tried before the first one's error is raised."""


class _Known(NamedTuple):
    """A stack of a part, and what of its caps goes on into each other."""

    stack: Stack
    sheets: stacks.Sheets


def find_stacks(part: Part) -> list[Stack]:
    """List the directions along which a part is a stack, best first.

    Raises
    ------
    NotSweepableError
        There is none; ``.reasons`` has a line for every direction that was looked at, the most promising first.
    """
    return [known.stack for known in _find(part)]


def _find(part: Part) -> list[_Known]:
    """As :func:`find_stacks`."""
    solid = only_solid(part)
    found, reasons = _search(solid)
    if not found:
        raise NotSweepableError(f"'{solid.name or part.name}' is no stack of columns: {reasons[0]}", reasons=reasons)
    return found


def _search(solid: Solid) -> tuple[list[_Known], list[str]]:
    normals = stacks.Normals(solid)
    candidates, refused = [], []
    for direction in stacks.find_directions(normals):
        try:
            candidates.append(stacks.read_sides(normals, direction))
        except NotSweepableError as error:
            refused.append((direction, error.message))
    refused.sort(key=lambda pair: -stacks.count_fitting(normals, pair[0]))
    candidates.sort(key=lambda sides: (-round(sides.steepest, 6), len(sides.caps)))
    found: list[_Known] = []
    reasons: list[str] = []
    for sides in candidates[:MOST_DIRECTIONS]:
        try:
            stations = stacks.find_stations(solid, sides)
            caps = sides.caps.keys()
            lines = [e.id for e in solid.edges if caps & set(e.faces)] + list(stations)
            stack = stacks.make_stack(solid, sides, stations, cad.arrange(solid, sides.direction, sides.caps, lines))
            sheets = stacks.find_sheets(stack)
        except CadSweepError as error:
            reasons.append(_reason(sides.direction, error.message))
            continue
        found.append(_Known(stack, sheets))
    found.sort(key=lambda known: (-known.stack.score, known.stack.n_columns))
    reasons += [_reason(direction, why) for direction, why in refused]
    return found, reasons or ["along no direction: no face of it is plane, and no edge straight"]


def _reason(direction: np.ndarray, why: str) -> str:
    return f"along ({name_direction(direction)}), {why}"


def other_stacks(part: Part, sweeps: Sequence[Sweep]) -> list[Stack]:
    """Directions along which a part that has sweeps is a stack with other caps than theirs."""
    known = {frozenset((frozenset(sweep.source), frozenset(sweep.target))) for sweep in sweeps}
    found, _ = _search(only_solid(part))
    return [s for s, _ in found if frozenset((frozenset(s.source), frozenset(s.target))) not in known]


def describe_stacks(part: Part, sweeps: Sequence[Sweep]) -> tuple[list[dict[str, Any]], list[str]]:
    """Rows of ``cadsweep info``: the stacks of a part, beside its sweeps, and why other directions give none.

    Returns
    -------
    rows : list of dict
        Direction, caps, numbers of levels, cells and columns, and score of each, best first; heights of the levels in
        model units along the direction.
    reasons : list of str
    """
    known = {frozenset((frozenset(sweep.source), frozenset(sweep.target))) for sweep in sweeps}
    found, reasons = _search(only_solid(part))
    rows = []
    for stack, sheets in found:
        if frozenset((frozenset(stack.source), frozenset(stack.target))) in known:
            continue
        faces = stack.solid.faces
        heights = np.sort(stacks.told_heights(stack, sheets)) * part.scale + float(part.offset @ stack.direction)
        rows.append(
            {
                "direction": np.round(stack.direction, 12) + 0.0,
                "source": [faces[f].shown for f in stack.source],
                "target": [faces[f].shown for f in stack.target],
                "n_walls": len(stack.walls),
                "levels": heights,
                "n_cells": len(stack.columns),
                "n_columns": stack.n_columns,
                "score": stack.score,
            }
        )
    return rows, reasons


def stacks_instead(part: Part, refused: NotSweepableError) -> list[Stack]:
    """The stacks of a part that has no sweep.

    Raises
    ------
    NotSweepableError
        It is no stack either; says why it has no sweep first.
    """
    return [known.stack for known in _find_instead(part, refused)]


def _find_instead(part: Part, refused: NotSweepableError) -> list[_Known]:
    """As :func:`stacks_instead`."""
    try:
        return _find(part)
    except NotSweepableError as error:
        columns = [f"no stack of columns {reason}" for reason in error.reasons]
        raise refused.about(reasons=columns) from refused


def mesh_stacks_instead(part: Part, options: SweepOptions, run: Run, refused: CadSweepError | None) -> AnyMesh:
    """Mesh a part that no sweep gives a mesh of: by the first stack that does well, or by the best of those tried.

    Raises
    ------
    CadSweepError
        What is wrong with the part as a sweep, where it is no stack or its caps were chosen by the user; what is wrong
        with its first stack, where it has no sweep.
    """
    assert refused is not None
    if options.source is not None or options.target is not None or len(part.solids) != 1:
        raise refused
    with run.stage("recognition"):
        if isinstance(refused, NotSweepableError):
            found = _find_instead(part, refused)
        else:
            found, _ = _search(only_solid(part))
            if not found:
                raise refused
    tried: list[AnyMesh] = []
    failures: list[CadSweepError] = []
    tries = Tries(run)
    for known in found[:MOST_STACKS]:
        if (tried or failures) and tries.is_over():
            break
        try:
            with tries.one():
                mesh = _mesh_stack(*_followed(part, known), options, run)
        except InputError:
            raise
        except CadSweepError as error:
            log.info("stack along %s given up: %s", known.stack.direction, error)
            failures.append(error)
            continue
        tried.append(mesh)
        if mesh.info["quality"].min_scaled_jacobian >= GOOD_ENOUGH:
            break
    if not tried:
        raise failures[0] if isinstance(refused, NotSweepableError) else refused
    best = max(tried, key=lambda mesh: (mesh.info["quality"].valid, mesh.info["quality"].min_scaled_jacobian))
    notes = [*best.info["notes"], *(f"a better ranked stack was given up: {error.message}" for error in failures)]
    if not isinstance(refused, NotSweepableError):
        notes.append(f"meshed as columns between caps, as its sweeps were given up: {refused.message}")
    return replace(best, info={**best.info, "notes": notes})


def _followed(part: Part, known: _Known) -> tuple[Part, _Known]:
    """The part without outlines that the layers of a stack cannot follow, and that stack of it.

    Raises
    ------
    NotSweepableError
        They cannot be left out.
    """
    merged = without_islands(part, known.stack)
    if merged is part:
        return part, known
    found, reasons = _search(only_solid(merged))
    same = (own for own in found if abs(own.stack.direction @ known.stack.direction) > _SAME)
    again = next(same, None)
    if again is None:
        raise NotSweepableError(reasons[0], reasons=reasons)
    return merged, again


def _mesh_stack(part: Part, known: _Known, options: SweepOptions, run: Run) -> AnyMesh:
    _only_for_sweeps(options)
    size = None if options.size is None else options.size / part.scale
    with run.stage("recognition"):
        stack, sheets = _merged(known, size)
    prism = alone(part, stack.plan)
    cells = cell_sweeps(prism.part, prism.plan)
    hints = resolve_stack_hints(part, stack, sheets, prism.part, cells, options)
    walls, memory = StackWalls(), surface.Memory()

    def attempt(hints: StackHints, sizes: dict[int, float]) -> tuple[Intervals, Callable[[], QuadMesh]]:
        with run.stage("intervals"):
            wishes = replace(hints.plane.wishes, edge_sizes=sizes)
            counts = intervals.assign_shared_intervals(cells, wishes)[0]
        return counts, partial(_lay_plane, prism.part, cells, counts, hints.plane, walls.walls(stack), memory)

    counts, _ = attempt(hints, dict(hints.plane.wishes.edge_sizes))
    hints = hints.on_plane(edge_sizes={**stacks.sizes_across(stack, counts.size), **hints.plane.wishes.edge_sizes})
    if options.wall_layers:
        walls = plan_stack_walls(part, stack, sheets, options, counts.size)
        hints = walls.added_to(stack, hints, counts)
    with run.stage("intervals"):
        weigh_layers(sheets, hints, counts.size)
        # One layer does not bend; where nobody asked for a size, a thin plate under its bosses gets two.
        least = 2 if options.size is None and options.layers is None else 1
        apart = stacks.sheets_apart(stack, sheets, counts.size)
        levels = stacks.assign_levels(
            stack, sheets, size=counts.size, layers=options.layers, demands=hints.layers, apart=apart, least=least
        )
        levels = grade_levels(levels, sheets, hints)
        full = max(1, round(levels.n_layers * stack.solid.volume / stack.arrangement.prism.volume))
        expected = estimate.estimate(stack.plan, replace(counts, n_layers=full), scale=part.scale)
        run.checks(expected, options)

    # Edges that answer others, or have rows of quads along them, are divided as these ask.
    narrow = None if options.periodic or options.wall_layers else partial(narrow_hints, stack, size=counts.size)

    def bounded(hints: StackHints, sizes: dict[int, float]) -> tuple[Intervals, Callable[[], QuadMesh]]:
        found, lay = attempt(hints, sizes)

        def few() -> QuadMesh:
            quads = lay()
            _check_unasked(stack, len(quads.quads) * full, options)
            return quads

        return found, few

    def make(hints: StackHints) -> MadeStack:
        quads, finer = mesh_plane(stack, levels, hints, bounded, run, narrow=narrow)
        with run.stage("assembly"):
            straight = stacks.build_straight(stack, levels, quads)
            if straight is not None:
                return MadeStack(quads=quads, placed=straight, joined=blocks_of(stack, straight), notes=finer)
            built = stacks.build_mesh(stack, levels, quads)
        return MadeStack(quads=quads, placed=built, joined=_joined(stack, built), notes=finer)

    made, off = accurate_stack(part, stack, options, run, hints, make)
    run.expects(estimate.estimate_counted(expected, len(made.quads.quads), made.joined.n_hexes), settled=True)
    faces = stack.solid.faces
    mesh = finish(
        part,
        made.joined,
        options,
        run,
        notes=[*stack.notes, *dict.fromkeys(walls.plan.notes), *made.notes, *_without_effect(options)],
        found=off,
        # Nodes that answer others, or stand at a distance from a wall that was asked for, stay where they are.
        slides=None
        if options.periodic or options.wall_layers
        else partial(stacks.find_slides, stack, levels, made.quads, made.placed),
        sweeps=[
            {
                "source": [faces[i].shown for i in stack.source],
                "target": [faces[i].shown for i in stack.target],
                "layers": levels.n_layers,
                "direction": name_direction(stack.direction),
                "columns": stack.n_columns,
                "limit": round(stack.limit.value, 3),
                "upright_limit": round(stack.upright_limit.value, 3),
                "round_across": stacks.is_round_across(stack),
            }
        ],
    )
    if isinstance(mesh, HexMesh):
        mesh = with_pairs(mesh)
    report, notes = mesh.info["quality"], list(mesh.info["notes"])
    if report.min_scaled_jacobian < SMOOTH_BELOW:
        notes += _limits(stack, report.min_scaled_jacobian)
    return replace(mesh, info={**mesh.info, "notes": notes})


def _lay_plane(  # noqa: PLR0917
    prism: Part,
    cells: Sequence[intervals.CellSweep],
    counts: Intervals,
    asks: CellAsks,
    walls: surface.Walls | None,
    memory: surface.Memory,
) -> QuadMesh:
    """Mesh the plane as the source cap of the one cell of the prism over it."""
    fractions = fractions_of(prism, cells, [counts], asks.divisions, asks.wishes.alike)
    sizes = {} if asks.field is None else {0: asks.field}
    skeleton = surface.Skeleton(
        prism.solids, [counts], fractions=fractions, sizes=sizes, partners=asks.partners, memory=memory
    )
    sweep = cells[0].fill
    assert isinstance(sweep, Sweep), "a prism is swept"
    return skeleton.build_cap(0, sweep, walls=walls)


def _check_unasked(stack: Stack, n_hexes: int, options: SweepOptions) -> None:
    """Refuse columns that nobody asked to be so many: outlines that all but coincide in plan divide it very finely.

    Raises
    ------
    SurfaceMeshError
        Another direction, or cells, may do with fewer.
    """
    if options.size is None and options.tolerance is None and n_hexes > MOST_UNASKED:
        raise SurfaceMeshError(
            f"its columns along ({name_direction(stack.direction)}) would be about {n_hexes:,} hexahedra, where "
            "outlines of its faces nearly coincide"
        )


def _merged(known: _Known, size: float | None) -> _Known:
    """The stack with outlines laid together that nearly coincide in plan, or as it was."""
    stack = merged_stack(known.stack, intervals.default_size(known.stack.plan) if size is None else size)
    return known if stack is known.stack else _Known(stack, stacks.find_sheets(stack))


def _only_for_sweeps(options: SweepOptions) -> None:
    """Refuse what columns have no use for: their layers go by levels."""
    for name in ("fractions", "bias"):
        if getattr(options, name) is not None:
            raise InputError(f"{name} goes with a plain sweep, and this part is a stack of columns: try size and sizes")


def _without_effect(options: SweepOptions) -> list[str]:
    """The note on how layers are to be placed: in columns all nodes of one stand over each other, under any map."""
    usual = SweepOptions()
    names = [name for name in ("functional", "strategy", "residual") if getattr(options, name) != getattr(usual, name)]
    said = f"{' and '.join(names)} of no effect: the part is a stack of columns, which stand straight"
    return [said] if names else []


def _limits(stack: Stack, reached: float) -> list[str]:
    """What a poor mesh of a stack is told of its part.

    Upright columns are no bound: smoothing draws them aside. Where it went beyond theirs, they explain nothing.
    """
    said = "no hexahedron there has a scaled Jacobian above"
    if stack.limit.value < SMOOTH_BELOW:
        return [f"the part limits its columns: {stack.limit.reason}, so {said} {stack.limit.value:.2g}"]
    upright = stack.upright_limit
    if upright.value < SMOOTH_BELOW and reached <= upright.value:
        return [
            f"the part limits its columns: {upright.reason}, so {said} {upright.value:.2g} while columns are upright"
        ]
    return []


def _joined(stack: Stack, built: StackMesh) -> JoinedMesh:
    return JoinedMesh(
        points=built.points,
        hexes=built.hexes,
        hex_cells=np.zeros(len(built.hexes), dtype=np.int64),
        columns=built.columns,
        quads=built.quads,
        quad_cells=np.zeros(len(built.quads), dtype=np.int64),
        quad_faces=built.faces,
        edge_nodes={int(stack.solid.edge_keys[e]): nodes for e, nodes in built.edge_nodes.items()},
        roles={(0, f): role for role, own in (("source", stack.source), ("target", stack.target)) for f in own},
    )
