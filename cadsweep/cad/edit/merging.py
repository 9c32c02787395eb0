"""Faces that only divide one surface, merged again; what had a name keeps it as a patch.

Place in the flow: called by the pipeline for a part that has no sweep, or whose caps are divided in ways
that do not correspond, as it is; divisions that recognition can use stay as they are.

Method: OpenCASCADE's ``ShapeUpgrade_UnifySameDomain``, kept away from every edge but those to give up:
both faces lie on one surface (:mod:`.same_surface`). What is closed thereafter is divided anew.
A merged face is called after the largest of its pieces; pieces of other names become its patches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt2d
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
from OCP.TopAbs import TopAbs_State

from ...arrays import FloatArray
from ...brep import Edge, Face, FormerFace, Part
from ...errors import CadError
from ..extract.solids import extract_solid
from ..geometry.same_surface import (
    cutting_edges,
    dividing_edges,
    group_faces,
    is_elementary,
    prolonged_kinks,
    share_surface,
)
from ..heal.divide import divide_closed
from ..heal.shared_surfaces import part_surfaces
from ..heal.tracing import Traced
from ..heal.validate import check_closed
from ..names.naming import inner_point
from ..read.colors import common_color
from ..shapes import EDGE, FACE, SOLID, SolidShape, index_map, listed, subshapes, typed
from ..trial import attempted

Item = TypeVar("Item", Face, Edge)


def find_mergeable(part: Part, *, across_kinks: bool = False) -> list[tuple[int, ...]]:
    """Edges that divide one surface, in groups whose faces hang together; none for a part of several solids.

    Parameters
    ----------
    part : Part
    across_kinks : bool
        Give up edges, too, that go on in kinks of the neighbours (a mitre across a flat side): good stations.
    """
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        return []
    solid = part.solids[0]
    edges = set(dividing_edges(solid))
    if not across_kinks:
        edges -= prolonged_kinks(solid, edges)
    groups = [set(group) for group in group_faces(solid, sorted(edges))]
    return [tuple(sorted(e for e in edges if group.issuperset(solid.edges[e].faces))) for group in groups]


def merge_faces(part: Part, groups: Sequence[Sequence[int]]) -> Part | None:
    """Merge faces across groups of edges.

    Parameters
    ----------
    part : Part
        One solid.
    groups : sequence of sequences of int
        Some of those that :func:`find_mergeable` gives.

    Returns
    -------
    Part or None
        The same solid with fewer faces; None where OpenCASCADE cannot merge them, and for a part of several cells,
        whose shared faces would no longer be shared.
    """
    if len(part.solids) != 1:
        return None
    solid = part.solids[0]
    dividing = sorted(e for group in groups for e in group)
    cuts = cutting_edges(solid, dividing)
    # OpenCASCADE closes some surfaces again, which are then divided anew, and others not.
    attempts = [set(dividing) - cuts]
    if cuts:
        attempts.append({e for e in dividing if e not in cuts or is_elementary(solid, solid.edges[e].faces[0])})
    merged = [found for found in (_unified(part, given_up) for given_up in attempts if given_up) if found is not None]
    return min(merged, key=lambda found: (len(found.solids[0].faces), len(found.solids[0].edges)), default=None)


def _unified(part: Part, given_up: set[int]) -> Part | None:
    """The part without the given edges; None where OpenCASCADE cannot do without them."""
    solid, holder = part.solids[0], part.solids[0].kernel
    assert isinstance(holder, SolidShape)
    copy = BRepBuilderAPI_Copy(holder.shape)
    for group in group_faces(solid, sorted(given_up)):
        if not is_elementary(solid, group[0]):
            share_surface([typed(copy.ModifiedShape(holder.faces[f]), FACE) for f in group])
    tool = ShapeUpgrade_UnifySameDomain(copy.Shape(), True, True, False)
    for edge in solid.edges:
        if edge.id not in given_up:
            tool.KeepShape(copy.ModifiedShape(holder.edges[edge.id]))
    if not attempted(tool.Build, "merging faces of one surface"):
        return None
    try:
        (shape,) = subshapes(tool.Shape(), SOLID)
        check_closed(shape)
        history = tool.History()
        pieces = _pieces(
            solid.faces, index_map(shape, FACE), [copy.ModifiedShape(old) for old in holder.faces], history
        )
        lines = _pieces(solid.edges, index_map(shape, EDGE), [copy.ModifiedShape(old) for old in holder.edges], history)
        traced = Traced(shape)
        part_surfaces(traced)
        divide_closed(traced)
        (shape,) = subshapes(traced.shape, SOLID)
        check_closed(shape)
        merged = extract_solid(shape, name=solid.name, material=solid.material, color=solid.color, units=solid.units)
        origins = traced.face_origins(index_map(shape, FACE))
        edge_origins = traced.edge_origins(index_map(shape, EDGE))
    except (CadError, ValueError):
        return None  # the part as it was is refused with its own reasons
    n_less = len(solid.faces) - len(merged.faces)
    if n_less <= 0 or abs(merged.volume - solid.volume) > 1e-6 * solid.volume:
        return None
    labels = [_label(own, holder) for own in pieces]
    faces = tuple(
        face if j is None else replace(face, **labels[j]) for face, j in zip(merged.faces, origins, strict=True)
    )
    note = f"faces merged with their neighbours on one surface: {n_less}; edges between them are gone"
    edges = tuple(
        replace(edge, **_edge_label([] if j is None else lines[j]))
        for edge, j in zip(merged.edges, edge_origins, strict=True)
    )
    kept = {name for edge in edges for name in edge.names}
    lost = dict.fromkeys(name for edge in solid.edges for name in edge.names if name not in kept)
    lost_notes = (f"name '{name}' is lost: its edge lay between merged faces" for name in lost)
    return replace(part, solids=(replace(merged, faces=faces, edges=edges),), notes=(*part.notes, note, *lost_notes))


def _pieces(items: Sequence[Item], found: Any, copies: Sequence[Any], history: Any) -> list[list[Item]]:
    """For every face (or edge) of a map of the unified shape, those it is made of, whose copies are given."""
    pieces: list[list[Item]] = [[] for _ in range(found.Extent())]
    for item, old in zip(items, copies, strict=True):
        for new in listed(history.Modified(old)) or [old]:
            if found.Contains(new):
                pieces[found.FindIndex(new) - 1].append(item)
    return pieces


def _edge_label(pieces: Sequence[Edge]) -> dict[str, Any]:
    """Key of the first and names of all edges that one is made of: fields of :class:`~cadsweep.brep.Edge`."""
    names = tuple(dict.fromkeys(name for piece in pieces for name in piece.names))
    return {"key": pieces[0].key if pieces else "", "name": names[0] if names else None, "groups": names[1:]}


def _label(pieces: Sequence[Face], holder: SolidShape) -> dict[str, Any]:
    """Names, colour and key of the largest piece, and a patch for every other set of names.

    These are fields of :class:`~cadsweep.brep.Face`; where a face is divided anew, each part has them all.
    """
    by_names: dict[tuple[str, ...], list[Face]] = {}
    for piece in pieces:
        by_names.setdefault(piece.names, []).append(piece)
    if not by_names:
        return {"key": ""}
    (names, main), *others = sorted(by_names.items(), key=lambda item: -sum(piece.area for piece in item[1]))
    return {
        "name": names[0] if names else None,
        "groups": names[1:],
        "color": common_color([piece.color for piece in main]),
        "key": max(main, key=lambda piece: piece.area).key,
        "former": tuple(former_face(own_names, own, holder) for own_names, own in others),
    }


def former_face(names: tuple[str, ...], pieces: Sequence[Face], holder: SolidShape) -> FormerFace:
    """What was a face, or several, of a solid with these shapes, as a patch of another face."""
    largest = max(pieces, key=lambda piece: piece.area)
    inside = inner_point(holder.faces[largest.id])
    place = largest.center if inside is None else np.array([inside[0].X(), inside[0].Y(), inside[0].Z()])

    def is_inside(points: FloatArray) -> npt.NDArray[np.bool_]:
        found = np.zeros(len(points), dtype=bool)
        for piece in pieces:
            found |= _lie_inside(holder.faces[piece.id], piece.surface.project(points))
        return found

    return FormerFace(
        names=names,
        key=largest.key,
        color=common_color([piece.color for piece in pieces]),
        area=sum(p.area for p in pieces),
        place=place,
        piece_at=is_inside,
        pieces=(True,),
        number=largest.known if len(pieces) == 1 else None,
    )


def _lie_inside(face: Any, uv: FloatArray) -> npt.NDArray[np.bool_]:
    classifier = BRepTopAdaptor_FClass2d(face, 1e-9)
    outside = TopAbs_State.TopAbs_OUT
    return np.array([classifier.Perform(gp_Pnt2d(float(u), float(v))) != outside for u, v in uv], dtype=bool)
