"""Closed faces and closed edges are divided, so that every edge has two vertices and every side rails.

Place in the flow: after healing, before extraction.

Method: OpenCASCADE's ``ShapeUpgrade_ShapeDivideClosed`` cuts a closed face along its seam and
opposite to it. It approximates the new edges by B-splines (2e-6 off a circle), therefore each new
edge that is an isoparametric line gets its exact curve, taken from the surface.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.GeomAdaptor import GeomAdaptor_Curve
from OCP.gp import gp_Vec
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideClosed, ShapeUpgrade_ShapeDivideClosedEdges
from OCP.TColStd import TColStd_Array1OfReal
from OCP.TopLoc import TopLoc_Location

from .shapes import EDGE, FACE, explore, index_map, subshapes
from .tracing import Traced


def divide_closed(traced: Traced) -> list[str]:
    """Divide closed faces, then closed edges, in place; return a note for each kind of change."""
    notes = []
    old_edges = index_map(traced.shape, EDGE)
    n_faces = len(subshapes(traced.shape, FACE))
    for tool_class in (ShapeUpgrade_ShapeDivideClosed, ShapeUpgrade_ShapeDivideClosedEdges):
        tool = tool_class(traced.shape)
        tool.SetNbSplitPoints(1)
        if tool.Perform():
            context = tool.GetContext()
            traced.replace(context.Apply(traced.shape), context.Apply)
    _make_exact(traced.shape, old_edges)
    n_new = len(subshapes(traced.shape, FACE)) - n_faces
    if n_new > 0:
        notes.append(f"{n_new} closed face{'s' if n_new > 1 else ''} divided in two")
    return notes


def _make_exact(shape: Any, old_edges: Any) -> None:
    """Give every new edge that runs along an isoparametric line the exact curve of that line."""
    builder = BRep_Builder()
    done = set()
    for face in subshapes(shape, FACE):
        surface = BRep_Tool.Surface_s(face)
        for edge in explore(face, EDGE):
            if edge in done or old_edges.Contains(edge) or BRep_Tool.Degenerated_s(edge):
                continue
            curve = BRep_Tool.Curve_s(edge, 0.0, 1.0)
            if curve is None or GeomAdaptor_Curve(curve).GetType() != GeomAbs_CurveType.GeomAbs_BSplineCurve:
                continue
            pcurve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0)
            iso = None if pcurve is None else _isoparametric(surface, pcurve)
            if iso is None:
                continue
            first, last = BRep_Tool.Range_s(edge)
            # Both curves must run alike in the parameter, or the edge is left as it is.
            tolerance = BRep_Tool.Tolerance_s(edge) + 1e-6
            at = np.linspace(first, last, 9)
            if max(iso.Value(float(t)).Distance(curve.Value(float(t))) for t in at) > 10 * tolerance:
                continue
            done.add(edge)
            builder.UpdateEdge(edge, iso, TopLoc_Location(), BRep_Tool.Tolerance_s(edge))
            builder.Range(edge, first, last)


def _isoparametric(surface: Any, pcurve: Any) -> Any:
    """The exact space curve of a parameter line along u or v with unit speed, else None."""
    adaptor = Geom2dAdaptor_Curve(pcurve)
    if adaptor.GetType() != GeomAbs_CurveType.GeomAbs_Line:
        return None
    line = adaptor.Line()
    origin, direction = line.Location(), line.Direction()
    along_v = abs(direction.X()) < 1e-12
    if not along_v and abs(direction.Y()) >= 1e-12:
        return None
    curve = surface.UIso(origin.X()) if along_v else surface.VIso(origin.Y())
    sense, start = (direction.Y(), origin.Y()) if along_v else (direction.X(), origin.X())
    return _shifted(curve, start, sense)


def _shifted(curve: Any, start: float, sense: float) -> Any:
    """The curve reparametrised by ``t -> start + sense * t`` where its kind allows it, else None."""
    while hasattr(curve, "BasisCurve") and hasattr(curve, "SetTrim"):
        curve = curve.BasisCurve()
    curve = curve.Copy()
    if sense < 0:
        # Reversed, the curve's old parameter p is its new parameter ReversedParameter(p).
        start = curve.ReversedParameter(start)
        curve.Reverse()
    kind = GeomAdaptor_Curve(curve).GetType()
    if kind == GeomAbs_CurveType.GeomAbs_Line:
        curve.Translate(gp_Vec(curve.Lin().Direction()).Multiplied(start))
    elif kind == GeomAbs_CurveType.GeomAbs_Circle:
        curve.Rotate(curve.Circ().Axis(), start)
    elif kind == GeomAbs_CurveType.GeomAbs_BSplineCurve:
        _shift_knots(curve, -start)
    elif abs(start) > 1e-14:
        return None
    return curve


def _shift_knots(curve: Any, shift: float) -> None:
    knots = TColStd_Array1OfReal(1, curve.NbKnots())
    for j in range(1, curve.NbKnots() + 1):
        knots.SetValue(j, curve.Knot(j) + shift)
    curve.SetKnots(knots)
