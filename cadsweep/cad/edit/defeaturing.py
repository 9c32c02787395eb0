"""Features removed from a part, where the user asks for it: the faces around them grow until they meet.

Place in the flow: after loading, before anything is looked for; :mod:`.features` says what is meant.

Method: OpenCASCADE's ``BRepAlgoAPI_Defeaturing``, one feature after the other, so that each has its own change of
volume; its word is not taken for it: the solid must be one, closed and valid. Names of the other faces are kept.

Not handled: parts of several solids, whose contacts would change with them.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Defeaturing

from ...brep import Part, Solid
from ...errors import CadError, InputError
from ..extract.labels import EdgeLabel, FaceLabel, Labels, labels_of
from ..extract.solids import extract_solid
from ..heal.divide import divide_closed
from ..heal.shared_surfaces import part_surfaces
from ..heal.tracing import Traced
from ..heal.validate import check_closed, faults
from ..shapes import EDGE, FACE, SOLID, SolidShape, compound, index_map, listed, subshapes, typed, volume_and_center
from .features import Feature, find_features, find_fillets, find_holes

logger = logging.getLogger(__name__)

SMALL = 0.05
"""Radius of a rounding, or diameter of a hole, as a share of the part's size, up to which a refusal names it."""


def suppress(part: Part, words: Sequence[str]) -> Part:
    """Remove features from a part of one solid.

    Parameters
    ----------
    part : Part
    words : sequence of str
        ``"fillets r<0.5"``, ``"holes d<2"`` (model units), ``"fillets"``, ``"holes"``, or what chooses faces.

    Returns
    -------
    Part
        Its notes list every feature that was removed, with its place and the change of volume, and every one that
        OpenCASCADE cannot remove.

    Raises
    ------
    InputError
        A word is not understood, means nothing of this part, or none of what it means can be removed.
    """
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        raise InputError("suppress is about one solid: choose it with part=")
    (solid,) = part.solids
    holder = solid.kernel
    assert isinstance(holder, SolidShape)
    traced = Traced(holder.shape)
    notes: list[str] = []
    gone: set[int] = set()
    for word in words:
        features = [f for f in find_features(part, word) if not gone.issuperset(f.faces)]
        if not features:
            raise InputError(f"suppress '{word}': the part has no such feature, or it is removed already")
        removed = 0
        for feature in features:
            place = part.solids[0].units.place(np.mean([solid.faces[f].center for f in feature.faces], axis=0))
            before = volume_and_center(traced.shape)[0]
            why = _remove(traced, feature)
            if why:
                notes.append(f"not suppressed: {feature.what} at ({place}): {why}")
                continue
            change = (volume_and_center(traced.shape)[0] - before) * part.scale**3
            notes.append(f"suppressed: {feature.what} at ({place}), volume {change:+.6g}")
            gone |= set(feature.faces)
            removed += 1
        if not removed:
            raise InputError(f"suppress '{word}': none can be removed; {notes[-1]}")
    found, lost = _read(solid, traced)
    notes += [f"name '{name}' is lost: what had it is suppressed" for name in lost]
    for note in notes:
        logger.info("%s", note)
    return replace(part, solids=(found,), models=(), owners=(), notes=(*part.notes, *notes))


def small_features(part: Part) -> str:
    """What a refusal may propose to suppress; empty where the part has nothing small."""
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        return ""
    (solid,) = part.solids
    limit = SMALL * solid.size
    words = []
    for what, letter, found in (
        ("fillets", "r", list(find_fillets(solid, limit))),
        ("holes", "d", list(find_holes(solid, limit))),
    ):
        if found:
            words.append(f"'{what} {letter}<{limit * part.scale:.2g}' ({len(found)})")
    return f"leave small features out: suppress=[{', '.join(words)}]" if words else ""


def _remove(traced: Traced, feature: Feature) -> str:
    """Remove a feature; what is wrong where that cannot be, and nothing is changed."""
    faces = [face for f in feature.faces for face in traced.faces[f]]
    tool = BRepAlgoAPI_Defeaturing()
    tool.SetShape(traced.shape)
    for face in faces:
        tool.AddFaceToRemove(face)
    tool.SetRunParallel(False)
    tool.SetToFillHistory(True)
    tool.Build()
    if not tool.IsDone():
        return "the faces around it do not close over it"
    solids = subshapes(tool.Shape(), SOLID)
    if len(solids) != 1:
        return f"it leaves {len(solids)} solids"
    try:
        check_closed(solids[0])
    except CadError as error:
        return str(error)
    if faults(solids[0]):
        return "what is left is no valid solid"
    present = index_map(solids[0], FACE)
    if any(present.Contains(face) for face in faces):
        return "the faces around it do not close over it"

    def image(sub: Any) -> Any:
        if tool.IsDeleted(sub):
            return None
        became = listed(tool.Modified(sub))
        return compound(became) if became else sub

    traced.replace(solids[0], image)
    return ""


def _read(solid: Solid, traced: Traced) -> tuple[Solid, list[str]]:
    """The solid as it is now, with the labels of what it was, and the names that nothing has any more."""
    part_surfaces(traced)
    divide_closed(traced)
    shape = typed(subshapes(traced.shape, SOLID)[0], SOLID)
    check_closed(shape)
    labels = labels_of(solid)
    faces = [
        FaceLabel() if j is None else labels.faces[j] for j in traced.face_origins(index_map(shape, FACE))
    ]  # fmt: skip
    edges = [EdgeLabel() if j is None else labels.edges[j] for j in traced.edge_origins(index_map(shape, EDGE))]
    lost = dict.fromkeys(name for name in _names(labels) if name not in _names(Labels(faces, edges)))
    found = extract_solid(
        shape,
        labels=Labels(faces, edges),
        name=solid.name,
        material=solid.material,
        color=solid.color,
        units=solid.units,
    )
    return found, list(lost)


def _names(labels: Labels) -> list[str]:
    of_faces = [name for face in labels.faces for name in face.names]
    return of_faces + [name for edge in labels.edges for name in edge.names]


__all__ = ["small_features", "suppress"]
