"""The design of a solid: what it is without its blends, its other faces grown until they meet at sharp edges.

Place in the flow: what replaces an edge or a corner is told from outside; the model itself stays as it is.

Method: OpenCASCADE's defeaturing (:mod:`.defeaturing`), of all blends at once, else of those that hang together, a
group at a time. Its word is not taken for it: the result is one valid solid, every blend is gone, and the other faces
answer one to one; a group that does not come to that stays in the design.

Not handled: blends that OpenCASCADE cannot take away, as most on splines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...brep import Part, Solid
from ..heal.tracing import Traced, present
from ..shapes import FACE, SOLID, index_map, shapes_of, subshapes
from .defeaturing import read_without, remove
from .features import Feature, hanging_together


@dataclass(frozen=True, kw_only=True, eq=False)
class Design:
    """A part without some of its blends.

    Attributes
    ----------
    part : Part
        Of one solid.
    model_faces : tuple of int
        For every face of the design the face of the model that it is, or is a piece of.
    gone : frozenset of int
        Faces of the model that the design has not.
    left : tuple of str
        What could not be taken away, and why.
    """

    part: Part
    model_faces: tuple[int, ...]
    gone: frozenset[int]
    left: tuple[str, ...] = ()


def design_of(part: Part, blends: Sequence[Sequence[int]]) -> Design | None:
    """Take the blends of a part of one solid away.

    Parameters
    ----------
    part : Part
    blends : sequence of sequence of int
        The faces of each blend.

    Returns
    -------
    Design or None
        None where no blend can be taken away.
    """
    (solid,) = part.solids
    traced, gone, left = Traced(shapes_of(solid).shape), set[int](), list[str]()
    faces = {f for blend in blends for f in blend}
    groups = hanging_together(solid, faces)
    for group in [sorted(faces), *groups] if len(groups) > 1 else groups:
        if not group or gone.issuperset(group):
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
    origins = [f for f in traced.face_origins(index_map(shape, FACE)) if f is not None]
    if len(origins) < len(found.faces):
        return None
    own = replace(part, solids=(found,), models=(), owners=())
    return Design(part=own, model_faces=tuple(origins), gone=frozenset(gone), left=tuple(left))


def _taken(solid: Solid, traced: Traced, group: Sequence[int], gone: set[int]) -> str:
    """Take a group away; what is wrong where that cannot be, and nothing is changed."""
    before = traced.shape, traced.faces, traced.edges
    why = remove(traced, Feature(what="blends", faces=tuple(group)))
    if why:
        return why
    away = gone | set(group)
    there = present(traced, FACE)
    # Pieces of one closed face may become one again.
    found: dict[int, set[str]] = {}
    whole = True
    for face, images in zip(solid.faces, traced.faces, strict=True):
        if face.id not in away:
            whole &= len(images) == 1
            for image in images:
                found.setdefault(there.FindIndex(image), set()).add(face.key or f"face {face.id}")
    if whole and len(found) == there.Extent() and all(len(keys) == 1 for keys in found.values()):
        return ""
    traced.shape, traced.faces, traced.edges = before
    return "the other faces do not stay one to one"


__all__ = ["Design", "design_of"]
