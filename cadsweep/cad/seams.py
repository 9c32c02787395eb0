"""Faces that meet along the seam of the one closed surface both lie on get a surface each.

Place in the flow: after healing, before dividing.

A boolean operation that crosses a seam leaves an edge with two parameter curves on one surface, as a
seam has, though each of two faces uses it once. ``ShapeUpgrade_ShapeDivideClosed`` takes such a face for
a closed one and loses its parameter curves.
"""

from __future__ import annotations

from typing import Any

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location

from .shapes import EDGE, FACE, explore, subshapes, typed
from .tracing import Traced


def part_seams(traced: Traced) -> None:
    """Give every face that uses a seam from one side only a copy of its surface, in a copy of the shape."""
    chosen = [face for face in subshapes(traced.shape, FACE) if _uses_half_a_seam(face)]
    if not chosen:
        return
    tool = BRepBuilderAPI_Copy(traced.shape)
    copies = [typed(tool.ModifiedShape(face), FACE) for face in chosen]
    for face in copies:
        _own_surface(face)
    traced.replace(tool.Shape(), tool.ModifiedShape)


def _uses_half_a_seam(face: Any) -> bool:
    edges = list(explore(face, EDGE))
    return any(
        BRep_Tool.IsClosed_s(edge, face) and sum(edge.IsSame(other) for other in edges) == 1
        for edge in edges
        if not BRep_Tool.Degenerated_s(edge)
    )


def _own_surface(face: Any) -> None:
    face = typed(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD), FACE)
    here = TopLoc_Location()
    surface = BRep_Tool.Surface_s(face).Copy()  # the location is in it
    builder = BRep_Builder()
    tolerance = BRep_Tool.Tolerance_s(face)
    todo = []
    for edge in subshapes(face, EDGE):
        uses = [use for use in explore(face, EDGE) if use.IsSame(edge)]
        uses.sort(key=lambda use: use.Orientation() == TopAbs_Orientation.TopAbs_REVERSED)
        todo.append((edge, [BRep_Tool.CurveOnSurface_s(use, face, 0.0, 1.0) for use in uses]))
    for edge, curves in todo:
        if None not in curves:
            first, last = BRep_Tool.Range_s(edge, face)
            # of a true seam both curves, that of its forward use first
            builder.UpdateEdge(edge, *[c.Copy() for c in curves], surface, here, BRep_Tool.Tolerance_s(edge))
            builder.Range(edge, surface, here, first, last)
    builder.UpdateFace(face, surface, here, tolerance)
