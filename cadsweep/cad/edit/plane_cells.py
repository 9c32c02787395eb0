"""Cells between lines of a plane, the faces of a part over each of them, and their prism.

Place in the flow: called for the projected outlines of a part's caps, and again for those that were laid together.

Method: OpenCASCADE's face builder makes the cells. Which faces lie over a cell follows from its neighbour by the edge
between them: who crosses it enters some faces and leaves others. The cells are extruded to a prism, so that whatever
meshes the source cap of a sweep can mesh them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from OCP.BOPAlgo import BOPAlgo_BuilderFace
from OCP.BOPTools import BOPTools_AlgoTools3D
from OCP.BRep import BRep_Builder
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeSolid
from OCP.BRepGProp import BRepGProp
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.IntTools import IntTools_Context
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Shell
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray
from ...brep import Solid
from ...errors import CadError
from ...stack import Arrangement
from ..extract.solids import extract_solid
from ..shapes import EDGE, FACE, compound, explore, index_map, listed, typed

_FORWARD, _REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED


class Line(NamedTuple):
    """An edge of the plane, and the edges of the part that lie over it, whether run the same way."""

    shape: Any
    over: list[tuple[int, bool]]


def cells_between(  # noqa: PLR0917
    solid: Solid, direction: FloatArray, sides: Mapping[int, int], pieces: Sequence[Line], plane: Any, along: FloatArray
) -> Arrangement:
    """Make the cells between lines that meet in their ends alone, and the prism over them.

    Raises
    ------
    CadError
        OpenCASCADE fails, or what it makes is no division of the plane by these lines.
    """
    edges = [piece.shape for piece in pieces]
    faces = _cells(edges, plane)
    beside = _beside(faces, edges)
    caps = _caps_over(solid, direction, sides, pieces, beside, len(faces))
    kept = [j for j, own in enumerate(caps) if own]
    return _prism(faces, kept, pieces, beside, caps, along)


def _cells(edges: Sequence[Any], plane: Any) -> list[Any]:
    """Plane faces between edges, their normals along the direction."""
    builder = BOPAlgo_BuilderFace()
    builder.SetFace(typed(BRepBuilderAPI_MakeFace(plane.Pln()).Face(), FACE))
    shapes = TopTools_ListOfShape()
    for edge in edges:
        shapes.Append(edge.Oriented(TopAbs_Orientation.TopAbs_FORWARD))
        shapes.Append(edge.Oriented(TopAbs_Orientation.TopAbs_REVERSED))
    builder.SetShapes(shapes)
    builder.Perform()
    if builder.HasErrors() or not builder.Areas().Size():
        raise CadError("OpenCASCADE could not make cells of the outlines of the caps")
    # What lies outside of all outlines comes as a face of negative area.
    return [typed(face, FACE) for face in listed(builder.Areas()) if _area(face) > 0.0]


def _area(face: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    return float(properties.Mass())


def _beside(faces: Sequence[Any], edges: Sequence[Any]) -> list[list[int]]:
    """For every edge the cells on its left and on its right, -1 outside."""
    number = index_map(compound(edges), EDGE)
    beside = [[-1, -1] for _ in edges]
    for j, face in enumerate(faces):
        if face.Orientation() != TopAbs_Orientation.TopAbs_FORWARD:
            raise CadError("a cell of the arrangement is turned over")
        for edge in explore(face, EDGE):
            turn = edge.Orientation()
            if turn not in (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED):
                raise CadError("an outline of the caps ends inside a cell of the arrangement")
            beside[number.FindIndex(edge) - 1][turn != TopAbs_Orientation.TopAbs_FORWARD] = j
    return beside


def _caps_over(  # noqa: PLR0917
    solid: Solid,
    direction: FloatArray,
    sides: Mapping[int, int],
    pieces: Sequence[Line],
    beside: Sequence[Sequence[int]],
    n_cells: int,
) -> list[frozenset[int]]:
    """The faces over every cell: who crosses an edge to its left enters the faces on its left and leaves the others."""
    left_of: dict[tuple[int, bool], set[int]] = {}
    for f, side in sides.items():
        for loop in solid.faces[f].loops:
            for e, forward in loop.directed:
                # The face lies on the left of its own loop seen from outside, from below where its normal points down.
                left_of.setdefault((e, forward == (side > 0)), set()).add(f)
    changes: list[tuple[set[int], set[int]]] = []
    for piece in pieces:
        entered, left = set(), set()
        for e, same in piece.over:
            entered |= left_of.get((e, same), set())
            left |= left_of.get((e, not same), set())
        changes.append((entered, left))
    around: list[list[tuple[int, int, bool]]] = [[] for _ in range(n_cells + 1)]
    for j, (a, b) in enumerate(beside):
        around[b].append((j, a, True))
        around[a].append((j, b, False))
    over: list[set[int] | None] = [None] * n_cells + [set()]
    waiting = [n_cells]
    while waiting:
        cell = waiting.pop()
        own = over[cell]
        assert own is not None
        for j, other, to_left in around[cell]:
            entered, left = changes[j] if to_left else changes[j][::-1]
            there = (own - (left - entered)) | (entered - left)
            known = over[other]
            if known is None:
                over[other] = there
                waiting.append(other)
            elif known != there or not left - entered <= own or (entered - left) & own:
                raise CadError("the cells of the caps' outlines do not fit together: edges nearly lie on each other")
    if any(caps is None for caps in over):
        raise CadError("a cell of the caps' outlines has no neighbour")
    return [frozenset(caps or ()) for caps in over[:-1]]


def _prism(  # noqa: PLR0917
    faces: Sequence[Any],
    kept: Sequence[int],
    pieces: Sequence[Line],
    beside: Sequence[Sequence[int]],
    caps: Sequence[frozenset[int]],
    along: FloatArray,
) -> Arrangement:
    """Extrude the rim of the cells, put the cells under and over it, and read the solid."""
    inside = set(kept)
    rim = [
        piece.shape.Oriented(_FORWARD if left in inside else _REVERSED)
        for piece, (left, right) in zip(pieces, beside, strict=True)
        if (left in inside) != (right in inside)
    ]
    # Of the rim alone: OpenCASCADE's time for many cells grows with their square.
    maker = BRepPrimAPI_MakePrism(compound(rim), gp_Vec(*along))
    up = maker.LastShape(rim[0]).Location().Multiplied(rim[0].Location().Inverted())
    builder, shell = BRep_Builder(), TopoDS_Shell()
    builder.MakeShell(shell)
    for edge in rim:
        builder.Add(shell, _facing_out(maker.Generated(edge).First(), edge, along))
    for j in kept:
        builder.Add(shell, faces[j].Reversed())
        builder.Add(shell, faces[j].Moved(up))
    shell.Closed(True)
    shape = BRepBuilderAPI_MakeSolid(shell).Solid()
    prism = extract_solid(shape)
    face_number, edge_number = index_map(shape, FACE), index_map(shape, EDGE)
    context = IntTools_Context()
    bottoms, tops, places = [], [], []
    for j in kept:
        bottoms.append(face_number.FindIndex(faces[j]) - 1)
        tops.append(face_number.FindIndex(faces[j].Moved(up)) - 1)
        place = gp_Pnt()
        if BOPTools_AlgoTools3D.PointInFace_s(faces[j], place, gp_Pnt2d(), context) != 0:
            raise CadError("a cell of the arrangement has no inside")
        places.append(_row(place))
    top_edges, over, ways = {}, {}, {}
    for piece, (left, right) in zip(pieces, beside, strict=True):
        if left in inside or right in inside:  # others bound no material
            e = edge_number.FindIndex(piece.shape) - 1
            top_edges[e] = edge_number.FindIndex(piece.shape.Moved(up)) - 1
            over[e] = tuple(one for one, _ in piece.over)
            ways[e] = tuple(same for _, same in piece.over)
    if min([*bottoms, *tops, *top_edges, *top_edges.values()]) < 0:
        raise CadError("OpenCASCADE lost a cell of the arrangement when it was extruded")
    return Arrangement(
        prism=prism,
        bottoms=tuple(bottoms),
        tops=tuple(tops),
        top_edges=top_edges,
        caps=tuple(caps[j] for j in kept),
        places=np.array(places),
        over=over,
        ways=ways,
    )


def _facing_out(face: Any, edge: Any, along: FloatArray) -> Any:
    """A side turned so that its normal points to the right of its edge."""
    curve = BRepAdaptor_Curve(typed(edge, EDGE))
    place, tangent = gp_Pnt(), gp_Vec()
    curve.D1((curve.FirstParameter() + curve.LastParameter()) / 2.0, place, tangent)
    run = np.array([tangent.X(), tangent.Y(), tangent.Z()])
    out = np.cross(run if edge.Orientation() == _FORWARD else -run, along)
    surface = BRepAdaptor_Surface(typed(face, FACE))
    surface_tangents = gp_Vec(), gp_Vec()
    surface.D1(
        (surface.FirstUParameter() + surface.LastUParameter()) / 2.0,
        (surface.FirstVParameter() + surface.LastVParameter()) / 2.0,
        gp_Pnt(),
        *surface_tangents,
    )
    normal = surface_tangents[0].Crossed(surface_tangents[1])
    same = float(np.array([normal.X(), normal.Y(), normal.Z()]) @ out) > 0.0
    return face.Oriented(_FORWARD if same else _REVERSED)


def _row(point: Any) -> FloatArray:
    return np.array([point.X(), point.Y(), point.Z()])


__all__ = ["Line", "cells_between"]
