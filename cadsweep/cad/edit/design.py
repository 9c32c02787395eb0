"""The design of a solid: what it is without its blends, its other faces grown until they meet at sharp edges.

Place in the flow: what replaces an edge or a corner is told from outside; the model itself stays as it is.

Method: the solid is built anew from the faces that stay (:mod:`.sharpening`), without the blends that these do not
close over. Those are left to OpenCASCADE's defeaturing (:mod:`.defeaturing`), all at once, else those that hang
together, a group at a time, the small ones first; after some time no other group is tried. Halves of closed faces are
put together before that, and what is closed then is divided anew. Its word is not taken for it: the result is one
valid solid, every blend is gone, and the other faces answer one to one; a group that does not come to that stays in the
design.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

from ...brep import Part, Solid
from ..geometry.same_surface import dividing_edges
from ..heal.tracing import Traced, present
from ..heal.validate import faults
from ..shapes import FACE, SOLID, compound, index_map, listed, shapes_of, subshapes
from ..trial import attempted
from .collapsing import CannotCloseError, Rounding
from .defeaturing import read_without, remove
from .features import Feature, hanging_together
from .sharpening import Met, sharpen

log = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True, eq=False)
class Design:
    """A part without some of its blends.

    Attributes
    ----------
    part : Part
        Of one solid.
    model_faces : tuple of tuple of int
        For every face of the design the faces of the model on its surface that it is made of: pieces of one face, which
        OpenCASCADE puts together where it takes blends away.
    gone : frozenset of int
        Faces of the model that the design has not.
    left : tuple of str
        What could not be taken away, and why.
    """

    part: Part
    model_faces: tuple[tuple[int, ...], ...]
    gone: frozenset[int]
    left: tuple[str, ...] = ()


SECONDS = 10.0
"""Seconds of work after which no other group of blends is tried; one takes a second or less where it succeeds."""
_ONE = 5.0
"""Seconds that OpenCASCADE may take for one group: what takes longer has not been seen to succeed."""


def design_of(part: Part, blends: Sequence[Rounding]) -> Design | None:
    """Take the blends of a part of one solid away.

    Parameters
    ----------
    part : Part
    blends : sequence of Rounding

    Returns
    -------
    Design or None
        None where no blend can be taken away.
    """
    (solid,) = part.solids
    traced, left = Traced(shapes_of(solid).shape), list[str]()
    gone = _sharpened(solid, traced, blends)
    faces = {f for blend in blends for f in blend.faces} - gone
    _close(solid, traced)
    groups = sorted(hanging_together(solid, faces), key=len)
    began = _spent()
    for group in [sorted(faces), *groups] if len(groups) > 1 else groups:
        if gone.issuperset(group):
            continue
        if _spent() - began > SECONDS:
            left.append(f"{solid.faces[group[0]].label()} and {len(group) - 1} more stay: there is no time for them")
            continue
        why = _taken(solid, traced, group, gone)
        if not why:
            gone |= set(group)
        elif len(group) < len(faces) or len(groups) == 1:
            left.append(f"{solid.faces[group[0]].label()} and {len(group) - 1} more stay in the design: {why}")
    if not gone:
        return None
    found, _ = read_without(solid, traced)
    shape = subshapes(traced.shape, SOLID)[0]
    origins = _origins(solid, traced, gone, index_map(shape, FACE))
    own = replace(part, solids=(found,), models=(), owners=())
    return Design(part=own, model_faces=tuple(map(tuple, origins)), gone=frozenset(gone), left=tuple(left))


def _sharpened(solid: Solid, traced: Traced, blends: Sequence[Rounding]) -> set[int]:
    """Build the solid without as many blends as can be left out; their faces."""
    left, met = list(blends), Met()
    while left:
        try:
            found = sharpen(solid, left, met)
        except CannotCloseError as error:
            log.info("faces %s stay in the design: %s", sorted(error.faces), error)
            staying = [blend for blend in left if error.faces.isdisjoint(blend.faces)]
            left = staying if len(staying) < len(left) else []
            continue
        traced.shape = found.shape
        traced.faces = [[found.faces[face.id]] if face.id in found.faces else [] for face in solid.faces]
        traced.edges = [[found.edges[edge.id]] if edge.id in found.edges else [] for edge in solid.edges]
        break
    return {f for blend in left for f in blend.faces}


def _close(solid: Solid, traced: Traced) -> None:
    """Put the pieces of curved faces together: OpenCASCADE grows a whole cylinder, and fails on halves."""
    seams = {e for e in dividing_edges(solid) if solid.faces[solid.edges[e].faces[0]].kind != "plane"}
    if not seams:
        return
    copy = BRepBuilderAPI_Copy(traced.shape)
    tool = ShapeUpgrade_UnifySameDomain(copy.Shape(), True, True, False)
    for edge, shapes in zip(solid.edges, traced.edges, strict=True):
        if edge.id not in seams:
            for shape in shapes:
                tool.KeepShape(copy.ModifiedShape(shape))
    if not attempted(tool.Build, "putting closed faces together", seconds=_ONE):
        return
    solids = subshapes(tool.Shape(), SOLID)
    if len(solids) != 1 or faults(solids[0]):
        return
    history = tool.History()

    def image(sub: Any) -> Any:
        own = copy.ModifiedShape(sub)
        if history.IsRemoved(own):
            return None
        became = listed(history.Modified(own))
        return compound(became) if became else own

    traced.replace(solids[0], image)


def _spent() -> float:
    """Seconds that this process and the copies in which it tries things have worked."""
    now = os.times()
    return now.user + now.children_user


def _taken(solid: Solid, traced: Traced, group: Sequence[int], gone: set[int]) -> str:
    """Take a group away; what is wrong where that cannot be, and nothing is changed."""
    before = traced.shape, traced.faces, traced.edges
    why = remove(traced, Feature(what="blends", faces=tuple(group)), seconds=_ONE)
    if why:
        return why
    origins = _origins(solid, traced, gone | set(group), present(traced, FACE))
    kept = {f for own in origins for f in own}
    if all(origins) and len(kept) + len(gone | set(group)) == len(solid.faces):
        if all(len({solid.faces[f].names for f in own}) == 1 for own in origins):
            return ""
        why = "faces of two names become one"
    traced.shape, traced.faces, traced.edges = before
    return why or "other faces go with them"


def _origins(solid: Solid, traced: Traced, gone: Collection[int], there: Any) -> list[list[int]]:
    """For every face of a map, the faces of the solid that it is made of."""
    found: list[list[int]] = [[] for _ in range(there.Extent())]
    for face, images in zip(solid.faces, traced.faces, strict=True):
        for image in images if face.id not in gone else ():
            if there.Contains(image):
                found[there.FindIndex(image) - 1].append(face.id)
    return found


__all__ = ["SECONDS", "Design", "design_of"]
