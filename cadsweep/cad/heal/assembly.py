"""From a model of several solids to a ``Part``: each healed by itself, all normalised together, then imprinted.

Place in the flow: beside :mod:`.clean`, which does the same for one solid.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.ShapeFix import ShapeFix_ShapeTolerance

from ...brep import ModelSolid, Part, Units
from ...contacts import say_leave_out
from ...errors import CadError
from ..extract.labels import EdgeLabel, FaceLabel, Labels
from ..imprinting.apart import Original
from ..imprinting.checking import integrated_volume
from ..imprinting.joining import imprint
from ..imprinting.overlaps import cut_overlaps as cut_overlaps_of
from ..names.naming import declare_names
from ..names.unique import declare_words, number_repeated
from ..read.colors import split_colors
from ..read.model import Model, Named
from ..shapes import EDGE, FACE, SOLID, compound, explore, index_map, subshapes, typed, volume_and_center
from .clean import lost_names, stage
from .solids import mend
from .tracing import Traced
from .units import transform_to_working
from .validate import check_finite

logger = logging.getLogger(__name__)

_HEALED = 0.1
"""Share of the time that healing takes, measured on walls of 100 and 500 bricks."""


def make_assembly(
    model: Model,
    *,
    touch: float | None = None,
    cut_overlaps: bool = False,
    on_progress: Callable[[float], None] | None = None,
) -> Part:
    """Heal a model of several solids, and make one part of them.

    Parameters
    ----------
    model : Model
    touch : float, optional
        Distance, model units, up to which faces of two solids are taken to touch.
    cut_overlaps : bool
        Whether the larger of two solids that overlap is cut.
    on_progress : callable, optional
        Called with the share that is done.

    Raises
    ------
    CadError
        A solid is not usable, or two overlap; the message names them.
    """
    notes = list(model.notes)
    with stage(model, "checking coordinates"):
        check_finite(model.shape)
    with stage(model, "reading names"):
        faces, lost_faces = declare_names(model.names, model.shape, FACE)
        edges, lost_edges = declare_names(model.names, model.shape, EDGE)
        solids = subshapes(model.shape, SOLID)
        given = [_first(model.names, solid) for solid in solids]
        names, renamed = number_repeated(given, what="solid")
    with stage(model, "looking for solids that come twice"):
        _check_placed_once(model, solids, names)
    colors = split_colors(model.colors, solids, model.shape)
    materials = [declare_words((_first(model.materials, solid), "material")) for solid in solids]
    naming_notes = faces.notes + edges.notes + lost_faces + lost_edges + renamed
    naming_notes += list(dict.fromkeys(note for _, declared in materials for note in declared.notes))
    for note in naming_notes:
        logger.warning("%s: %s", model.source, note)
    notes += _loose_notes(model, solids)
    all_faces, all_edges = index_map(model.shape, FACE), index_map(model.shape, EDGE)
    healed: list[Any] = []
    labels: list[Labels] = []
    healer = _Healer(names)
    for done, (solid, name, (_, face_colors)) in enumerate(zip(solids, names, colors, strict=True)):
        if on_progress is not None:
            on_progress(_HEALED * done / len(solids))
        traced = Traced(solid)
        with stage(model, f"healing '{name}'"):
            notes += [f"'{name}': {note}" for note in healer.mend(traced, name)]
        healed.append(typed(traced.shape, SOLID))
        own = [all_faces.FindIndex(face) - 1 for face in subshapes(solid, FACE)]
        face_labels = [FaceLabel(f"face {j}", faces.by_entity.get(j, ()), face_colors.get(j)) for j in own]
        own = [all_edges.FindIndex(edge) - 1 for edge in subshapes(solid, EDGE)]
        edge_labels = [EdgeLabel(f"edge {j}", edges.by_entity.get(j, ())) for j in own]
        labels.append(_followed(traced, face_labels, edge_labels))
    for what, declared, kept in (
        ("face", faces, [face for one in labels for face in one.faces]),
        ("edge", edges, [edge for one in labels for edge in one.edges]),
    ):
        for lost in lost_names(declared.by_entity, [_number(label.key) for label in kept]):
            notes.append(f"name '{lost}' is lost: its {what} is no part of a solid")
    with stage(model, "normalising units"):
        scale, offset, move = transform_to_working(compound(healed))
        if move is not None:
            tool = BRepBuilderAPI_Transform(compound(healed), move, True)
            healed = [typed(tool.ModifiedShape(solid), SOLID) for solid in healed]
            if scale > 1.0:
                ShapeFix_ShapeTolerance().LimitTolerance(compound(healed), 1e-7, 0.0)
    if cut_overlaps:
        with stage(model, "cutting overlaps"):
            notes += _cut_overlaps(healed, labels, names)
    units = Units(model.scale * scale, model.scale * offset)
    models = [
        ModelSolid(
            name=name,
            path=_first(model.paths, solid) or "",
            volume=volume_and_center(shape)[0],
            material=words[0],
            color=color,
            kernel=Original(shape=shape, labels=own),
        )
        for name, solid, shape, own, (words, _), (color, _) in zip(
            names, solids, healed, labels, materials, colors, strict=True
        )
    ]
    of_solids = {name: own for name, own in zip(names, given, strict=True) if own is not None and own != name}
    of_materials = {new: old for _, declared in materials for new, old in declared.originals.items()}
    with stage(model, "imprinting the solids on each other"):
        part = imprint(
            healed,
            labels=labels,
            models=models,
            units=units,
            touch=touch or 0.0,
            on_progress=on_progress,
            name=model.name or "part",
            notes=notes + naming_notes,
            names={**of_materials, **of_solids, **edges.originals, **faces.originals},
        )
        return replace(part, models=tuple(_measured(part, healed, moved=touch is not None)))


def _cut_overlaps(healed: list[Any], labels: list[Labels], names: Sequence[str]) -> list[str]:
    """Cut what overlaps in place, and say what was cut."""
    cut, notes = cut_overlaps_of(healed, names)
    for j, traced in cut.items():
        healed[j], labels[j] = traced.shape, _followed(traced, labels[j].faces, labels[j].edges)
    return notes


def _measured(part: Part, healed: Sequence[Any], *, moved: bool) -> Iterator[ModelSolid]:
    """The solids of the model with volumes by the integrals that cells have, which are better on splines.

    Those of the cells, where imprinting has moved no face.
    """
    for model, cell, before in zip(part.models, part.solids, healed, strict=True):
        yield replace(model, volume=integrated_volume(before) if moved else cell.volume)


def _loose_notes(model: Model, solids: Sequence[Any]) -> list[str]:
    """Say what faces are left out, and of which bodies: an open solid is written to STEP as a shell."""
    within = index_map(compound(solids), FACE)
    n_loose = index_map(model.shape, FACE).Extent() - within.Extent()
    if not n_loose:
        return []
    bodies = [path for body, path in model.paths if body.ShapeType() != SOLID and subshapes(body, FACE)]
    called = f", of {', '.join(repr(path) for path in dict.fromkeys(bodies))}" if bodies else ""
    note = f"{n_loose} faces that belong to no solid left out{called}"
    logger.warning("%s: %s", model.source, note)
    return [note]


class _Healer:
    """Mends solids one by one; a copy of one in which there was nothing to mend needs no looking at."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self._sound: dict[tuple[int, Any], Any] = {}

    def mend(self, traced: Traced, name: str) -> list[str]:
        shape = traced.shape
        key = id(shape.TShape()), shape.Orientation()
        if key in self._sound and not shape.Location().Transformation().IsNegative():
            return []
        try:
            notes = mend(traced)
        except CadError as error:
            raise CadError(f"'{name}': {error} Or leave it out: {say_leave_out([name], self._names)}.") from error
        if not notes:
            self._sound[key] = shape.TShape()  # kept, so that its id is its own
        return notes


