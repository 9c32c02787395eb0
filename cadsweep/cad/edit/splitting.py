"""Faces of a solid divided along edges that lie on them, and edges at vertices, ids and names kept.

Place in the flow: the tool of :mod:`.fillets`, :mod:`.annuli` and :mod:`.bridging`; the pipeline divides edges with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepAlgoAPI import BRepAlgoAPI_Splitter
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid, BRepBuilderAPI_MakeVertex
from OCP.gp import gp_Pnt
from OCP.TopoDS import TopoDS_Shell
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray
from ...brep import Part, Solid
from ...errors import CadError
from ..extract.labels import EdgeLabel, Labels, label_of
from ..extract.shared import PartGeometry
from ..extract.solids import extract_solid, rekeyed
from ..heal.tracing import Traced, image_of
from ..heal.validate import check_closed
from ..names.naming import inner_point
from ..shapes import EDGE, FACE, SOLID, SolidShape, compound, index_map, shapes_of, subshapes, typed
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
    ((shape, _, traced),) = split([holder], cuts, normals)
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
    holders: Sequence[SolidShape], cuts: Sequence[Any], normals: Sequence[FloatArray] = ()
) -> list[tuple[Any, list[list[Any]], Traced]]:
    """As :func:`split_faces`: each solid, for each of its old faces the pieces, and what became of the old edges.

    What solids share they share afterwards.
    """
    splitter = BRepAlgoAPI_Splitter()
    arguments, tools = TopTools_ListOfShape(), TopTools_ListOfShape()
    shapes = [holder.shape for holder in holders]
    for shape in shapes:
        arguments.Append(shape)
    for edge in cuts:
        tools.Append(edge)
    splitter.SetArguments(arguments)
    splitter.SetTools(tools)
    splitter.SetNonDestructive(True)
    if not attempted(splitter.Build, "dividing faces", on=shapes):
        raise CadError("OpenCASCADE fails at dividing its faces")
    return [_pieces(shape, splitter, normals) for shape in shapes]


def _pieces(shape: Any, splitter: Any, normals: Sequence[FloatArray]) -> tuple[Any, list[list[Any]], Traced]:
    """What became of a solid: itself, the pieces of its faces, and its edges."""
    image = image_of(splitter)
    (split,) = subshapes(image(shape), SOLID)
    traced = Traced(shape)
    traced.replace(split, image)
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
    edges = [(j, solid.edges[j or 0]) for j in edge_origins]
    labels = Labels(
        [label_of(face)._replace(number=face.known) for face in old],
        [EdgeLabel(number=-1) if j is None else EdgeLabel(e.key, e.names, e.known) for j, e in edges],
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


def divide_edges(part: Part, places: Mapping[int, Mapping[int, Sequence[float]]]) -> Part | None:
    """A part with edges divided, in all solids that have them; None where OpenCASCADE cannot do that.

    Parameters
    ----------
    part : Part
    places : dict of int to dict
        By cell and edge where the edge is divided, in fractions of its length.
    """
    if not all(isinstance(solid.kernel, SolidShape) for solid in part.solids):
        return None
    tools = []
    for cell, of_edges in places.items():
        solid = part.solids[cell]
        for edge, fractions in of_edges.items():
            points = solid.edges[edge].curve.evaluate(np.array(fractions))
            tools += [BRepBuilderAPI_MakeVertex(gp_Pnt(*point)).Vertex() for point in points.tolist()]
    holders = [shapes_of(solid) for solid in part.solids]
    try:
        made = {cell: (shape, traced) for cell, (shape, _, traced) in enumerate(split(holders, tools))}
        divided = read_anew(part, holders, made)
    except (CadError, ValueError, RuntimeError):
        return None  # the part as it was has the last word
    pairs = zip(part.solids, divided.solids, strict=True)
    return divided if all(len(old.faces) == len(new.faces) for old, new in pairs) else None


def read_anew(
    part: Part, holders: Sequence[SolidShape], made: Mapping[int, tuple[Any, Traced]], *, closed: float = 0.0
) -> Part:
    """A part some of whose solids became others; what solids share they must share still.

    Parameters
    ----------
    part : Part
    holders : sequence of SolidShape
        The shapes of all its solids.
    made : dict of int to (TopoDS_Solid, Traced)
        By cell, what became of a solid.
    closed : float
        Width of gaps that were closed in them.

    Raises
    ------
    CadError
        The solids share another number of faces, or a face comes from none.
    """
    shapes = [made[cell][0] if cell in made else holder.shape for cell, holder in enumerate(holders)]
    shared = PartGeometry(compound(shapes), closed=max(closed, *(solid.closed for solid in part.solids)))
    solids = [
        extracted(solid, *made[cell], shared=shared)
        if cell in made
        else rekeyed(replace(solid, kernel=holders[cell]), shared)
        for cell, solid in enumerate(part.solids)
    ]
    if _n_shared(solids) != _n_shared(part.solids):
        raise CadError("solids share another number of faces")
    return replace(part, solids=tuple(solids))


def faces_in_contact(part: Part) -> list[frozenset[int]]:
    """For every cell its faces that it shares with another one."""
    keys, n_uses = np.unique(np.concatenate([solid.face_keys for solid in part.solids]), return_counts=True)
    shared = keys[n_uses > 1]
    return [frozenset(np.flatnonzero(np.isin(solid.face_keys, shared)).tolist()) for solid in part.solids]


def _n_shared(solids: Sequence[Solid]) -> int:
    keys = np.concatenate([solid.face_keys for solid in solids])
    return len(keys) - len(np.unique(keys))


__all__ = [
    "divide_edges",
    "divided_part",
    "extracted",
    "faces_in_contact",
    "in_order",
    "read_anew",
    "split",
    "split_faces",
]
