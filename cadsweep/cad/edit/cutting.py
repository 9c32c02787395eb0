"""A cell parted by a cutter: pieces, names kept, and the whole part imprinted again.

Place in the flow: the step of the search for cuts on solids of any kind.

Method: OpenCASCADE's splitter, whose word is not taken for it: the volume must be kept, every piece closed and valid,
no piece a sliver and no edge shorter than the model can bear. The pieces and the neighbours are imprinted as one part.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BOPAlgo import BOPAlgo_Splitter
from OCP.TopAbs import TopAbs_Orientation

from ...brep import Part, Solid
from ...errors import CadError
from ..extract.labels import EdgeLabel, FaceLabel, Labels
from ..heal.validate import check_closed, faults
from ..imprinting.checking import volume_and_center
from ..imprinting.joining import imprint
from ..shapes import EDGE, FACE, SOLID, explore, index_map, shapes_of, subshapes

logger = logging.getLogger(__name__)

KEPT = 1e-9
"""Share of the volume that a split of a planar cell may change: rounding alone."""
INTEGRATED = 1e-6
"""The same where faces are curved: OpenCASCADE's integrals differ by as much."""
THINNEST = 1e-6
"""Volume of a piece, as a share of the cell's, below which it is a sliver."""
SHORTEST = 1e-3
"""Length of a new edge, as a share of the part's size, below which a cut is refused."""


def cut_cell(part: Part, cell: int, tools: Sequence[Any], others: Sequence[int] = ()) -> Part | None:
    """Part one cell; None where the tools do not divide it, or not well.

    Parameters
    ----------
    part : Part
    cell : int
    tools : sequence of TopoDS_Face
    others : sequence of int
        Cells that are parted with it where the tools divide them well.

    Returns
    -------
    Part or None
        The pieces stand where the cell stood; owners and names are kept, faces of the cut have none.
    """
    solid = part.solids[cell]
    pieces = _split(solid, tools)
    if pieces is None:
        return None
    parted = {cell: pieces}
    for other in others:
        own_pieces = _split(part.solids[other], tools) if other != cell else None
        if own_pieces is not None:
            parted[other] = own_pieces
    shapes, labels, owners = [], [], []
    for j, own in enumerate(part.solids):
        for shape, label in parted.get(j) or [(shapes_of(own).shape, labels_of(own))]:
            shapes.append(shape)
            labels.append(label)
            owners.append(part.owners[j])
    try:
        found = imprint(
            shapes,
            labels=labels,
            models=part.models,
            owners=owners,
            units=solid.units,
            name=part.name,
            notes=part.notes,
            names=part.names,
        )
        return replace(found, touch=part.touch)
    except CadError as error:
        logger.info("a cut of cell %d is given up: %s", cell, error)
        return None


def labels_of(solid: Solid) -> Labels:
    """The labels of a solid's faces and edges, as they were read."""
    return Labels(
        [FaceLabel(face.key, face.names, face.color) for face in solid.faces],
        [EdgeLabel(edge.key, edge.names) for edge in solid.edges],
    )


def _split(solid: Solid, tools: Sequence[Any]) -> list[tuple[Any, Labels]] | None:
    """The pieces of a solid with the labels of their faces and edges."""
    holder = shapes_of(solid)
    splitter = BOPAlgo_Splitter()
    splitter.AddArgument(holder.shape)
    for tool in tools:
        splitter.AddTool(tool)
    splitter.SetNonDestructive(True)
    splitter.SetRunParallel(False)
    splitter.Perform()
    if splitter.HasErrors():
        return None
    pieces = subshapes(splitter.Shape(), SOLID)
    if len(pieces) < 2 or not _sound(solid, holder.shape, pieces):
        return None
    labels = labels_of(solid)
    faces = _images(splitter, holder.faces, labels.faces, FACE)
    edges = _images(splitter, holder.edges, labels.edges, EDGE)
    return [
        (
            piece,
            Labels(
                [_found(faces, face) or FaceLabel() for face in subshapes(piece, FACE)],
                [_found(edges, edge) or EdgeLabel() for edge in subshapes(piece, EDGE)],
            ),
        )
        for piece in pieces
    ]


def _images(splitter: Any, old: Sequence[Any], labels: Sequence[Any], kind: Any) -> list[tuple[Any, Any]]:
    """What every old face (or edge) has become, with its label."""
    out = []
    for shape, label in zip(old, labels, strict=True):
        if splitter.IsDeleted(shape):
            continue
        became = list(splitter.Modified(shape)) or [shape]
        out += [(index_map(piece, kind), label) for piece in became]
    return out


def _found(images: Sequence[tuple[Any, Any]], shape: Any) -> Any:
    return next((label for found, label in images if found.Contains(shape)), None)


def _sound(solid: Solid, shape: Any, pieces: Sequence[Any]) -> bool:
    """Whether the pieces are the solid, and fit to be meshed."""
    whole = volume_and_center(shape)[0]
    volumes = [volume_and_center(piece)[0] for piece in pieces]
    curved = any(face.kind != "plane" for face in solid.faces)
    if abs(sum(volumes) - whole) > (INTEGRATED if curved else KEPT) * whole or min(volumes) < THINNEST * whole:
        return False
    old = index_map(shape, EDGE)
    for piece in pieces:
        # What dangles in a piece came of a tool that does not end on the solid's faces.
        if any(face.Orientation() == TopAbs_Orientation.TopAbs_INTERNAL for face in explore(piece, FACE)):
            return False
        try:
            check_closed(piece)
        except CadError:
            return False
        if faults(piece):
            return False
        for edge in subshapes(piece, EDGE):
            if not old.Contains(edge) and _length(edge) < SHORTEST * solid.size:
                return False
    return True


def _length(edge: Any) -> float:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.LinearProperties_s(edge, properties)
    return float(np.abs(properties.Mass()))
