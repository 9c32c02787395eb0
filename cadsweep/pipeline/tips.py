"""Tips of faces bridged and marks on them flattened, for all ways to a mesh at once.

Place in the flow: :mod:`.routes` and :mod:`.complexes.assemblies` hand over solids that hang together and what meshes
them; :mod:`.finished.like` does the same to others.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection
from dataclasses import replace
from math import inf

from .. import cad, rows
from ..brep import Part
from ..errors import CadSweepError
from ..intervals.sizes import WANTED_HEXES
from ..options import SweepOptions
from .candidates import SMOOTH_BELOW
from .judging import FAR_WORSE, is_poor, reached_by
from .origin import AnyMesh, worst_of
from .run import Run

log = logging.getLogger(__name__)

MARKS = "part: marks flattened"
"""The row of low embossing that is left out."""
HIGHER = "part: higher marks flattened"
"""The row of embossing higher than that, where a solid has no good mesh with it."""
HIGHER_NOTE = "marks were flattened though higher than bridge"
TIPS = "part: tips bridged"
"""The row of faces that end before their tips."""
AFTER = "part: tips bridged after cuts"
"""The row of solids in contact that are cut as they are, and whose cells have their tips bridged."""
BRIDGE, HIGHEST = 0.05, 0.3
"""Distance, as a share of the size, up to which the mesh may leave the CAD there: less than is seen of its quads; and
where there is no good mesh that does not: less than one of its hexahedra can show."""
LOOK = 0.5
"""Share of the time of a search for cells."""
MOST_FACES = 60
"""Faces up to which a search for cells, and a design, are worth their seconds twice."""


def bridged(part: Part, options: SweepOptions) -> Part:
    """A part whose faces end before their tips, as far as the options let the mesh leave the CAD."""
    if options.bridge == 0.0 or not rows.is_on(TIPS):
        return part
    if not any(cad.has_sharp_corners(solid) for solid in part.solids):
        return part
    return cad.bridge_tips(part, _length(part, options))


def flattened(part: Part, options: SweepOptions) -> Part:
    """A part without embossing and engraving that is lower than the options let the mesh leave the CAD."""
    found = _flattened(part, options, MARKS, _length(part, options))
    if found is not part:
        rows.took([MARKS])
    return found


def flattened_higher(part: Part, options: SweepOptions) -> Part:
    """A part without embossing and engraving that is a little higher, where its user says nothing of that."""
    if options.bridge is not None:
        return part
    # A large size is no word about what may be left out.
    found = _flattened(part, options, HIGHER, min(_length(part, options, HIGHEST), HIGHEST * _usual_size(part)))
    if found is part:
        return part
    note = f"{HIGHER_NOTE}, as there is no good mesh with them; bridge=0 (--bridge 0) keeps them"
    return replace(found, notes=(*found.notes, note))


def _flattened(part: Part, options: SweepOptions, row: str, length: float) -> Part:
    if options.bridge == 0.0 or not rows.is_on(row):
        return part
    if all(len(face.loops) == 1 for solid in part.solids for face in solid.faces):
        return part
    return cad.flatten_marks(part, length)


def _length(part: Part, options: SweepOptions, share: float = BRIDGE) -> float:
    """How far the mesh may leave the CAD, model units; a share of the size, where the user says nothing."""
    if options.bridge is not None:
        return options.bridge
    asked = _usual_size(part) if options.size is None else options.size
    return min(share * min(asked, *(options.sizes or {}).values(), inf), options.tolerance or inf)


def _usual_size(part: Part) -> float:
    """The size, model units, of as many hexahedra as a part has where none is asked for."""
    wanted = WANTED_HEXES * len(part.models) ** 0.5
    return float((sum(solid.volume for solid in part.solids) * part.scale**3 / wanted) ** (1.0 / 3.0))


def mesh_marked_or_bare(
    part: Part,
    options: SweepOptions,
    run: Run,
    mesh_it: Callable[[Part, SweepOptions, Run], AnyMesh],
    *,
    last: Collection[str] = (),
) -> AnyMesh:
    """Mesh a part of one solid with its marks; without them where a mesh with them is poor, or one of the last ways.

    Raises
    ------
    CadSweepError
        Neither can be meshed; why the part with its marks cannot.
    """
    bare = flattened_higher(part, options)
    if bare is part:
        return mesh_it(part, options, run)
    mesh: AnyMesh | None = None
    refused: CadSweepError | None = None
    try:
        with rows.share() as shares, rows.without(last):
            mesh = mesh_it(part, options, run)
    except CadSweepError as error:
        refused = error
    if mesh is None or is_poor(mesh, part.solids[0], options):
        try:
            with rows.share() as own:
                other = mesh_it(bare, options, run.anew())
        except CadSweepError as error:
            log.info("not with its marks flattened: %s", error)
            if refused is not None:
                raise refused from None
        else:
            if mesh is None or worst_of(other) >= FAR_WORSE * worst_of(mesh):
                mesh, shares = other, {*own, HIGHER}
    assert mesh is not None, "else it is refused"
    rows.took(shares)
    return mesh


def mesh_bridged_or_plain(
    part: Part,
    options: SweepOptions,
    run: Run,
    mesh_it: Callable[[Part, SweepOptions, Run, float], AnyMesh],
    *,
    last: Collection[str] = (),
    slow: Collection[str] = (),
) -> AnyMesh:
    """Mesh solids that hang together with their tips bridged where that does well, else by whichever does better.

    Parameters
    ----------
    part : Part
    options : SweepOptions
    run : Run
    mesh_it : callable
        Meshes a part by the ways that are switched on; its last argument is their share of a search's time.
    last : collection of str
        Ways that are tried with the plain part alone.
    slow : collection of str
        And those that are, too, where the part has many faces, or keeps a tip that limits it whatever is done.

    Raises
    ------
    CadSweepError
        Neither can be meshed; why the plain part cannot.
    """
    found = bridged(part, options)
    if found is part:
        return mesh_it(part, options, run, 1.0)
    made: list[tuple[AnyMesh, set[str]]] = []
    few = sum(len(solid.faces) for solid in found.solids) <= MOST_FACES
    few &= not any(cad.has_sharp_corners(solid) for solid in found.solids)
    try:
        with rows.share() as own, rows.without(last if few else [*last, *slow]):
            made.append((mesh_it(found, options, run.for_share(LOOK), LOOK), {*own, TIPS}))
    except CadSweepError as error:
        log.info("not with its tips bridged: %s", error)
    if not made or min(reached_by(made[0][0], solid) for solid in found.solids) < SMOOTH_BELOW:
        try:
            with rows.share() as own:
                made.append((mesh_it(part, options, run, 1.0), own))
        except CadSweepError:
            if not made:
                raise
    mesh, shares = max(made, key=lambda one: worst_of(one[0]))
    rows.took(shares)
    return mesh


__all__ = [
    "AFTER",
    "BRIDGE",
    "HIGHER",
    "HIGHER_NOTE",
    "MARKS",
    "TIPS",
    "bridged",
    "flattened",
    "flattened_higher",
    "mesh_bridged_or_plain",
    "mesh_marked_or_bare",
]
