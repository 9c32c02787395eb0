"""What a refusal advises: options that were seen to give a mesh of this part, and no others.

Place in the flow: :mod:`.routes` asks where every way has refused a solid. What could be said is tried, the likeliest
first, until one gives a mesh or the time for it is gone: cuts where they were not allowed, small features left out,
the feature with the face that is most in the way left out, the part cut along a plane beside that face; and, where a
mesh was made and is not valid, other sizes.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import pi
from typing import Any

from .. import cad
from ..brep import Part
from ..errors import CadSweepError, NotSweepableError
from ..options import SweepOptions
from ..recognition.reasons import TANGENT, planes_beside
from .candidates import pointed_of
from .run import Run

log = logging.getLogger(__name__)

SECONDS = 5.0
"""Processor time after which nothing more is tried; what is under way is ended by itself."""
MOST_FACES = 60
"""Faces of a solid up to which remedies are tried: of larger ones an attempt alone may take longer."""
MOST_BLAMED = 2
"""Faces in the way that are looked at."""

MOST_HEXES = 60_000
"""Hexahedra of a mesh that is made to see whether it can be made."""
COARSE = 1 / 15
"""Size, in sizes of the part, that is tried half of where none was asked for."""

UNTRIED = "leave the feature with that face out of the model"
"""What a refusal says where nothing is tried: the solid has many faces, or its user has cut it."""
NO_REMEDY = f"{UNTRIED}; cuts and suppressing it were tried, and do not help"
"""What a refusal says where nothing helps that could be tried."""
NO_FEATURE = "give it another shape there: it has no feature that could be cut off or left out"
"""The same of a solid without an inner corner."""

Mesh = Callable[[Part, SweepOptions, Run], Any]


def proposing(part: Part, options: SweepOptions, refused: NotSweepableError, mesh: Mesh) -> NotSweepableError:
    """The refusal of a part of one solid, with the corner that no hexahedron fits into, and what helps.

    Parameters are those of :func:`find_remedy`.
    """
    pointed = pointed_of(part.solids[0])
    helps = find_remedy(part, options, refused, mesh)
    known = refused.about(where=pointed, reasons=[refused.where]) if pointed else refused
    if helps:
        return known.about(try_=helps)
    if refused.try_:
        return known
    from .fitted_grids import asked_in_vain  # hardly any part comes here

    kept = asked_in_vain(options) if options.fitted is not False else []
    if kept:
        return known.about(try_=f"leave {', '.join(kept)} out: a fitted grid, which has none, may fill the part then")
    if pointed:
        return known.about(try_="move one of the features there, so that they cross or keep apart")
    is_convex = max(edge.dihedral for edge in part.solids[0].edges) < pi + TANGENT
    if is_convex:
        return known.about(try_=NO_FEATURE)
    return known.about(try_=NO_REMEDY if _may_help(part, options) else UNTRIED)


def find_remedy(part: Part, options: SweepOptions, refused: CadSweepError, mesh: Mesh) -> str:
    """The option with which the part has a mesh, in words; empty where none was found.

    Parameters
    ----------
    refused : CadSweepError
        That it has no sweep, or what is wrong with its meshes.
    mesh : callable
        Meshes a part of one solid without a search for cuts, or raises.
    """
    if not _may_help(part, options):
        return ""
    short = Run.within(SECONDS)
    plain = SweepOptions(decompose=False, max_hexes=MOST_HEXES)
    trials = _other_shapes(part, options, refused) if isinstance(refused, NotSweepableError) else _sizes(part, options)
    for words, asked in trials:
        if short.is_over():
            return ""
        try:
            own = cad.suppress(part, asked.pop("suppress"), seconds=SECONDS) if "suppress" in asked else part
            wanted = replace(plain if isinstance(refused, NotSweepableError) else options, **asked)
            mesh(own, wanted, short)
        except CadSweepError as error:
            log.info("%s does not help: %s", words, error)
            continue
        return words
    return ""


def _may_help(part: Part, options: SweepOptions) -> bool:
    """Whether remedies are tried at all."""
    return len(part.solids) == 1 and len(part.solids[0].faces) <= MOST_FACES and not options.cuts


def _sizes(part: Part, options: SweepOptions) -> Iterator[tuple[str, dict[str, Any]]]:
    """Other sizes, for a part whose meshes are not valid: finer, and what is chosen where none is asked for."""
    own = options.size or COARSE * part.solids[0].size * part.scale
    for share in (2, 4):
        size = float(f"{own / share:.2g}")
        yield f"a smaller size: size={size:g}", {"size": size, "max_hexes": MOST_HEXES}
    if options.size is not None:
        yield "no size: the part has a mesh then", {"size": None, "max_hexes": MOST_HEXES}


def _other_shapes(
    part: Part, options: SweepOptions, refused: NotSweepableError
) -> Iterator[tuple[str, dict[str, Any]]]:
    """What may be tried of a part without a sweep, in words that a user can type, and as options."""
    solid = part.solids[0]
    if not options.decompose:
        yield "leave decompose=False out: cuts give a mesh", {"decompose": True}
    small = cad.small_features(part)
    if small:
        yield f"suppress={small}, without small features", {"suppress": small}
    blamed = [face for face in refused.faces if face < len(solid.faces)][:MOST_BLAMED]
    planes = list(dict.fromkeys(p for face in blamed for p in planes_beside(solid, face)))[: 2 * MOST_BLAMED]
    for face in blamed:
        known = solid.faces[face].known
        if known >= 0:
            word = [f"face {known}"]
            yield f"suppress={word}, without the feature with that face", {"suppress": word}
    for plane in planes:
        word = [f"face {solid.faces[plane].known}"]
        yield f"cuts={word}, along the plane of that face", {"cuts": word}


__all__ = ["find_remedy"]
