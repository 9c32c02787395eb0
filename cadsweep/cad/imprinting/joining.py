"""Separate solids joined to one part with keys that tell what they share.

Place in the flow: for a model of several solids between healing and recognition; for a solid that was cut, after it.

Method: the general fuse of the solids that may touch (:mod:`.fusing`), its result checked (:mod:`.checking`); then
closed faces are divided on the whole compound, so that two solids get one and the same seam; then every solid is read
with one set of keys, curves and surfaces. Where the fuse fails its checks, it is tried again with another tolerance
and in another order, which is what helps.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...brep import ModelSolid, Part, Units
from ...errors import CadError
from ..extract.labels import EdgeLabel, FaceLabel, Labels
from ..extract.shared import PartGeometry
from ..extract.solids import extract_solid
from ..heal.divide import divide_closed
from ..heal.shared_surfaces import part_surfaces
from ..heal.tracing import Traced
from ..heal.validate import check_closed
from ..shapes import (
    EDGE,
    FACE,
    SOLID,
    bounds,
    children,
    compound,
    index_map,
    subshapes,
    typed,
    volume_and_center,
)
from .checking import check_counts, check_distinct, check_imprinted
from .doubts import doubt_notes
from .fusing import Fused
from .gaps import find_gaps
from .internals import drop_internals
from .seams import align_seams
from .steps import find_steps

logger = logging.getLogger(__name__)

TOLERANCE = 1e-7
"""Distance, as a share of the part's size, up to which solids touch: the noise of coordinates in CAD files."""
_LEAST_TOLERANCE = 1e-7
"""OpenCASCADE's own; it finds nothing finer, in any unit."""
_SLANTED = 10.0
"""Distance along an edge over the distance of the faces it ends on, at most: faces that meet at 6 degrees."""
_FUSED = 0.6
"""Share of the time until cells are read, measured on walls of 100 and 500 bricks."""


def imprint(
    shapes: Sequence[Any],
    *,
    labels: Sequence[Labels] | None = None,
    models: Sequence[ModelSolid] | None = None,
    owners: Sequence[int] | None = None,
    units: Units | None = None,
    touch: float = 0.0,
    closed: float = 0.0,
    name: str = "part",
    notes: Sequence[str] = (),
    names: Mapping[str, str] | None = None,
    on_progress: Callable[[float], None] | None = None,
) -> Part:
    """Make one part of separate solids: where they touch they share faces, edges and vertices.

    Parameters
    ----------
    shapes : sequence of TopoDS_Solid
        Healed, in working units. Pieces of a solid that was cut may share faces already.
    labels : sequence of Labels, optional
        Keys, names and colours of the faces and edges of each, by their order in it; by default they are numbered
        through all solids.
    models : sequence of ModelSolid, optional
        The solids of the model; by default, each of `shapes`.
    owners : sequence of int, optional
        For each shape the index into `models` of the solid that it is a piece of; by default, each its own.
    units : Units, optional
        How the working lengths become the model's.
    touch : float
        Distance, model units, up to which faces are taken to touch; no less than the part's own tolerance.
    closed : float
        Width of gaps, working units, that the shapes have already where their faces were closed.
    name, notes, names
        As in :class:`~cadsweep.brep.Part`.
    on_progress : callable, optional
        Called with the share that is done.

    Returns
    -------
    Part
        One cell a shape, in that order. A face, an edge or a vertex that cells share has one key, one position, one
        curve, one surface; what came of several has the names of them all, in each cell those of its own first.

    Raises
    ------
    CadError
        Solids overlap, or one comes twice: named, with the place; or OpenCASCADE fails at them.
    """
    units = Units() if units is None else units
    own = list(range(len(shapes))) if owners is None else list(owners)
    if models is None:
        volumes = np.bincount(own, weights=[volume_and_center(shape)[0] for shape in shapes])
        models = [ModelSolid(name=f"solid_{i + 1}", volume=float(volume)) for i, volume in enumerate(volumes)]
    called = [f"'{models[i].name}'" for i in own]
    if labels is None:
        labels = _numbered(shapes)
    size = _size(shapes)
    tolerance = reach_of(size, touch / units.scale)
    shapes, labels = align_seams(shapes, labels, size)
    traced = _imprinted(shapes, called, units, tolerance)
    part_surfaces(traced)
    notes = [*notes, *divide_closed(traced)]
    cells = [typed(cell, SOLID) for cell in children(traced.shape)]
    origins = _Origins(shapes, labels, traced)
    shared = PartGeometry(traced.shape, closed=max(widest_closed(tolerance), closed))
    solids = []
    for i, cell in enumerate(cells):
        if on_progress is not None:
            on_progress(_FUSED + (1.0 - _FUSED) * i / len(cells))
        model = models[own[i]]
        check_closed(cell)
        solids.append(
            extract_solid(
                cell,
                labels=origins.labels(i, cell),
                name=model.name,
                material=model.material,
                color=model.color,
                units=units,
                shared=shared,
            )
        )
    part = Part(
        solids=tuple(solids),
        name=name,
        scale=units.scale,
        offset=units.offset,
        notes=tuple(notes),
        names=dict(names or {}),
        owners=tuple(own),
        models=tuple(models),
        touch=touch / units.scale,
    )
    doubts = doubt_notes(part, find_gaps(part, tolerance=tolerance), find_steps(part, shapes, size))
    for note in doubts:
        logger.warning("%s", note)
    return replace(part, notes=(*part.notes, *doubts))


