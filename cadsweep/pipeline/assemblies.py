"""A model of several solids: the ones that touch meshed together, the others side by side, in one mesh.

Solids that share nothing with others get everything that a single solid gets (rings cut open, faces merged, order 2
by its own surfaces); those that share faces, edges or vertices are planned together.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from .. import cad
from ..brep import Part
from ..contacts import say_leave_out
from ..errors import CadError, CadSweepError, InputError
from ..mesh import HexMesh
from ..options import SweepOptions
from .complexes import plan_cells
from .groups import as_blocks, blocks_together, make_group, put_together
from .local_sizes import for_all_solids
from .origin import AnyMesh
from .remedies import MOST_HEXES
from .run import Run, silent
from .several import mesh_complex
from .shared_hints import check_words, has_face, local_biases, local_hints, resolve_wishes
from .subsets import separated, subset, touching_groups

log = logging.getLogger(__name__)

MOST_APART = 2
"""Solids at fault that are meshed by themselves to see whether that helps."""

_ONE_SWEEP = ("source", "target", "bias", "fractions", "rail_layers")


MeshOne = Callable[[Part, SweepOptions, Run], AnyMesh]
"""Meshes a part of one solid by whatever way applies."""


def mesh_assembly(part: Part, options: SweepOptions, run: Run, mesh_one: MeshOne) -> AnyMesh:
    """Mesh all cells of a part, conformally where they touch unless the user wants them separate.

    Raises
    ------
    InputError
        An option that is about one sweep.
    NotSweepableError, PlanError, SurfaceMeshError, ProjectionError, InvertedHexError
        A solid cannot be swept, or not so that it agrees with its neighbours.
    """
    for name in _ONE_SWEEP if len(part.models) > 1 else ():
        if getattr(options, name) is not None:
            raise InputError(
                f"{name} is about one sweep, and '{part.name}' has {len(part.models)} solids: choose one with part=, "
                "or use sizes and counts"
            )
    check_words(part, options)
    _check_periodic(part, options)
    for word in options.wall_layers or {}:
        if not has_face(part, word):
            raise InputError(f"wall_layers: no face of any solid is called '{word}'")
    options = for_all_solids(part, options)
    if options.interfaces == "separate":
        part = separated(part)
    made: list[tuple[Part, AnyMesh]] = []
    asked = options
    for cells in touching_groups(part):
        own = subset(part, cells)
        layers = {word: value for word, value in (asked.wall_layers or {}).items() if has_face(own, word)}
        options = replace(asked, periodic=_about(own, asked.periodic), wall_layers=layers or None)
        alone = len(cells) == 1
        try:
            if not alone:
                mesh: AnyMesh = _mesh_together(own, options, run)
            elif options.interfaces == "separate":
                mesh = _mesh_separate(own, options, run, mesh_one)
            else:
                mesh = _mesh_alone(own, options, run, mesh_one)
        except CadSweepError as error:
            if isinstance(error, InputError):
                raise  # what the user asked for, and no solid, is at fault
            apart = not alone and _helps_apart(own, error.solids, options, mesh_one)
            at_fault = error.solids or ((own.models[0].name,) if alone else ())
            raise _proposing(error, at_fault, [model.name for model in part.models], apart=apart) from error
        made.append((own, mesh))
    if run.in_blocks:
        return blocks_together(part, [(own, as_blocks(mesh)) for own, mesh in made], asked, run)
    groups = [make_group(own, mesh) for own, mesh in made if isinstance(mesh, HexMesh)]
    return put_together(part, groups, asked, run)


def _about(part: Part, periodic: Mapping[str, str] | None) -> dict[str, str] | None:
    """The matched faces of which both are on solids of this part."""
    both = {one: other for one, other in (periodic or {}).items() if has_face(part, one) and has_face(part, other)}
    return both or None


def _check_periodic(part: Part, options: SweepOptions) -> None:
    """Refuse matched faces that are nowhere, or on solids that do not hang together."""
    together = part if options.interfaces == "shared" else separated(part)
    groups = [subset(together, cells) for cells in touching_groups(together)]
    for one, other in (options.periodic or {}).items():
        for word in (one, other):
            if not has_face(part, word):
                raise InputError(f"periodic: no face of any solid is called '{word}'")
        if not any(has_face(own, one) and has_face(own, other) for own in groups):
            raise InputError(
                f"periodic: '{one}' and '{other}' are on solids that share no nodes: match faces of solids that touch"
            )


def _helps_apart(part: Part, names: Sequence[str], options: SweepOptions, mesh_one: MeshOne) -> bool:
    """Whether the solids that are at fault have meshes of their own, without the outlines of their contacts."""
    if options.interfaces != "shared" or not 0 < len(names) <= MOST_APART:
        return False
    alone = separated(part)
    own = SweepOptions(decompose=False, max_hexes=MOST_HEXES)
    for cells in touching_groups(alone):
        one = subset(alone, cells)
        if one.models[0].name in names:
            try:
                _mesh_separate(one, own, Run(on_progress=silent), mesh_one)
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


def _mesh_together(part: Part, options: SweepOptions, run: Run) -> AnyMesh:
    with run.stage("recognition"):
        found = plan_cells(part, run, decompose=options.decompose)
        wishes = resolve_wishes(found.part, options, found.model)
    return mesh_complex(found, replace(options, biases=local_biases(part, options)), run, wishes)


def _mesh_separate(part: Part, options: SweepOptions, run: Run, mesh_one: MeshOne) -> AnyMesh:
    """One solid by itself, with the outlines of its contacts or, where these are in the way, without.

    Cuts come last: a solid is not cut for an outline that nothing needs.
    """
    first: CadSweepError | None = None
    for decompose in (False, True) if options.decompose else (False,):
        own = replace(options, decompose=decompose)
        try:
            return _mesh_alone(part, own, run, mesh_one)
        except CadSweepError as error:
            if isinstance(error, InputError | CadError):
                raise
            first = first or error
        original = cad.part_apart(part)
        if original is not None and len(original.solids[0].faces) < len(part.solids[0].faces):
            try:
                return _mesh_alone(original, own, run, mesh_one)
            except CadSweepError as error:
                log.info("nor without the outlines of contacts: %s", error)
    assert first is not None
    raise first


def _mesh_alone(part: Part, options: SweepOptions, run: Run, mesh_one: MeshOne) -> AnyMesh:
    """One solid by itself, with what is asked of it."""
    name = part.models[0].name
    hints = local_hints(part, options)
    own = replace(
        options,
        sizes=hints.sizes or None,
        counts=hints.counts or None,
        biases=hints.biases or None,
        interfaces="shared",
        only=None,
        skip=None,
    )
    if options.sizes and name in options.sizes:
        own = replace(own, size=options.sizes[name])
    return mesh_one(part, own, run)
