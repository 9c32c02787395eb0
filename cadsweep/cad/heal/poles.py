"""Turned faces that close in a point on their axis get the seam and the point that reading has lost, others lose points
that they never had.

Place in the flow: part of healing, before the solid is judged. Of a dome whose arc ends on the axis, but is not centred
on it, OpenCASCADE's reader of STEP keeps the rim alone, and its face has no inside then. Of a turned face between two
rims it may take the rims for a turn apart, and fill what is missing with edges of no length, which then goes around
twice.

Method: the face is bounded anew, by its rim, the meridian from there to the first point on the axis on the side that
the rim leaves to its left, and that point. Edges of no length whose places are not all one go, and what they left apart
is brought together by whole turns (``ShapeFix_Wire``).
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepTools import BRepTools_ReShape
from OCP.Geom import Geom_SurfaceOfRevolution
from OCP.Geom2d import Geom2d_Line
from OCP.gp import gp_Dir2d, gp_Pnt2d
from OCP.Precision import Precision
from OCP.ShapeFix import ShapeFix_Wire
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS_Edge, TopoDS_Wire

from ...arrays import FloatArray
from ..shapes import EDGE, FACE, WIRE, explore, subshapes, surface_range, typed
from .tracing import Traced

_SAMPLES = 2049
"""Places along a meridian between which it meets the axis."""
_LEVEL = 1e-6
"""Parameter along the meridian over which a rim may run, as a share of a turn."""

FORWARD, REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED


def close_poles(traced: Traced) -> list[str]:
    """Close turned faces that have one rim and no seam, in place; a note says of how many."""
    reshape, n_closed, n_opened = BRepTools_ReShape(), 0, 0
    for face in subshapes(traced.shape, FACE):
        forward = typed(face.Oriented(FORWARD), FACE)
        closed = _closed(forward)
        opened = _without_false_poles(forward) if closed is None else None
        n_closed, n_opened = n_closed + (closed is not None), n_opened + (opened is not None)
        if closed is not None or opened is not None:
            reshape.Replace(forward, closed or opened)
    if n_closed or n_opened:
        traced.replace(reshape.Apply(traced.shape), reshape.Apply)
    notes = [f"turned faces closed at their axis: {n_closed}"] if n_closed else []
    return notes + ([f"turned faces that went around twice as read: {n_opened}"] if n_opened else [])


def _without_false_poles(face: Any) -> Any:
    """A face, which stands forward, without edges of no length that are no points; None where it has none."""
    surface, reshape, found = BRep_Tool.Surface_s(face), BRepTools_ReShape(), False
    for edge in explore(face, EDGE):
        if BRep_Tool.Degenerated_s(edge):
            curve, (first, last) = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0), surface_range(edge, face)
            ends, middle = (surface.Value(*curve.Value(t).Coord()) for t in (first, 0.5 * (first + last)))
            if ends.Distance(middle) > 2.0 * BRep_Tool.Tolerance_s(edge):
                reshape.Remove(edge)
                found = True
    if not found:
        return None
    made = typed(reshape.Apply(face), FACE)
    for wire in subshapes(made, WIRE):
        ShapeFix_Wire(wire, made, Precision.Confusion_s()).FixShifted()
    return made if BRepCheck_Analyzer(made).IsValid() else None


def _closed(face: Any) -> Any:
    """A face, which stands forward, with its seam and its pole; None where it has them, or is no such face."""
    surface = BRep_Tool.Surface_s(face)
    rims = [*explore(face, EDGE)] if isinstance(surface, Geom_SurfaceOfRevolution) else []
    if len(rims) != 1 or BRep_Tool.Degenerated_s(rims[0]):
        return None
    (rim,) = rims
    curve = BRep_Tool.CurveOnSurface_s(rim, face, 0.0, 1.0)
    begin, end = (np.array(curve.Value(t).Coord()) for t in surface_range(rim, face))
    turn, rise = end - begin
    if abs(abs(turn) - 2.0 * pi) > _LEVEL or abs(rise) > _LEVEL * 2.0 * pi:
        return None
    is_up = (turn > 0.0) == (rim.Orientation() == FORWARD)
    pole = _pole(surface, float(begin[1]), 1.0 if is_up else -1.0)
    begins = (float(min(begin[0], end[0])), float(begin[1]))
    return None if pole is None else _bounded(face, rim, begins, pole)


def _pole(surface: Any, level: float, way: float) -> float | None:
    """Parameter of the first point on the axis from a rim one way along the meridian; None where there is none."""
    first, last = surface.Bounds()[2:]
    reach = surface.VPeriod() if surface.IsVPeriodic() else (last - level if way > 0.0 else level - first)
    at = level + way * reach * np.linspace(0.0, 1.0, _SAMPLES)
    origin, along = (np.array(thing.Coord()) for thing in (surface.Axis().Location(), surface.Axis().Direction()))

    def off(places: FloatArray) -> FloatArray:
        arms = np.array([surface.Value(0.0, v).Coord() for v in places.tolist()]) - origin
        return np.asarray(arms - (arms @ along)[:, None] * along)

    arms = off(at)
    beside = arms @ arms[0]
    crossed = np.flatnonzero((beside[:-1] > 0.0) & (beside[1:] <= 0.0))
    if not len(crossed):
        return None
    low, high = at[crossed[0]], at[crossed[0] + 1]
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if off(np.array([middle]))[0] @ arms[0] > 0.0 else (low, middle)
    return float(0.5 * (low + high))


def _bounded(face: Any, rim: Any, begins: tuple[float, float], pole: float) -> Any:
    """The face bounded by its rim, a seam from there to the pole and back, and the pole."""
    (begin, level), builder, surface = begins, BRep_Builder(), BRep_Tool.Surface_s(face)
    made, wire, seam, tip = typed(face.EmptyCopied(), FACE), TopoDS_Wire(), TopoDS_Edge(), TopoDS_Edge()
    at_rim = TopExp.FirstVertex_s(rim)
    at_pole = BRepBuilderAPI_MakeVertex(surface.Value(begin, pole)).Vertex()
    low, high = min(level, pole), max(level, pole)
    is_up = pole > level
    builder.MakeEdge(seam, surface.UIso(begin), 1e-7)
    builder.Range(seam, low, high)
    meridians = [Geom2d_Line(gp_Pnt2d(u, 0.0), gp_Dir2d(0.0, 1.0)) for u in (begin + 2.0 * pi, begin)]
    builder.UpdateEdge(seam, *(meridians if is_up else meridians[::-1]), made, 1e-7)
    builder.Add(seam, (at_rim if is_up else at_pole).Oriented(FORWARD))
    builder.Add(seam, (at_pole if is_up else at_rim).Oriented(REVERSED))
    builder.MakeEdge(tip)
    builder.UpdateEdge(tip, Geom2d_Line(gp_Pnt2d(0.0, pole), gp_Dir2d(1.0, 0.0)), made, 1e-7)
    builder.Range(tip, begin, begin + 2.0 * pi)
    builder.Add(tip, at_pole.Oriented(FORWARD))
    builder.Add(tip, at_pole.Oriented(REVERSED))
    builder.Degenerated(tip, True)
    builder.MakeWire(wire)
    back = tip.Oriented(REVERSED if is_up else FORWARD)
    for edge in (rim, seam.Oriented(FORWARD), seam.Oriented(REVERSED), back):
        builder.Add(wire, edge)
    wire.Closed(True)
    builder.Add(made, wire)
    return made


__all__ = ["close_poles"]