def _followed(traced: Traced, faces: Sequence[FaceLabel], edges: Sequence[EdgeLabel]) -> Labels:
    """Labels of a healed solid, from those of its faces and edges before."""
    return Labels(
        [FaceLabel() if j is None else faces[j] for j in traced.face_origins(index_map(traced.shape, FACE))],
        [EdgeLabel() if j is None else edges[j] for j in traced.edge_origins(index_map(traced.shape, EDGE))],
    )


def _check_placed_once(model: Model, solids: Sequence[Any], names: Sequence[str]) -> None:
    """Refuse a solid that the model holds twice at one place."""
    found = index_map(model.shape, SOLID)
    counts = [0] * found.Extent()
    for solid in explore(model.shape, SOLID):
        counts[found.FindIndex(solid) - 1] += 1
    for solid, name, n in zip(solids, names, counts, strict=True):
        if n > 1:
            own = dict.fromkeys(entry.name for entry in model.names if entry.shape.IsSame(solid))
            called = " and ".join(f"'{one}'" for one in own) if len(own) > 1 else f"'{name}'"
            center = volume_and_center(solid)[1]
            where = ", ".join(f"{c + 0.0:.4g}" for c in center.round(9))
            raise CadError(f"{called}: the same solid is there {n} times at ({where}); remove all but one.")


def _first(named: Sequence[Named], solid: Any) -> str | None:
    return next((name for shape, name in named if shape.IsSame(solid)), None)


def _number(key: str) -> int | None:
    return int(key.split()[1]) if key else None