def reach_of(size: float, touch: float) -> float:
    """Distance, working units, up to which the faces of a part of a size are taken to touch."""
    return max(TOLERANCE * size, _LEAST_TOLERANCE, touch)


def widest_closed(tolerance: float) -> float:
    """Width of gaps that an imprint with a tolerance closes.

    What lies within it of both of two solids is twice as far apart at most, on a slanted face farther.
    """
    return _SLANTED * tolerance


def _size(shapes: Sequence[Any]) -> float:
    """Diagonal of a box about all solids."""
    box = np.array([bounds(shape) for shape in shapes])
    return float(np.linalg.norm(box[:, 1].max(axis=0) - box[:, 0].min(axis=0)))


def _imprinted(shapes: Sequence[Any], called: Sequence[str], units: Units, least: float) -> Traced:
    """The compound of the solids after the general fuse, in their order."""
    first: CadError | None = None
    backwards = slice(None, None, -1)
    for fuzzy, order in ((least, slice(None)), (10.0 * least, slice(None)), (least, backwards)):
        try:
            fused = Fused(shapes[order], fuzzy)
            fused.pieces = fused.pieces[order]
            whole = set(np.arange(len(shapes))[order][sorted(fused.whole)].tolist())
            check_distinct(fused, called, units)
            traced = Traced(compound(shapes))
            check_counts(fused, called)
            traced.replace(compound([piece for (piece,) in fused.pieces]), fused.image)
            drop_internals(traced)
            check_imprinted(shapes, traced, called, units, moved=fuzzy, whole=whole)
            return traced
        except CadError as error:
            logger.info("imprinting with a tolerance of %.3g: %s", fuzzy, error)
            first = first or error
    assert first is not None
    raise first


def _numbered(shapes: Sequence[Any]) -> list[Labels]:
    both = compound(shapes)
    faces, edges = index_map(both, FACE), index_map(both, EDGE)
    return [
        Labels(
            [FaceLabel(f"face {faces.FindIndex(face) - 1}") for face in subshapes(shape, FACE)],
            [EdgeLabel(f"edge {edges.FindIndex(edge) - 1}") for edge in subshapes(shape, EDGE)],
        )
        for shape in shapes
    ]


class _Origins:
    """Which faces and edges of which solids the faces and edges of the imprinted compound come from."""

    def __init__(self, shapes: Sequence[Any], labels: Sequence[Labels], traced: Traced) -> None:
        both = compound(shapes)
        self._faces, self._edges = index_map(traced.shape, FACE), index_map(traced.shape, EDGE)
        of_faces = _by_old(index_map(both, FACE), [subshapes(s, FACE) for s in shapes], [one.faces for one in labels])
        of_edges = _by_old(index_map(both, EDGE), [subshapes(s, EDGE) for s in shapes], [one.edges for one in labels])
        self._of_face = _by_new(self._faces, traced.faces, of_faces)
        self._of_edge = _by_new(self._edges, traced.edges, of_edges)

    def labels(self, number: int, cell: Any) -> Labels:
        """Labels of the faces and edges of a cell, those of its own solid first."""
        faces = [_own_first(number, self._of_face[self._faces.FindIndex(f) - 1]) for f in subshapes(cell, FACE)]
        edges = [_own_first(number, self._of_edge[self._edges.FindIndex(e) - 1]) for e in subshapes(cell, EDGE)]
        return Labels([_face_label(found) for found in faces], [_edge_label(found) for found in edges])


def _by_old(old: Any, shapes: Sequence[Sequence[Any]], labels: Sequence[Sequence[Any]]) -> list[list[tuple[int, Any]]]:
    """For every face (or edge) of a map of the input, the numbers of its solids and its labels there."""
    out: list[list[tuple[int, Any]]] = [[] for _ in range(old.Extent())]
    for i, (own, own_labels) in enumerate(zip(shapes, labels, strict=True)):
        for sub, label in zip(own, own_labels, strict=True):
            out[old.FindIndex(sub) - 1].append((i, label))
    return out


def _by_new(
    new: Any, became: Sequence[Sequence[Any]], of_old: Sequence[Sequence[tuple[int, Any]]]
) -> list[list[tuple[int, Any]]]:
    """The same for every face (or edge) of a map of the present ones, each of which may come from several."""
    out: list[list[tuple[int, Any]]] = [[] for _ in range(new.Extent())]
    for sources, pieces in zip(of_old, became, strict=True):
        for piece in pieces:
            number = new.FindIndex(piece)
            if number:
                out[number - 1].extend(sources)
    return out


def _own_first(number: int, sources: Sequence[tuple[int, Any]]) -> list[Any]:
    return [label for i, label in sorted(sources, key=lambda source: source[0] != number)]


def _face_label(found: Sequence[FaceLabel]) -> FaceLabel:
    if not found:
        return FaceLabel()
    names = tuple(dict.fromkeys(name for label in found for name in label.names))
    tips = tuple(dict.fromkeys(tip for label in found for tip in label.tips))
    return FaceLabel(found[0].key, names, found[0].color, found[0].number, tips)


def _edge_label(found: Sequence[EdgeLabel]) -> EdgeLabel:
    if not found:
        return EdgeLabel()
    return EdgeLabel(found[0].key, tuple(dict.fromkeys(name for label in found for name in label.names)))
