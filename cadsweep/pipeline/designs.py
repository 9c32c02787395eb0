"""A solid meshed by its design: without its blends, by whatever way that takes, and then carried onto the model.

Place in the flow: a row of the ways of :mod:`.routes`, after one sweep and columns of the model itself.

Method: blends are found (:mod:`cadsweep.blends`) and taken away in a copy (``cad.design_of``). If the edges of that
design can be laid on the model's, it is meshed like any other solid, and its nodes go to the model's corners, edges and
faces (:func:`cadsweep.blends.carrying.carry`). What is inverted then is untangled. Borders of blends are no lines of
the mesh: a blend has the quads with middles on it.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from .. import cad, rows
from ..blends import Blend, find_blends
from ..blends.borders import BorderChoice
from ..blends.carrying import check_edges
from ..blends.patches import find_patches
from ..blends.sheets import SHEET, DesignMesh, with_sheet
from ..brep import Part, Solid, lie_in
from ..entity.entities import Entities
from ..errors import CadError, CadSweepError, NotSweepableError
from ..intervals.sizes import WANTED_HEXES
from ..mesh import HexMesh
from ..options import SweepOptions
from .candidates import SMOOTH_BELOW
from .laying import is_layered, laid_on_model
from .nearness.measured import quads_off
from .nearness.nearer import missed_tolerance
from .origin import AnyMesh, CellsOrigin, DesignChoice, FromDesign, to_be, with_last, worst_of
from .run import Run, Tries
from .wishes.design_words import left_to_design, on_design, speaks_of_entities, without_words
from .wishes.local_sizes import growing_from, no_larger_than

log = logging.getLogger(__name__)

_GOOD = 0.5
"""Worst scaled Jacobian at which no other design is tried."""

_ROUNDS = 2
"""Times that a mesh is made finer so as to be near enough to the model."""
_NEARER = 0.8
"""Share of the lengths at which the quads would just be as near."""
_NOTE = "meshed by its design, without {} faces of blends, and laid on them then"
_SPOKEN = "what is asked of faces and edges holds on the design, whose edges go on to where those of its blends meet"


def has_design(part: Part, options: SweepOptions, best: AnyMesh | None = None) -> bool:
    """Whether a solid has blends, and nothing is asked of rails, which a design may have others of.

    What is asked of faces and edges is kept to the letter by a mesh of the model itself, where there is one.

    Of a fair sweep only those between a cap and its sides leave a hexahedron two quads that meet smoothly: in the
    middle of a cap they are the bends of a sheet, between sides they round its outline. A poor one may be quite another
    without them.
    """
    if options.rail_layers is not None or (best is not None and speaks_of_entities(options)):
        return False
    (solid,) = part.solids
    shown = [face.shown for face in solid.faces]
    around = [
        {shown[f] for f in (*blend.faces, *chain.from_iterable(blend.supports))} for blend in find_blends(solid)
    ]  # fmt: skip
    if best is None or best.info["way"] != "sweep" or worst_of(best) < SMOOTH_BELOW:
        return bool(around)
    (sweep,) = best.info["sweeps"]
    caps = [set(sweep[cap]) for cap in ("source", "target")]
    return any(not any(faces <= cap for cap in caps) and any(faces & cap for cap in caps) for faces in around)


def mesh_design(
    part: Part, options: SweepOptions, run: Run, mesh_it: Callable[[Part, SweepOptions, Run], AnyMesh]
) -> HexMesh:
    """Mesh a part of one solid by the better of its designs; `mesh_it` meshes a design.

    Raises
    ------
    NotSweepableError
        It has none.
    CadSweepError
        No design can be meshed, or its mesh not be carried.
    """
    (solid,) = part.solids
    blends = left_to_design(part, find_blends(solid), options)
    views = Tries(run).of(_views(solid, blends, options.size))
    return _best_of((partial(_mesh_near, part, view, options, run, mesh_it) for view in views), run)


def design_like(
    part: Part,
    like: DesignChoice,
    options: SweepOptions,
    run: Run,
    mesh_it: Callable[[Part, SweepOptions, Run], AnyMesh],
) -> HexMesh:
    """Mesh a part by its design as another part was meshed.

    Raises
    ------
    CadError
        It has fewer blends.
    CadSweepError
        The design cannot be meshed so, or its mesh not be carried.
    """
    every = find_blends(part.solids[0])
    if len(every) <= max(like.blends):
        raise CadError(f"the parts do not correspond: '{part.name}' has {len(every)} blends, and the mesh's part more")
    own = [every[number] for number in like.blends]
    return with_last(_mesh_without(part, own, options, run, mesh_it, like))


def _best_of(makes: Iterable[Callable[[], HexMesh]], run: Run) -> HexMesh:
    """The first mesh that does well, or the best of all.

    Raises
    ------
    CadSweepError
        None can be made; why the last could not.
    """
    best: HexMesh | None = None
    shares: set[str] = set()
    refused: CadSweepError = NotSweepableError("the solid has no blends")
    tries = Tries(run)
    for make in makes:
        if best is not None and (worst_of(best) >= _GOOD or tries.is_over()):
            break
        try:
            with rows.share() as own, tries.one():
                mesh = make()
        except CadSweepError as error:
            log.info("a design was given up: %s", error)
            refused = error
            continue
        if best is None or worst_of(mesh) > worst_of(best):
            best, shares = mesh, own
    if best is None:
        raise refused
    rows.took(shares)
    return best


def _views(solid: Solid, blends: list[Blend], size: float | None) -> Iterator[list[Blend]]:
    """Which blends are left out: at first not those that may be a piece of an outline, then all.

    Two quads of one hexahedron meet at 180 degrees where a convex edge of the design is rounded; a rounding by itself
    that is wider than the size can have quads of its own wherever it is a wall.
    """
    wide = (solid.volume / WANTED_HEXES) ** (1.0 / 3.0) if size is None else size / solid.units.scale
    alone = [set(group) for group in cad.hanging_together(solid, [f for blend in blends for f in blend.faces])]
    kept = [
        blend for blend in blends
        if blend.kind == "edge" and blend.convex and blend.turn * blend.radii[0] > wide and set(blend.faces) in alone
    ]  # fmt: skip
    if 0 < len(kept) < len(blends):
        yield [blend for blend in blends if blend not in kept]
    yield blends


def _mesh_near(
    part: Part,
    blends: list[Blend],
    options: SweepOptions,
    run: Run,
    mesh_it: Callable[[Part, SweepOptions, Run], AnyMesh],
) -> HexMesh:
    """As :func:`_mesh_without`, finer where it is farther off the blends than asked, or the nearest of a few."""
    mesh = _mesh_without(part, blends, options, run, mesh_it)
    if options.tolerance is None:
        return mesh
    asked = options.tolerance
    made = [(mesh, min(mesh, with_last(mesh), key=_off))]
    for _ in range(_ROUNDS):
        if min(_off(last) for _, last in made) <= asked or run.is_over():
            break
        last = made[-1][1]
        places, needed = quads_off(last.origin.part, last.origin.joined, asked / part.scale)
        if not len(places):
            break  # it is edges that are off
        options = no_larger_than(growing_from(places, _NEARER * needed), part, options)
        try:
            mesh = _mesh_without(part, blends, options, run, mesh_it)
            made.append((mesh, min(mesh, with_last(mesh), key=_off)))
        except CadSweepError as error:
            log.info("a nearer mesh of a design was given up: %s", error)
            break
    mesh, last = min(made, key=lambda own: _off(own[1]))
    if _off(last) > asked:
        missed = missed_tolerance(_off(last), options, "not every border of a blend is a line of the mesh")
        last = replace(last, info={**last.info, "notes": [*last.info["notes"], missed]})
    return to_be(mesh, lambda: last)


def _off(mesh: HexMesh) -> float:
    """How far a mesh is off the model."""
    return float(mesh.info["distance"])


def _mesh_without(  # noqa: PLR0917
    part: Part,
    blends: list[Blend],
    options: SweepOptions,
    run: Run,
    mesh_it: Callable[[Part, SweepOptions, Run], AnyMesh],
    like: DesignChoice | None = None,
) -> HexMesh:
    """Mesh the design without some blends, and carry it onto the model, the better with a sheet and without."""
    with run.stage("design"):
        design = cad.design_of(part, blends)
    if design is None:
        raise NotSweepableError("the solid has no blends that can be left out")
    (solid,), patch_of = part.solids, find_patches(part.solids[0], blends, design.gone, design.model_faces)
    own = np.array([faces[0] for faces in design.model_faces], dtype=np.int64)
    check_edges(solid, design.gone, patch_of, design.part.solids[0], own)
    own_part, own_options = on_design(part, design, replace(options, order=1, refine=0))
    made = mesh_it(own_part, own_options, replace(run, measure=None))
    assert isinstance(made, HexMesh), "in memory"
    made = without_words(made, design.part)
    assert isinstance(made.origin, CellsOrigin), "one solid"
    plain = _on_design(solid, made.origin.entities)
    is_tried = rows.is_on(SHEET) and not is_layered(options) if like is None else like.is_sheeted
    sheeted = with_sheet(plain, patch_of, blends) if is_tried else None
    numbers = tuple(number for number, blend in enumerate(find_blends(solid)) if blend in blends)
    roles = _roles_of(made.origin) if like is None else like.roles
    notes = [_NOTE.format(len(design.gone)), *design.left]
    notes += [_SPOKEN] if speaks_of_entities(options) else []

    def lay(laid: DesignMesh) -> HexMesh:
        borders = None if like is None else like.borders
        mesh, bordered = laid_on_model(part, blends, design, patch_of, laid, roles, notes, options, run, borders)
        if laid is sheeted:
            rows.took([SHEET])

        def told(mesh: HexMesh, borders: BorderChoice) -> HexMesh:
            assert isinstance(mesh.origin, CellsOrigin), "one solid"
            choice = DesignChoice(numbers, roles, laid is sheeted, borders)
            info = {**mesh.info, "sweeps": made.info["sweeps"], "way": made.info["way"]}
            return replace(mesh, origin=replace(mesh.origin, design=FromDesign(made, choice)), info=info)

        return to_be(told(mesh, ()), lambda: told(*bordered()))

    ways = [laid for laid in (sheeted, plain) if laid is not None]
    return _best_of((partial(lay, laid) for laid in (ways if like is None else ways[:1])), run)


def _on_design(solid: Solid, made: Entities) -> DesignMesh:
    """The mesh of a design; its quads are on faces of the model."""
    by_key = {face.key or f"face {face.id}": face.id for face in reversed(solid.faces)}
    quads, faces = [], []
    for place, own in made.faces.items():
        if not made.names.of(place):
            continue
        face = made.face(place)
        found = np.full(len(own), by_key[face.key], dtype=np.int64)
        middles = made.points[own].mean(axis=1)
        for patch, inside in zip(face.former, lie_in(face.former, middles), strict=True):
            found[inside] = by_key[patch.key]
        quads.append(own)
        faces.append(found)
    return DesignMesh(made.points, made.joined.hexes, np.concatenate(quads), np.concatenate(faces))


def _roles_of(origin: CellsOrigin) -> dict[str, str]:
    """Roles of the design's faces, by key; those of two kinds have none."""
    own = origin.joined.roles
    found: dict[str, set[str]] = {}
    for cell, solid in enumerate(origin.part.solids):
        for face in solid.faces:
            if origin.names.of((cell, face.id)):
                found.setdefault(face.key, set()).add(own.get((cell, face.id), "side"))
    return {key: next(iter(kinds)) for key, kinds in found.items() if len(kinds) == 1}


__all__ = ["design_like", "has_design", "mesh_design"]
