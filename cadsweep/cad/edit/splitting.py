"""Faces of a solid divided along edges that lie on them, ids and names kept.

Place in the flow: the tool of :mod:`.fillets` and :mod:`.annuli`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepAlgoAPI import BRepAlgoAPI_Splitter
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid
from OCP.TopoDS import TopoDS_Shell
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray
from ...brep import Part, Solid
from ...errors import CadError
from ..extract.labels import EdgeLabel, Labels, label_of
from ..extract.shared import PartGeometry
from ..extract.solids import extract_solid
from ..heal.tracing import Traced, image_of
from ..heal.validate import check_closed
from ..names.naming import inner_point
from ..shapes import EDGE, FACE, SOLID, SolidShape, index_map, subshapes, typed
from ..trial import attempted

SAME_VOLUME = 1e-6
"""Share of the volume that may change: OpenCASCADE integrates no better."""


def split_faces(solid: Solid, holder: SolidShape, cuts: Sequence[Any], normals: Sequence[FloatArray] = ()) -> Solid:
    """Divide the faces of a solid along edges that lie on them.

    Parameters
    ----------
    solid : Solid
    holder : SolidShape
        Its shapes.
    cuts : sequence of TopoDS_Edge
    normals : sequence of (3,) float64
        Of the pieces of a face, the one that leans least to any of these directions keeps the face's id; the others
        come after the last face.

    Raises
    ------
    CadError
        What OpenCASCADE made of it is no closed solid, or a face of it comes from none of the old ones.
    """
    shape, _, traced = split(holder, cuts, normals)
    return extracted(solid, shape, traced)


def divided_part(
    part: Part, cuts: Sequence[Any], normals: Sequence[FloatArray] = (), *, n_more: int | None = None
) -> Part | None:
    """A part of one solid with faces divided as by :func:`split_faces`; None where nothing is, or OpenCASCADE fails.

    Parameters
    ----------
    part : Part
    cuts : sequence of TopoDS_Edge
    normals : sequence of (3,) float64
    n_more : int or None
        Faces that are to come of it; None: any number.
    """
    solid = part.solids[0]
    if not cuts or not isinstance(solid.kernel, SolidShape):
        return None
    try:
        divided = split_faces(solid, solid.kernel, cuts, normals)
    except (CadError, ValueError, RuntimeError):
        return None  # the part as it was has the last word
    more = len(divided.faces) - len(solid.faces)
    if more < 1 or more != (n_more or more) or abs(divided.volume - solid.volume) > SAME_VOLUME * solid.volume:
        return None
    return replace(part, solids=(divided,))


def split(
    holder: SolidShape, cuts: Sequence[Any], normals: Sequence[FloatArray] = ()
) -> tuple[Any, list[list[Any]], Traced]:
    """As :func:`split_faces`: the solid, for each of its old faces the pieces, and what became of the old edges."""
    splitter = BRepAlgoAPI_Splitter()
    arguments, tools = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(holder.shape)
    for edge in cuts:
        tools.Append(edge)
    splitter.SetArguments(arguments)
    splitter.SetTools(tools)
    splitter.SetNonDestructive(True)
    if not attempted(splitter.Build, "dividing faces", on=[holder.shape]):
        raise CadError("OpenCASCADE fails at dividing its faces")
    (split,) = subshapes(splitter.Shape(), SOLID)

    traced = Traced(holder.shape)
    traced.replace(split, image_of(splitter))
    found = index_map(split, FACE)
    # As the solid has them: the pieces that history gives may be turned the other way.
    pieces = [[typed(found.FindKey(found.FindIndex(face)), FACE) for face in faces] for faces in traced.faces]
    for divided in pieces:
        if len(divided) > 1 and len(normals):
            divided.sort(key=lambda piece: _lean(piece, normals))
    return in_order(pieces), pieces, traced


def _lean(piece: Any, normals: Sequence[FloatArray]) -> float:
    """How much a face turns to the nearest cap: the greatest cosine in its middle."""
    found = inner_point(piece)
    if found is None:
        raise CadError("a piece of a divided face has no inside")
    normal = np.array([found[1].X(), found[1].Y(), found[1].Z()])
    return max(float(normal @ cap) for cap in normals)


def in_order(pieces: Sequence[Sequence[Any]]) -> Any:
    """A solid with its faces in the order of the faces they come from, second and further pieces last."""
    builder, shell = BRep_Builder(), TopoDS_Shell()
    builder.MakeShell(shell)
    for piece in [faces[0] for faces in pieces] + [piece for faces in pieces for piece in faces[1:]]:
        builder.Add(shell, piece)
    shell.Closed(True)
    solid = BRepBuilderAPI_MakeSolid(shell).Solid()
    check_closed(solid)
    return solid


def extracted(solid: Solid, shape: Any, traced: Traced, *, shared: PartGeometry | None = None) -> Solid:
    """A solid read anew, its faces and edges known by what those were called that they come from.

    Raises
    ------
    CadError
        A face comes from none.
    """
    origins = traced.face_origins(index_map(shape, FACE))
    edge_origins = traced.edge_origins(index_map(shape, EDGE))
    old = [solid.faces[j] for j in origins if j is not None]
    if len(old) != len(origins):
        raise CadError("a face of the divided solid comes from none of the old ones")
    labels = Labels(
        [label_of(face)._replace(number=face.known) for face in old],
        [EdgeLabel() if j is None else EdgeLabel(solid.edges[j].key, solid.edges[j].names) for j in edge_origins],
    )
    return extract_solid(
        shape,
        labels=labels,
        name=solid.name,
        material=solid.material,
        color=solid.color,
        units=solid.units,
        shared=PartGeometry(shape, closed=solid.closed) if shared is None else shared,
    )


__all__ = ["divided_part", "extracted", "in_order", "split", "split_faces"]
