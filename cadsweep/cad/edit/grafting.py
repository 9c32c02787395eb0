"""The pieces of cells put in their places, their neighbours' faces divided as they were: no second boolean operation.

Place in the flow: :mod:`.cutting` calls it where cells of a part were split. The cells of a part share their faces,
edges and vertices already, so what the splitter made of those of a cell is what its neighbours get. All other cells
stay as they were read, with new keys; a general fuse would make all of them anew, and costs five times as much.

Not handled: pieces with faces closed upon themselves, which are divided after a general fuse.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from OCP.BRepTools import BRepTools_ReShape
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopTools import TopTools_MapOfShape

from ...brep import Part, Solid
from ...errors import CadError
from ..extract.labels import EdgeLabel, FaceLabel, Labels, numbered_labels_of
from ..extract.shared import PartGeometry
from ..extract.solids import extract_solid, rekeyed
from ..heal.divide import is_divided
from ..heal.validate import check_closed, faults
from ..shapes import (
    EDGE,
    FACE,
    SOLID,
    VERTEX,
    SolidShape,
    compound,
    fine_volume,
    index_map,
    shapes_of,
    subshapes,
    typed,
    volume_and_center,
    volume_from_origin,
)

SAME_VOLUME = 1e-6
"""Share of a neighbour's volume that dividing its faces may change: OpenCASCADE integrates no better."""

_Label = TypeVar("_Label", FaceLabel, EdgeLabel)

Images = Callable[[Any], Sequence[Any]]
"""What a face, an edge or a vertex has become; empty where it is as it was."""


def graft(part: Part, pieces: Mapping[int, Sequence[tuple[Any, Labels]]], images: Images, *, closed: float) -> Part:
    """Put the pieces of cells in their places.

    Parameters
    ----------
    part : Part
    pieces : dict of int to sequence of (TopoDS_Solid, Labels)
        By cell.
    images : callable
        What was made of the faces, edges and vertices of these cells; of several faces it may be the same one.
    closed : float
        Width of gaps between solids that were closed when the part was imprinted, working units.

    Returns
    -------
    Part

    Raises
    ------
    CadError
        A piece or a neighbour has closed faces, or is not sound any more.
    """
    reshape = _following([shapes_of(part.solids[cell]) for cell in pieces], images)
    shapes: list[Any] = []
    labels: list[Labels] = []
    owners: list[int] = []
    old: list[Solid | None] = []
    for j, solid in enumerate(part.solids):
        if j in pieces:
            shapes += [piece for piece, _ in pieces[j]]
            labels += [label for _, label in pieces[j]]
            owners += [part.owners[j]] * len(pieces[j])
            old += [None] * len(pieces[j])
            continue
        shape = shapes_of(solid).shape
        now = typed(reshape.Apply(shape), SOLID)
        shapes.append(now)
        owners.append(part.owners[j])
        if now.IsEqual(shape):
            labels.append(numbered_labels_of(solid))
            old.append(solid)
            continue
        _check_same(solid, now)
        labels.append(_followed(solid, now, reshape))
        old.append(None)
    for shape, was in zip(shapes, old, strict=True):
        if was is None and not is_divided(shape):
            raise CadError("a piece has a face that is closed upon itself")
    shared = PartGeometry(compound(shapes), closed=max(closed, *(solid.closed for solid in part.solids)))
    solids = []
    for shape, label, owner, was in zip(shapes, labels, owners, old, strict=True):
        if was is not None:
            solids.append(rekeyed(was, shared))
            continue
        model = part.models[owner]
        solids.append(
            extract_solid(
                shape,
                labels=label,
                name=model.name,
                material=model.material,
                color=model.color,
                units=part.solids[0].units,
                shared=shared,
            )
        )
    return replace(part, solids=tuple(solids), owners=tuple(owners))


def _following(parted: Sequence[SolidShape], images: Images) -> BRepTools_ReShape:
    """What puts in the place of faces, edges and vertices of solids what was made of them."""
    reshape = BRepTools_ReShape()
    followed, placed = TopTools_MapOfShape(), TopTools_MapOfShape()
    for holder in parted:
        for sub in (*holder.vertices, *holder.edges, *holder.faces):
            became = images(sub)
            if not became or not followed.Add(sub):
                continue
            new = became[0] if sub.ShapeType() == VERTEX else compound([one for one in became if placed.Add(one)])
            # All ways of turning it are one: the replacement is turned as the one that it replaces.
            turned = sub.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
            reshape.Replace(sub.Oriented(TopAbs_Orientation.TopAbs_FORWARD), new.Reversed() if turned else new)
    return reshape


def _check_same(solid: Solid, now: Any) -> None:
    """Refuse a neighbour that is not what it was, with divided faces."""
    check_closed(now)
    damage = faults(now)
    if damage:
        raise CadError(f"dividing the faces of a neighbour made it invalid: {damage[0]}")
    before, after = shapes_of(solid).mass[0], volume_and_center(now)[0]
    if any(face.tips for face in solid.faces):  # the surface is open beside them
        before, after = shapes_of(solid).from_origin, volume_from_origin(now)
    elif abs(after - before) > SAME_VOLUME * before:
        before, after = fine_volume(shapes_of(solid).shape), fine_volume(now)
    if abs(after - before) > SAME_VOLUME * before:
        raise CadError(f"dividing the faces of a neighbour changed its volume from {before:.9g} to {after:.9g}")


def _followed(solid: Solid, now: Any, reshape: BRepTools_ReShape) -> Labels:
    """The labels of a neighbour, for the pieces of its faces and edges."""
    holder, was = shapes_of(solid), numbered_labels_of(solid)
    faces = _spread(index_map(now, FACE), [subshapes(reshape.Apply(f), FACE) for f in holder.faces], was.faces)
    edges = _spread(index_map(now, EDGE), [subshapes(reshape.Apply(e), EDGE) for e in holder.edges], was.edges)
    return Labels([label or FaceLabel() for label in faces], [label or EdgeLabel() for label in edges])


def _spread(found: Any, became: Sequence[Sequence[Any]], labels: Sequence[_Label]) -> list[_Label | None]:
    """Labels of old faces (or edges) for the new ones, in the order of their map."""
    out: list[_Label | None] = [None] * found.Extent()
    for pieces, label in zip(became, labels, strict=True):
        for piece in pieces:
            number = found.FindIndex(piece)
            if not number:
                raise CadError("a piece of a neighbour's face or edge is lost")
            out[number - 1] = label
    return out


__all__ = ["graft"]
