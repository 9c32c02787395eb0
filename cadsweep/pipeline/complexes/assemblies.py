"""A model of several solids: the ones that touch meshed together, the others side by side, in one mesh.

Solids that share nothing with others get everything that a single solid gets (rings cut open, faces merged, order 2
by its own surfaces); those that share faces, edges or vertices are planned together.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice

from ... import cad, rows
from ...blocks.joined import neighbours_of
from ...brep import Part
from ...contacts import say_leave_out
from ...errors import CadSweepError, InputError
from ...mesh import HexMesh
from ...options import SweepOptions
from ..candidates import GOOD_ENOUGH
from ..origin import AnyMesh, worst_of
from ..remedies import MOST_HEXES
from ..run import Run, Tries, silent
from ..tips import AFTER, bridged, mesh_bridged_or_plain
from ..wishes.local_sizes import for_all_solids
from ..wishes.named_faces import solids_with
from ..wishes.shared_hints import check_words, meant_here, resolve_wishes
from .answering import answering
from .apart import MeshOne, mesh_alone, mesh_separate
from .clearance import put_clear
from .complex import Complex
from .complexes import find_plans, plan_again
from .groups import as_blocks, blocks_together, make_group, put_together
from .several import mesh_complex
from .subsets import separated, subset, touching_groups

log = logging.getLogger(__name__)

MOST_APART = 2
"""Solids at fault that are meshed by themselves to see whether that helps."""

MOST_MESHED = 3
"""Plans of solids in contact that are meshed before the best is taken, or they are not meshed together."""

_SAID = 5
"""Solids that a note names."""

_ONE_SWEEP = ("source", "target", "bias", "fractions", "rail_layers")


def mesh_assembly(part: Part, options: SweepOptions, run: Run, mesh_one: MeshOne) -> AnyMesh:
    """Mesh all cells of a part, conformally where they touch unless the user wants them separate.

    Of solids that cannot be meshed together the one at fault is taken out, and shares nothing with the others then,
    until what is left has meshes; unless the user wants all contacts shared.

    Raises
    ------
    InputError
        An option that is about one sweep.
    NotSweepableError, PlanError, SurfaceMeshError, ProjectionError, InvertedHexError
        A solid cannot be swept, or not so that it agrees with its neighbours.
    """
    part, asked = _asked(part, options)
    made: list[tuple[list[int], AnyMesh]] = []
    left_out: list[str] = []
    notes: list[str] = []
    waiting = touching_groups(part)
    while waiting:
        cells = waiting.pop(0)
        own = subset(part, cells)
        options = _asked_of(part, cells, asked)
        try:
            made.append((cells, _by_solid(own, _mesh_group(own, options, run.anew(), mesh_one))))
            continue
        except CadSweepError as error:
            if isinstance(error, InputError):
                raise  # what the user asked for, and no solid, is at fault
            if len(cells) > 1 and options.interfaces == "auto" and not asked.periodic:
                out = _at_fault(part, cells, error)
                part = separated(part, out)
                notes.append(f"{_say_apart([part.models[owner].name for owner in sorted(out)])}: {error.message}")
                waiting = [*([cells[c] for c in group] for group in touching_groups(subset(part, cells))), *waiting]
                continue
            name = part.models[part.owners[cells[0]]].name
            if options.skip_unmeshable and len(cells) == 1 and (made or waiting):
                left_out.append(name)
                notes.append(f"'{name}' is left out, as it cannot be meshed: {error.message}")
                continue
            raise _explained(part, own, error, options, mesh_one) from error
    if left_out:
        asked = replace(asked, skip=[*(asked.skip or ()), *left_out])

    def make(cells: list[int], tolerance: float) -> AnyMesh:
        own = subset(part, cells)
        tolerance = min(tolerance, asked.tolerance or tolerance)
        nearer = replace(_asked_of(part, cells, asked), tolerance=tolerance)
        mesh = _by_solid(own, _mesh_group(own, nearer, run.anew(), mesh_one))
        note = f"{tolerance:.3g} off the CAD at most, so as to keep apart from the solids beside it"
        return replace(mesh, info={**mesh.info, "notes": [*mesh.info["notes"], note]})

    whole = put_clear(made, lambda groups: _put_together(part, groups, asked, run), make, run)
    return replace(whole, info={**whole.info, "notes": [*whole.info["notes"], *notes]}) if notes else whole


def each_group(part: Part, options: SweepOptions, mesh_one: MeshOne) -> Iterator[tuple[Part, Callable[[Run], AnyMesh]]]:
    """The groups of solids that hang together, and what meshes each: for those who want to look at one by one.

    Raises
    ------
    InputError
        As by :func:`mesh_assembly`.
    """
    part, asked = _asked(part, options)
    for cells in touching_groups(part):
        own = subset(part, cells)
        yield own, partial(_mesh_group, own, _asked_of(part, cells, asked), mesh_one=mesh_one)


def _asked(part: Part, options: SweepOptions) -> tuple[Part, SweepOptions]:
    """The part, its solids apart where that is wanted, and what is asked of all of them."""
    _check_options(part, options)
    return (separated(part) if options.interfaces == "separate" else part), for_all_solids(part, options)


def _asked_of(part: Part, cells: Sequence[int], asked: SweepOptions) -> SweepOptions:
    """What is asked of one group."""
    layers = {w: value for w, value in (asked.wall_layers or {}).items() if solids_with(part, w) & set(cells)}
    return replace(asked, periodic=_about(part, cells, asked.periodic), wall_layers=layers or None)


def _put_together(
    part: Part, made: Sequence[tuple[Sequence[int], AnyMesh]], options: SweepOptions, run: Run
) -> AnyMesh:
    """One mesh of those of groups of cells; cells of no group are left out."""
    kept = sorted(cell for cells, _ in made for cell in cells)
    there = part if len(kept) == len(part.solids) else subset(part, kept)
    parts = [(subset(part, cells), mesh) for cells, mesh in sorted(made, key=lambda one: list(one[0]))]
    if run.in_blocks:
        return blocks_together(there, [(own, as_blocks(mesh)) for own, mesh in parts], options, run)
    groups = [make_group(own, mesh) for own, mesh in parts if isinstance(mesh, HexMesh)]
    return put_together(there, groups, options, run)


def _check_options(part: Part, options: SweepOptions) -> None:
    """Refuse what is about one sweep, and words that mean nothing of any solid."""
    for name in _ONE_SWEEP if len(part.models) > 1 else ():
        if getattr(options, name) is not None:
            raise InputError(
                f"{name} is about one sweep, and '{part.name}' has {len(part.models)} solids: choose one with part=, "
                "or use sizes and counts"
            )
    check_words(part, options)
    _check_periodic(part, options)
    for word in options.wall_layers or {}:
        if not solids_with(part, word):
            raise InputError(f"wall_layers: no face of any solid is called '{word}'")


def _mesh_group(part: Part, options: SweepOptions, run: Run, mesh_one: MeshOne) -> AnyMesh:
    """Mesh solids that hang together."""
    if len(part.solids) > 1:
        return mesh_bridged_or_plain(part, options, run, _mesh_together)
    if any(face.name in part.contacts for face in part.solids[0].faces):
        return mesh_separate(part, options, run, mesh_one)
    return mesh_alone(part, options, run, mesh_one)


def _at_fault(part: Part, cells: Sequence[int], error: CadSweepError) -> set[int]:
    """The solids of a group that are taken out of it: a third of those at fault, first those that share few faces."""
    owners = list(dict.fromkeys(part.owners[cell] for cell in cells))
    named = [owner for owner in owners if part.models[owner].name in error.solids] or owners
    shared = Counter(part.owners[cell] for cell, _ in neighbours_of(part))
    return set(sorted(named, key=lambda owner: shared[owner])[: max(1, len(named) // 3)])


def _say_apart(names: Sequence[str]) -> str:
    """That solids were taken out of their group, in words."""
    if len(names) == 1:
        return f"'{names[0]}' shares no nodes with what it touches"
    more = f" and {len(names) - _SAID} others" if len(names) > _SAID else ""
    said = ", ".join(f"'{name}'" for name in names[:_SAID])
    return f"{said}{more} share no nodes with what they touch, and are meshed each by itself"


def _explained(part: Part, own: Part, error: CadSweepError, options: SweepOptions, mesh_one: MeshOne) -> CadSweepError:
    """Why a group of solids has no mesh, with what to mesh instead."""
    alone = len(own.solids) == 1
    helps = not alone and _helps_apart(own, error.solids, options, mesh_one)
    at_fault = error.solids or ((own.models[0].name,) if alone else ())
    found = _proposing(error, at_fault, [model.name for model in part.models], apart=helps)
    found.solids = tuple(at_fault)
    return found


def _about(part: Part, cells: Sequence[int], periodic: Mapping[str, str] | None) -> dict[str, str] | None:
    """The matched faces of which both are on some solids of the part."""
    both = {
        one: other
        for one, other in (periodic or {}).items()
        if all(solids_with(part, word) & set(cells) for word in (one, other))
    }
    return both or None


def _check_periodic(part: Part, options: SweepOptions) -> None:
    """Refuse matched faces that are nowhere, or on solids that do not hang together."""
    together = separated(part) if options.interfaces == "separate" else part
    groups = touching_groups(together)
    for one, other in (options.periodic or {}).items():
        solids = [solids_with(together, word) for word in (one, other)]
        for word, own in zip((one, other), solids, strict=True):
            if not own:
                raise InputError(f"periodic: no face of any solid is called '{word}'")
        if not any(all(own & set(cells) for own in solids) for cells in groups):
            raise InputError(
                f"periodic: '{one}' and '{other}' are on solids that share no nodes: match faces of solids that touch"
            )


def _helps_apart(part: Part, names: Sequence[str], options: SweepOptions, mesh_one: MeshOne) -> bool:
    """Whether the solids that are at fault have meshes of their own, without the outlines of their contacts."""
    if options.interfaces == "separate" or not 0 < len(names) <= MOST_APART:
        return False
    alone = separated(part)
    own = SweepOptions(decompose=False, max_hexes=MOST_HEXES)
    for cells in touching_groups(alone):
        one = subset(alone, cells)
        if one.models[0].name in names:
            try:
                mesh_separate(one, own, Run(on_progress=silent), mesh_one)
            except CadSweepError as error:
                log.info("nor by itself: %s", error)
                return False
    return True


def _proposing(error: CadSweepError, solids: Sequence[str], among: Sequence[str], *, apart: bool) -> CadSweepError:
    """The same error, with what to mesh instead."""
    ways = (say_leave_out(solids, among), "interfaces='separate' meshes all, without shared nodes" if apart else "")
    said = ", or ".join(way for way in ways if way)
    if not said:
        return error
    return error.about(try_=said, reasons=[error.try_] if error.try_ else ())


def _mesh_together(part: Part, options: SweepOptions, run: Run, share: float) -> AnyMesh:
    """Mesh solids in contact by the first plan that does well, or the best; cuts take that share of their time.

    Booleans of OpenCASCADE may fail on solids whose tips are bridged: where these come as they are, it is their cells
    whose tips are bridged.
    """
    plans = find_plans(part, run.for_share(share), decompose=options.decompose)
    options = replace(options, biases=meant_here(part, options).biases)
    made: list[tuple[AnyMesh, set[str]]] = []
    failure: CadSweepError | None = None
    tries = Tries(run)
    for found in islice(plans, MOST_MESHED):
        try:
            with rows.share() as own, tries.one():
                mesh = _mesh_planned(found, options, run, share)
            made.append((mesh, {*own, *(f"cut: {cut.family}" for cut in found.part.cuts if cut.family)}))
        except InputError:
            raise
        except CadSweepError as error:
            log.info("%d cells given up: %s", len(found.part.solids), error)
            failure = failure or error
        if any(worst_of(mesh) >= GOOD_ENOUGH for mesh, _ in made) or tries.is_over():
            break
    if not made:
        assert failure is not None, "find_plans raises where there are none"
        raise failure
    mesh, shares = max(made, key=lambda one: worst_of(one[0]))
    rows.took(shares)
    return mesh


def _mesh_planned(found: Complex, options: SweepOptions, run: Run, share: float) -> AnyMesh:
    """Mesh the cells of a plan, the tips of these bridged where those of the solids are not."""

    def mesh_cells(cells: Part, options: SweepOptions, run: Run, _: float) -> AnyMesh:
        planned = found
        if cells is not found.part:
            planned = plan_again(found, cells, bridged(found.model, options))
            rows.took([AFTER])
        planned = answering(planned, options, run)
        return mesh_complex(planned, options, run, resolve_wishes(planned.part, options, planned.model))

    if rows.is_on(AFTER) and any(cad.has_sharp_corners(solid) for solid in found.model.solids):
        return mesh_bridged_or_plain(found.part, options, run, mesh_cells)
    return mesh_cells(found.part, options, run, share)


def _by_solid(part: Part, mesh: AnyMesh) -> AnyMesh:
    """The mesh of a group, its record saying of each solid how it was filled."""
    way = mesh.info["way"]
    names = dict.fromkeys(part.models[owner].name for owner in part.owners)
    return replace(mesh, info={**mesh.info, "way": dict.fromkeys(names, way) if isinstance(way, str) else way})
