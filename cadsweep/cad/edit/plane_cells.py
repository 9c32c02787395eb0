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
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Pnt, gp_Pnt2d
from OCP.GProp import GProp_GProps
from OCP.IntTools import IntTools_Context
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray
from ...brep import Solid
from ...errors import CadError
from ...stack import Arrangement
from ..extract.prism import extrude_cells
from ..geometry.convert import read_surface
from ..shapes import EDGE, FACE, compound, explore, index_map, listed, typed


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
    return _prism(faces, kept, pieces, beside, caps, plane, along)


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
    plane: Any,
    along: FloatArray,
) -> Arrangement:
    """Extrude the cells that have material over them."""
    number = {j: k for k, j in enumerate(kept)}
    sides = [(number.get(left, -1), number.get(right, -1)) for left, right in beside]
    lines = [j for j, own in enumerate(sides) if own != (-1, -1)]  # others bound no material
    prism = extrude_cells(
        [faces[j] for j in kept],
        [pieces[j].shape for j in lines],
        [sides[j] for j in lines],
        read_surface(plane),
        along,
    )
    context = IntTools_Context()
    places = []
    for j in kept:
        place = gp_Pnt()
        if BOPTools_AlgoTools3D.PointInFace_s(faces[j], place, gp_Pnt2d(), context) != 0:
            raise CadError("a cell of the arrangement has no inside")
        places.append(_row(place))
    return Arrangement(
        prism=prism.solid,
        bottoms=prism.bottoms,
        tops=prism.tops,
        top_edges=dict(zip(prism.lower, prism.upper, strict=True)),
        caps=tuple(caps[j] for j in kept),
        places=np.array(places),
        over={e: tuple(one for one, _ in pieces[j].over) for e, j in zip(prism.lower, lines, strict=True)},
        ways={e: tuple(same for _, same in pieces[j].over) for e, j in zip(prism.lower, lines, strict=True)},
    )


def _row(point: Any) -> FloatArray:
    return np.array([point.X(), point.Y(), point.Z()])


__all__ = ["Line", "cells_between"]
