"""Tips of faces bridged and marks on them flattened, for all ways to a mesh at once.

Place in the flow: :mod:`.routes` and :mod:`.complexes.assemblies` hand over solids that hang together and what meshes
them; :mod:`.finished.like` does the same to others.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection
from math import inf

from .. import cad, rows
from ..brep import Part
from ..errors import CadSweepError
from ..intervals.sizes import WANTED_HEXES
from ..options import SweepOptions
from .candidates import SMOOTH_BELOW
from .judging import reached_by
from .origin import AnyMesh, worst_of
from .run import Run

log = logging.getLogger(__name__)

MARKS = "part: marks flattened"
"""The row of low embossing that is left out."""
TIPS = "part: tips bridged"
"""The row of faces that end before their tips."""
AFTER = "part: tips bridged after cuts"
"""The row of solids in contact that are cut as they are, and whose cells have their tips bridged."""
BRIDGE = 0.05
"""Distance, as a share of the size, up to which the mesh may leave the CAD there: less than is seen of its quads."""
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
    if options.bridge == 0.0 or not rows.is_on(MARKS):
        return part
    if all(len(face.loops) == 1 for solid in part.solids for face in solid.faces):
        return part
    found = cad.flatten_marks(part, _length(part, options))
    if found is not part:
        rows.took([MARKS])
    return found


def _length(part: Part, options: SweepOptions) -> float:
    """How far the mesh may leave the CAD, model units."""
    if options.bridge is not None:
        return options.bridge
    wanted = WANTED_HEXES * len(part.models) ** 0.5
    size = (sum(solid.volume for solid in part.solids) * part.scale**3 / wanted) ** (1.0 / 3.0)
    asked = size if options.size is None else options.size
    return min(BRIDGE * min(asked, *(options.sizes or {}).values(), inf), options.tolerance or inf)


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


__all__ = ["AFTER", "BRIDGE", "MARKS", "TIPS", "bridged", "flattened", "mesh_bridged_or_plain"]
