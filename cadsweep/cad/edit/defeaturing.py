"""Features removed from the solids of a part, where the user asks for it: the faces around them grow until they meet.

Place in the flow: after loading, before anything is looked for; :mod:`.features` says what is meant.

Solids of an assembly are taken as they were before the others were imprinted on them, and imprinted again: a feature at
a contact goes with its outline on the neighbour, or leaves a gap there that is said as any other.

Method: OpenCASCADE's ``BRepAlgoAPI_Defeaturing``, one feature after the other, so that each has its own change of
volume; its word is not taken for it: the solid must be one, closed and valid. Names of the other faces are kept.

Not handled: parts that are cut into cells.
"""

from __future__ import annotations

import logging
import math
import re
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Defeaturing

from ...brep import ModelSolid, Part, Solid, Units
from ...errors import CadError, InputError
from ..extract.labels import EdgeLabel, FaceLabel, Labels, labels_of
from ..extract.solids import extract_solid
from ..heal.divide import divide_closed
from ..heal.shared_surfaces import part_surfaces
from ..heal.tracing import Traced
from ..heal.validate import check_closed, faults
from ..imprinting.apart import Original, part_apart
from ..imprinting.joining import imprint
from ..shapes import (
    EDGE,
    FACE,
    SOLID,
    SolidShape,
    area_and_center,
    compound,
    index_map,
    listed,
    mapped,
    shapes_of,
    subshapes,
    typed,
    volume_and_center,
)
from ..trial import SECONDS, attempted
from .features import Feature, find_features, find_fillets, find_holes

logger = logging.getLogger(__name__)

_NUMBER = re.compile(r"(faces?:?)?\s*\d+")
_NOTHING = "suppress '{}': the part has no such feature, or it is removed already"
_SAME = 1e-7
"""Faces whose area and middle differ by less, as a share of the area and its root, are one."""
SMALL = 0.05
"""Radius of a rounding, or diameter of a hole, as a share of the part's size, up to which a refusal tries it."""


