"""Marks flattened: embossing and engraving that is too low for the mesh to show.

Place in the flow: called by the pipeline for what the user gave, before anything looks at its faces.

A dot beside a pin, a logo, the segments of a display stand some hundredths above a face that is hundreds of times as
long, and every corner of theirs would be followed by slender hexahedra through the whole part. The face goes on beneath
them instead: it loses the loops around a mark, and the mark's faces become patches of it, which have the quads whose
middles lie over them.

Method: no boolean. From a loop inside a face neighbours are taken in up to where they end; they are a mark if all of
them are within a distance of that face's surface and nothing but whole loops of it bounds them.

Not handled: marks that reach the border of their face, marks on splines, faces in contact.
"""

from __future__ import annotations

import logging
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from OCP.BRep import BRep_Builder

from ...brep import Face, Part, Solid
from ...errors import CadError
from ..heal.tracing import Traced
from ..heal.validate import faults
from ..shapes import EDGE, FACE, SolidShape, children, compound, index_map, shapes_of, subshapes, typed
from .merging import former_face
from .splitting import faces_in_contact, in_order, read_anew

log = logging.getLogger(__name__)

_KINDS = ("plane", "cylinder", "cone", "sphere")
"""Faces that go on beneath what stands on them."""
_SEEN = 0.5
"""Least cosine between the normals of a face of a mark and of the face below it, from which on that is seen from it."""
_FLAT = 1e-6
"""Height, in sizes of the part, up to which what is within a loop only divides the face, as for a load: no mark."""


@dataclass(frozen=True, eq=False)
class Mark:
    """What stands on a face within some of its inner loops.

    Attributes
    ----------
    base : int
        The face.
    edges : frozenset of int
        Of those loops.
    faces : tuple of int
        Of the mark.
    height : float
        How far it is off the face at most, working units.
    """

    base: int
    edges: frozenset[int]
    faces: tuple[int, ...]
    height: float


def flatten_marks(part: Part, length: float) -> Part:
    """Let faces go on beneath what stands on them, or is sunk into them, by less than a length.

    Parameters
    ----------
    part : Part
    length : float
        Model units.

    Returns
    -------
    Part
        The same solids with fewer faces; the part itself where it has no such marks.
    """
    if not all(isinstance(solid.kernel, SolidShape) for solid in part.solids):
        return part
    marks: dict[int, list[Mark]] = {}
    for cell, (solid, in_contact) in enumerate(zip(part.solids, faces_in_contact(part), strict=True)):
        found = find_marks(solid, length / part.scale, in_contact)
        if found:
            marks[cell] = found
    if not marks:
        return part
    try:
        return _flattened(part, marks)
    except (CadError, ValueError, RuntimeError) as error:
        log.info("marks cannot be flattened: %s", error)
        return part


def find_marks(solid: Solid, length: float, kept: Collection[int] = frozenset()) -> list[Mark]:
    """The marks of a solid that are lower than a length, working units; `kept` faces are none and have none."""
    taken: set[int] = set(kept)
    found = []
    for face in sorted(solid.faces, key=lambda face: -face.area):
        if face.kind not in _KINDS or face.id in taken:
            continue
        for loop in face.loops[1:]:
            mark = _mark(solid, face, loop.edges[0], length)
            if mark is not None and taken.isdisjoint(mark.faces):
                found.append(mark)
                taken |= {face.id, *mark.faces}
    return found


def _mark(solid: Solid, base: Face, edge: int, length: float) -> Mark | None:
    """What stands within the inner loop of a face that an edge is of."""
    waiting = [f for f in solid.edges[edge].faces if f != base.id]
    faces: set[int] = set()
    height = 0.0
    while waiting:
        f = waiting.pop()
        if f in faces:
            continue
        away = _distance(solid, solid.faces[f], base)
        if away > length:
            return None
        faces.add(f)
        height = max(height, away)
        waiting += [g for e in solid.faces[f].edges for g in solid.edges[e].faces if g != base.id]
    outlines = {e for e in base.edges if not faces.isdisjoint(solid.edges[e].faces)}
    inside = [set(loop.edges) for loop in base.loops[1:] if not outlines.isdisjoint(loop.edges)]
    if height <= _FLAT * solid.size or outlines != set().union(*inside):
        return None
    return Mark(base.id, frozenset(outlines), tuple(sorted(faces)), height)


