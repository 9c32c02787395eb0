"""Vertices that cover the gaps between the curves that end in them, as a face's parameters have them.

Place in the flow: :mod:`.solids` calls it for a solid that OpenCASCADE finds invalid. Some programs write curves in
space a few millionths off the surfaces that they lie on. In the parameters of a face two of them may then end farther
apart than the tolerance of their vertex says, and its wire counts as open. Nothing is moved; the vertex says by how
much they miss each other.
"""

from __future__ import annotations

from math import dist
from typing import Any

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp

from ..shapes import EDGE, FACE, WIRE, children, subshapes, surface_range, typed
from .tracing import Traced

_MORE = 1.1
"""Tolerance over the gap that it covers."""


def cover_gaps(traced: Traced, most: float) -> bool:
    """Widen tolerances of vertices, in a copy, to the gaps of no more than `most` that are wider; False for none."""
    tool = BRepBuilderAPI_Copy(traced.shape)
    builder, found = BRep_Builder(), False
    for face in subshapes(tool.Shape(), FACE):
        surface = BRepAdaptor_Surface(face)
        lengths = most / surface.UResolution(most), most / surface.VResolution(most)
        for wire in subshapes(face, WIRE):
            for vertex, gap in _gaps(wire, face, lengths):
                needed = _MORE * gap
                if BRep_Tool.Tolerance_s(vertex) < needed <= most:
                    builder.UpdateVertex(vertex, needed)
                    found = True
    if found:
        traced.replace(tool.Shape(), tool.ModifiedShape)
    return found


def _gaps(wire: Any, face: Any, lengths: tuple[float, float]) -> list[tuple[Any, float]]:
    """Vertices of a wire, and how far from the end of an edge the next one begins, at `lengths` of the parameters.

    OpenCASCADE's own walk along a wire ends at a gap; of several edges that begin in a vertex the nearest is the next.
    A wire that has no curve for an edge has other faults.
    """
    begin, end = [], []
    for edge in (typed(child, EDGE) for child in children(wire)):
        limits = surface_range(edge, face)
        curve = BRep_Tool.CurveOnSurface_s(edge, face, *limits)
        if curve is None:
            return []
        points = map(curve.Value, limits)
        places = [(lengths[0] * point.X(), lengths[1] * point.Y()) for point in points]
        if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            places.reverse()
        begin.append((TopExp.FirstVertex_s(edge, True), places[0]))
        end.append((TopExp.LastVertex_s(edge, True), places[1]))
    return [
        (vertex, min(dist(place, other) for start, other in begin if start.IsSame(vertex))) for vertex, place in end
    ]


__all__ = ["cover_gaps"]
