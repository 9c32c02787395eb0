"""Plane faces of many holes checked in time that grows with their number.

OpenCASCADE's check of a face intersects all pairs of its wires, and looks for each wire which of the others it lies in:
seconds for a thousand holes. Holes whose boxes are apart cannot meet, nor lie in each other.

Place in the flow: :mod:`.validate` and :mod:`.divide` ask here first, and OpenCASCADE where this finds nothing sure.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepCheck import BRepCheck_Analyzer, BRepCheck_Shell, BRepCheck_Status
from OCP.BRepTools import BRepTools
from OCP.Geom import Geom_Plane
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.gp import gp_Trsf
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location

from ...arrays import FloatArray
from ...polygons import is_inside, signed_areas
from ..shapes import EDGE, FACE, SHELL, WIRE, explore, in_turn, near_boxes, subshapes, typed

MANY = 32
"""Wires of a face from which on pairs of them take longer than what is done here."""
_FINE = BRepCheck_Status.BRepCheck_NoError
_SHARES = [k / 8 for k in range(8)]
"""Shares of an edge at which the course of a wire is judged."""


def is_valid_apart(shape: Any) -> bool:
    """Whether a shape is sure to be valid, though it has plane faces of many holes; False where that cannot be told."""
    faces = subshapes(shape, FACE)
    crowded = [face for face in faces if _is_crowded(face)]
    if not crowded or not all(_are_apart(face) for face in crowded):
        return False
    shells = [BRepCheck_Shell(shell) for shell in subshapes(shape, SHELL)]
    if any(status != _FINE for shell in shells for status in (shell.Closed(), shell.Orientation())):
        return False
    others = (face for face in faces if not any(face.IsSame(own) for own in crowded))
    return len(shells) <= 1 and all(BRepCheck_Analyzer(face).IsValid() for face in others)


def _is_crowded(face: Any) -> bool:
    return isinstance(BRep_Tool.Surface_s(face), Geom_Plane) and len(subshapes(face, WIRE)) >= MANY


def _are_apart(face: Any) -> bool:
    """Whether the wires of a plane face are sound each by itself, and the holes lie inside and away from each other."""
    plane = BRep_Tool.Surface_s(face)
    outer = BRepTools.OuterWire_s(face)
    wires = subshapes(face, WIRE)
    holes = [wire for wire in wires if not wire.IsSame(outer)]
    position = plane.Pln().Position()
    frame = np.array([_row(position.XDirection()), _row(position.YDirection())])
    upright = gp_Trsf()
    upright.SetTransformation(position)
    there = TopLoc_Location(upright)
    boxes = _boxes([wire.Moved(there) for wire in holes])
    rim = _boxes([edge.Moved(there) for edge in explore(outer, EDGE)])
    origin = frame @ _row(position.Location())
    if near_boxes(boxes, rim, 0.0).any() or np.count_nonzero(near_boxes(boxes, boxes, 0.0)) > len(holes):
        return False
    courses = [_course(wire, face) for wire in (outer, *holes)]
    corners = np.array(list(chain.from_iterable(courses))) @ frame.T - origin
    stops = np.cumsum([len(course) for course in courses])
    if not is_inside([corners[: stops[0]]], boxes.mean(axis=1)).all():
        return False
    areas = signed_areas(corners, stops)
    if (areas[1:] * areas[0] >= 0.0).any():
        return False
    return all(_is_sound_alone(plane, wire, area) for wire, area in zip((outer, *holes), areas.tolist(), strict=True))


def _is_sound_alone(plane: Any, wire: Any, area: float) -> bool:
    """Whether a wire bounds a face by itself, turned so that this lies inside of it."""
    maker = BRepBuilderAPI_MakeFace(plane.Pln(), typed(wire if area > 0.0 else wire.Reversed(), WIRE), False)
    return bool(maker.IsDone() and BRepCheck_Analyzer(maker.Face()).IsValid())


def _boxes(shapes: Sequence[Any]) -> FloatArray:
    """Least and greatest coordinates (m, 2, 2) of shapes of the plane z = 0."""
    found = []
    for shape in shapes:
        box = Bnd_Box()
        BRepBndLib.Add_s(shape, box)
        found.append(box.Get())
    return np.array(found).reshape(-1, 2, 3)[:, :, :2]


def _course(wire: Any, face: Any) -> list[tuple[float, float, float]]:
    """Points along a wire, in its direction."""
    points: list[tuple[float, float, float]] = []
    for edge in in_turn(wire, face):
        curve = BRepAdaptor_Curve(edge)
        begin, end = curve.FirstParameter(), curve.LastParameter()
        if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            begin, end = end, begin
        # Tuples: an array for each point takes longer than the point.
        is_line = curve.GetType() == GeomAbs_CurveType.GeomAbs_Line
        points += [
            curve.Value(begin + share * (end - begin)).Coord() for share in (_SHARES[:1] if is_line else _SHARES)
        ]
    return points


def _row(point: Any) -> FloatArray:
    return np.array([point.X(), point.Y(), point.Z()])


__all__ = ["is_valid_apart"]