def _distance(solid: Solid, face: Face, base: Face) -> float:
    """How far a face is off the surface of another, by its vertices, its edges and what of it is nearest its middle."""
    edges = [solid.edges[e] for e in face.edges]
    ends = [solid.vertices[v] for edge in edges for v in (edge.start, edge.end)]
    top = face.surface.evaluate(face.surface.project(face.center[None]))[0]
    points = np.array([*ends, *(edge.midpoint for edge in edges), top])
    return float(np.linalg.norm(base.surface.evaluate(base.surface.project(points)) - points, axis=1).max())


def _flattened(part: Part, marks: dict[int, list[Mark]]) -> Part:
    """The part without marks.

    Raises
    ------
    CadError
        A solid is not sound without them.
    """
    holders = [shapes_of(solid) for solid in part.solids]
    made = {}
    for cell, own in marks.items():
        shape, traced = _without(holders[cell], own)
        damage = faults(shape)
        if damage:
            raise CadError(damage[0])
        made[cell] = shape, traced
    read = read_anew(part, holders, made)
    solids, models, lost = list(read.solids), list(part.models), dict[str, None]()
    for cell, own in marks.items():
        old = part.solids[cell]
        change = solids[cell].volume - old.volume
        if abs(change) > sum(mark.height * sum(old.faces[f].area for f in mark.faces) for mark in own):
            raise CadError("the volume changes by more than marks can have")
        solids[cell], gone = _named(old, solids[cell], own, holders[cell])
        lost |= dict.fromkeys(gone)
        owner = part.owners[cell]
        models[owner] = replace(models[owner], volume=models[owner].volume + change)
    every = [mark for own in marks.values() for mark in own]
    highest = max(mark.height for mark in every) * part.scale
    where = dict.fromkeys(part.solids[cell].faces[mark.base].label() for cell, own in marks.items() for mark in own)
    off = sum(model.volume for model in models) / sum(model.volume for model in part.models) - 1.0
    note = (
        f"marks flattened: {len(every)} of at most {highest:.3g}, on {', '.join([*where][:2])}: the mesh goes on "
        f"beneath them, and its volume is {100.0 * abs(off):.2g} % off"
    )
    lines = [f"name '{name}' is lost: its face was a wall of a mark" for name in lost]
    return replace(read, solids=tuple(solids), models=tuple(models), notes=(*part.notes, note, *lines))


def _without(holder: SolidShape, marks: list[Mark]) -> tuple[object, Traced]:
    """A solid whose faces go on beneath marks."""
    pieces = [[face] for face in holder.faces]
    builder = BRep_Builder()
    for mark in marks:
        around = index_map(compound([holder.edges[e] for e in mark.edges]), EDGE)
        ((old,),) = (pieces[mark.base],)
        face = typed(old.EmptyCopied(), FACE)
        for wire in children(old):
            if not any(around.Contains(edge) for edge in subshapes(wire, EDGE)):
                builder.Add(face, wire)
        pieces[mark.base] = [face]
        for f in mark.faces:
            pieces[f] = []
    traced = Traced(holder.shape)
    traced.faces = pieces
    return in_order([own for own in pieces if own]), traced


def _named(old: Solid, new: Solid, marks: list[Mark], holder: SolidShape) -> tuple[Solid, list[str]]:
    """The new solid with the names of marks on patches of the faces below them, and the names that are lost."""
    gone = {f for mark in marks for f in mark.faces}
    number = {face.id: j for j, face in enumerate(face for face in old.faces if face.id not in gone)}
    faces = list(new.faces)
    for base in dict.fromkeys(mark.base for mark in marks):
        below = old.faces[base]
        on = [old.faces[f] for mark in marks if mark.base == base for f in mark.faces]
        patches = tuple(former_face(face.names, [face], holder) for face in on if _is_seen(face, below))
        faces[number[base]] = replace(faces[number[base]], former=patches)
    kept = {name for face in faces for names in (face.names, *(patch.names for patch in face.former)) for name in names}
    lost = [name for f in sorted(gone) for name in old.faces[f].names if name not in kept]
    return replace(new, faces=tuple(faces)), lost


def _is_seen(face: Face, below: Face) -> bool:
    return bool(face.normal @ below.surface.normals(below.surface.project(face.center[None]))[0] >= _SEEN)


__all__ = ["Mark", "find_marks", "flatten_marks"]
