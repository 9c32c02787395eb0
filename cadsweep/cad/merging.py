"""Faces that only divide one surface, merged again; what had a name keeps it as a patch.

Place in the flow: called by the pipeline for a part that has no sweep, or whose caps are divided in ways
that do not correspond, as it is; divisions that recognition can use stay as they are.

Method: OpenCASCADE's ``ShapeUpgrade_UnifySameDomain``, kept away from every edge but those to give up:
both faces lie on one surface (:mod:`.same_surface`), and the edge was not made by dividing a closed face.
A merged face is called after the largest of its pieces; pieces of other names become its patches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt2d
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain
from OCP.TopAbs import TopAbs_State

from ..errors import CadError
from ..topology import Face, FloatArray, Part, Patch
from .colors import common_color
from .extract import extract_solid
from .naming import inner_point
from .same_surface import dividing_edges, group_faces, share_surface
from .shapes import FACE, SOLID, SolidShape, index_map, mapped, subshapes, typed
from .validate import check_closed


def find_mergeable(part: Part) -> list[tuple[int, ...]]:
    """Groups of faces that divide one surface, as tuples of face ids; none for a part of several solids."""
    if len(part.solids) != 1 or not isinstance(part.solids[0].write_brep, SolidShape):
        return []
    solid = part.solids[0]
    return group_faces(solid, dividing_edges(solid))


def merge_faces(part: Part, groups: Sequence[Sequence[int]]) -> Part | None:
    """Merge groups of faces.

    Parameters
    ----------
    part : Part
        One solid.
    groups : sequence of sequences of int
        Some of those that :func:`find_mergeable` gives.

    Returns
    -------
    Part or None
        The same solid with fewer faces; None where OpenCASCADE cannot merge them.
    """
    solid, holder = part.solids[0], part.solids[0].write_brep
    assert isinstance(holder, SolidShape)
    group_of = {f: k for k, group in enumerate(groups) for f in group}
    given_up = {
        e for e in dividing_edges(solid)
        if group_of.get(solid.edges[e].faces[0], -1) == group_of.get(solid.edges[e].faces[1], -2)
    }  # fmt: skip
    if not given_up:
        return None
    copy = BRepBuilderAPI_Copy(holder.shape)
    for group in groups:
        if not hasattr(getattr(solid.faces[group[0]].surface, "geometry", None), "project"):
            share_surface([typed(copy.ModifiedShape(holder.faces[f]), FACE) for f in group])
    tool = ShapeUpgrade_UnifySameDomain(copy.Shape(), True, True, False)
    for edge in solid.edges:
        if edge.id not in given_up:
            tool.KeepShape(copy.ModifiedShape(holder.edges[edge.id]))
    try:
        tool.Build()
        (shape,) = subshapes(tool.Shape(), SOLID)
        check_closed(shape)
        history = tool.History()
        found = index_map(shape, FACE)
        pieces: list[list[Face]] = [[] for _ in mapped(found, FACE)]
        for face in solid.faces:
            old = copy.ModifiedShape(holder.faces[face.id])
            for new in list(history.Modified(old)) or [old]:
                if found.Contains(new):
                    pieces[found.FindIndex(new) - 1].append(face)
        merged = extract_solid(shape, name=solid.name, material=solid.material, color=solid.color)
    except (CadError, ValueError):
        return None  # the part as it was is refused with its own reasons
    n_less = len(solid.faces) - len(merged.faces)
    if n_less <= 0 or abs(merged.volume - solid.volume) > 1e-6 * solid.volume:
        return None
    faces = tuple(_labelled(face, own, holder) for face, own in zip(merged.faces, pieces, strict=True))
    note = f"faces merged with their neighbours on one surface: {n_less}; edges between them are gone"
    return replace(part, solids=(replace(merged, faces=faces),), notes=(*part.notes, note))


def _labelled(face: Face, pieces: Sequence[Face], holder: SolidShape) -> Face:
    """A merged face with the name and key of its largest piece, and a patch for every other name."""
    if not pieces:
        return replace(face, key="")
    by_names: dict[tuple[str, ...], list[Face]] = {}
    for piece in pieces:
        by_names.setdefault(piece.names, []).append(piece)
    (names, main), *others = sorted(by_names.items(), key=lambda item: -sum(piece.area for piece in item[1]))
    patches = tuple(_patch(own_names, own, holder) for own_names, own in others)
    largest = max(main, key=lambda piece: piece.area)
    return replace(
        face,
        name=names[0] if names else None,
        groups=names[1:],
        color=common_color([piece.color for piece in main]),
        key=largest.key,
        patches=patches,
    )


def _patch(names: tuple[str, ...], pieces: Sequence[Face], holder: SolidShape) -> Patch:
    largest = max(pieces, key=lambda piece: piece.area)
    inside = inner_point(holder.faces[largest.id])
    place = largest.center if inside is None else np.array([inside[0].X(), inside[0].Y(), inside[0].Z()])

    def contains(points: FloatArray) -> npt.NDArray[np.bool_]:
        found = np.zeros(len(points), dtype=bool)
        for piece in pieces:
            found |= _lie_inside(holder.faces[piece.id], piece.surface.project(points))
        return found

    return Patch(
        names=names,
        key=largest.key,
        color=common_color([piece.color for piece in pieces]),
        area=sum(p.area for p in pieces),
        place=place,
        contains=contains,
    )


def _lie_inside(face: Any, uv: FloatArray) -> npt.NDArray[np.bool_]:
    classifier = BRepTopAdaptor_FClass2d(face, 1e-9)
    outside = TopAbs_State.TopAbs_OUT
    return np.array([classifier.Perform(gp_Pnt2d(float(u), float(v))) != outside for u, v in uv], dtype=bool)