def suppress(part: Part, words: Sequence[str], *, seconds: float = math.inf) -> Part:
    """Remove features from a part.

    Parameters
    ----------
    part : Part
    words : sequence of str
        ``"fillets r<0.5"``, ``"holes d<2"`` (model units), ``"fillets"``, ``"holes"``, or what chooses faces. Of
        several solids all are meant that have such features; ``"pin: holes d<2"`` means the solid of that name, and the
        number of a face must be said so.
    seconds : float
        Of the clock, after which no further feature is begun; each has that time at most.

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
    asked = [_meant(part, word) for word in words]
    plain = [solid.kernel for solid in part.solids if isinstance(solid.kernel, SolidShape)]
    if len(plain) < len(part.solids) or len(part.solids) > max(1, len(part.models)):
        raise InputError("suppress removes features of a part as it is loaded: this one is cut into cells")
    if len(part.solids) > 1:
        return _of_several(part, asked)
    work = _Solid(part, seconds)
    for _, word in asked:
        features = work.find(word)
        if not features:
            raise InputError(_NOTHING.format(word))
        if not work.remove(features):
            raise InputError(f"suppress '{word}': none can be removed; {work.notes[-1]}")
    found = work.read()
    return replace(part, solids=(found,), models=(), owners=(), notes=(*part.notes, *work.told()))


def _meant(part: Part, word: str) -> tuple[str | None, str]:
    """The solid that a word names before a colon, and the rest of it."""
    name, colon, rest = word.partition(":")
    names = {model.name for model in part.models} | {part.names.get(model.name) for model in part.models}
    return (name.strip(), rest.strip()) if colon and name.strip() in names else (None, word)


def _of_several(part: Part, asked: Sequence[tuple[str | None, str]]) -> Part:
    """Remove features of the solids of an assembly, each as it was before the others were imprinted on it."""
    alone = [_alone(part, cell) for cell in range(len(part.solids))]
    works = [_Solid(one) for one in alone]
    for name, word in asked:
        if name is None and _NUMBER.fullmatch(word.strip()):
            raise InputError(f"suppress '{word}': every solid has faces of its own; write 'NAME: {word}'")
        found: list[tuple[_Solid, list[Feature]]] = []
        missing = InputError(_NOTHING.format(word))
        for work in works:
            model = work.part.models[0]
            if name is None or name in (model.name, part.names.get(model.name)):
                try:
                    found.append((work, work.find(word)))
                except InputError as error:
                    missing = error
        if not found:
            raise missing
        if not any(features for _, features in found):
            raise InputError(_NOTHING.format(word))
        if not sum(work.remove(features) for work, features in found):
            raise InputError(f"suppress '{word}': none can be removed; {found[-1][0].notes[-1]}")
    notes, shapes, labels, models = list(part.notes), list[Any](), list[Labels](), list[ModelSolid]()
    for work in works:
        (model,) = work.part.models
        if work.gone:
            solid = work.read()
            notes += [f"'{model.name}': {note}" for note in work.told()]
            own = Original(shape=shapes_of(solid).shape, labels=labels_of(solid))
            model = replace(model, volume=solid.volume, kernel=own)
        elif isinstance(model.kernel, Original):
            own = model.kernel
        else:
            own = Original(shape=shapes_of(work.solid).shape, labels=labels_of(work.solid))
        shapes.append(own.shape)
        labels.append(own.labels)
        models.append(model)
    return imprint(
        shapes, labels=labels, models=models, units=Units(part.scale, part.offset), touch=part.touch * part.scale,
        name=part.name, notes=notes, names=part.names,
    )  # fmt: skip


def _alone(part: Part, cell: int) -> Part:
    """One solid of an assembly by itself."""
    one = replace(part, solids=(part.solids[cell],), owners=(0,), models=(part.models[part.owners[cell]],))
    return part_apart(one) or one


class _Solid:
    """A part of one solid from which features are removed."""

    def __init__(self, part: Part, seconds: float = math.inf) -> None:
        self.part = part
        self.seconds, self.until = min(seconds, SECONDS), time.monotonic() + seconds
        (self.solid,) = part.solids
        self.traced = Traced(shapes_of(self.solid).shape)
        self.notes: list[str] = []
        self.gone: set[int] = set()

    def find(self, word: str) -> list[Feature]:
        """What a word means that is there still."""
        return [f for f in find_features(self.part, word) if not self.gone.issuperset(f.faces)]

    def remove(self, features: Sequence[Feature]) -> int:
        """Remove features one by one; how many could be."""
        removed = 0
        for feature in features:
            place = self.solid.units.place(np.mean([self.solid.faces[f].center for f in feature.faces], axis=0))
            before = volume_and_center(self.traced.shape)[0]
            is_late = time.monotonic() > self.until
            why = "no time is left" if is_late else remove(self.traced, feature, seconds=self.seconds)
            if why:
                self.notes.append(f"not suppressed: {feature.what} at ({place}): {why}")
                continue
            change = (volume_and_center(self.traced.shape)[0] - before) * self.part.scale**3
            self.notes.append(f"suppressed: {feature.what} at ({place}), volume {change:+.6g}")
            self.gone |= set(feature.faces)
            removed += 1
        return removed

    def read(self) -> Solid:
        """The solid without them."""
        found, lost = read_without(self.solid, self.traced)
        self.notes += [f"name '{name}' is lost: what had it is suppressed" for name in lost]
        return found

    def told(self) -> list[str]:
        """The notes, which go into the log, too."""
        for note in self.notes:
            logger.info("%s", note)
        return self.notes


def small_features(part: Part) -> list[str]:
    """What a refusal may propose to suppress, as :func:`suppress` takes it; empty where the part has nothing small."""
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        return []
    (solid,) = part.solids
    limit = SMALL * solid.size
    below = f"<{limit * part.scale:.2g}"
    found = {f"fillets r{below}": find_fillets(solid, limit), f"holes d{below}": find_holes(solid, limit)}
    return [word for word, features in found.items() if any(True for _ in features)]


def remove(traced: Traced, feature: Feature, *, seconds: float = SECONDS) -> str:  # noqa: PLR0911
    """Remove a feature, within some seconds; what is wrong where that cannot be, and nothing is changed."""
    faces = [face for f in feature.faces for face in traced.faces[f]]
    tool = BRepAlgoAPI_Defeaturing()
    tool.SetShape(traced.shape)
    for face in faces:
        tool.AddFaceToRemove(face)
    tool.SetRunParallel(False)
    tool.SetToFillHistory(True)
    if not attempted(tool.Build, "leaving a feature out", seconds=seconds):
        return "OpenCASCADE fails on the faces around it"
    if not tool.IsDone():
        return "the faces around it do not close over it"
    solids = subshapes(tool.Shape(), SOLID)
    if len(solids) != 1:
        return f"it leaves {len(solids)} solids"
    try:
        check_closed(solids[0])
    except CadError as error:
        return error.message
    if faults(solids[0]):
        return "what is left is no valid solid"
    present = index_map(solids[0], FACE)
    if any(present.Contains(face) for face in faces):
        return "the faces around it do not close over it"

    def image(sub: Any) -> Any:
        if tool.IsDeleted(sub):
            return _as_it_was(sub, present)
        became = listed(tool.Modified(sub))
        return compound(became) if became else sub

    traced.replace(solids[0], image)
    return ""


def _as_it_was(sub: Any, present: Any) -> Any:
    """The face that a deleted one still is: where only its edges were joined, OpenCASCADE's history does not know."""
    if sub.ShapeType() != FACE:
        return None
    area, middle = area_and_center(sub)
    for face in mapped(present, FACE):
        other, there = area_and_center(face)
        if abs(other - area) <= _SAME * area and np.linalg.norm(there - middle) <= _SAME * np.sqrt(area):
            return face
    return None


def read_without(solid: Solid, traced: Traced) -> tuple[Solid, list[str]]:
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


__all__ = ["read_without", "remove", "small_features", "suppress"]
