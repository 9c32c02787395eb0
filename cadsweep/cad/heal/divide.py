"""Closed faces and closed edges are divided, so that every edge has two vertices and every side rails.

Place in the flow: after healing, before extraction.

Method: OpenCASCADE's ``ShapeUpgrade_ShapeDivideClosed`` cuts a closed face along its seam and
opposite to it. It approximates the new edges by B-splines (2e-6 off a circle), therefore each new
edge that is an isoparametric line gets its exact curve, taken from the surface. It also turns the seam of a sphere
that a STEP file has as a whole (its outline a vertex alone) by a full turn of its circle, and leaves the curves in the
faces' parameters behind: these are brought to the same range, as no splitter parts a solid with an edge of two.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_Sewing
from OCP.BRepCheck import BRepCheck_Analyzer, BRepCheck_Status
from OCP.BRepGProp import BRepGProp
from OCP.BRepLib import BRepLib
from OCP.BRepTools import BRepTools, BRepTools_ReShape
from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor_Curve, GeomAdaptor_Surface
from OCP.gp import gp_Vec
from OCP.GProp import GProp_GProps
from OCP.ShapeBuild import ShapeBuild_ReShape
from OCP.ShapeFix import ShapeFix_Face, ShapeFix_Wireframe
from OCP.ShapeUpgrade import ShapeUpgrade_ShapeDivideClosed, ShapeUpgrade_ShapeDivideClosedEdges
from OCP.TColStd import TColStd_Array1OfReal
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape, TopTools_IndexedMapOfShape

from ...errors import CadError
from ..geometry.measure import measure_closed_area
from ..shapes import (
    EDGE,
    FACE,
    VERTEX,
    bounds,
    compound,
    explore,
    index_map,
    listed,
    mapped,
    space_range,
    subshapes,
    typed,
)
from ..trial import attempted
from .crowded import is_valid_apart
from .touched_seams import turn_split_rims
from .tracing import Traced
from .validate import place

TINY = 1e-6
"""Length of a new edge, as a share of the shape's size, below which it is none: two curves that meet were cut apart.
So far a face may be off its own parameters, too, where it cannot be divided otherwise."""

_OPEN = (GeomAbs_SurfaceType.GeomAbs_Plane, GeomAbs_SurfaceType.GeomAbs_Cylinder, GeomAbs_SurfaceType.GeomAbs_Cone)
"""Surfaces that are never closed both ways."""


def divide_closed(traced: Traced) -> list[str]:
    """Divide closed faces, then closed edges, in place; return a note on what was divided.

    Raises
    ------
    CadError
        A face is closed in a way that could not be divided.
    """
    old_faces, old_edges = index_map(traced.shape, FACE), index_map(traced.shape, EDGE)
    as_read, was_closed = traced.shape, not is_divided(traced.shape)
    if was_closed:
        _quarter_whole_surfaces(traced)
    before = copy(traced)
    _halve(traced)
    if not was_closed and traced.shape.IsSame(as_read):
        return []
    closed = _closed_upon_itself(traced.shape)
    if closed is not None:
        # The rims of a face that is off its own parameters by more than OpenCASCADE expects are not found by its seam.
        loosely = copy(before)
        _halve(loosely, _tiny(traced.shape))
        if is_divided(loosely.shape):
            traced.become(loosely)
            closed = None
    if closed is not None and turn_split_rims(before):
        traced.become(before)
        _halve(traced)
        closed = _closed_upon_itself(traced.shape)
    halved = traced.shape
    _drop_tiny(traced, old_edges)
    _make_exact(traced.shape, old_edges)
    _align_ranges(traced.shape, old_edges)
    _mend(traced, old_faces)
    _refuse_closed(closed if traced.shape.IsSame(halved) else _closed_upon_itself(traced.shape))
    _check_divided(traced.shape, old_faces)
    n_new = len(subshapes(traced.shape, FACE)) - old_faces.Extent()
    return [f"closed faces divided: {n_new} more than before"] if n_new > 0 else []


def _halve(traced: Traced, tolerance: float | None = None) -> None:
    for tool_class in (ShapeUpgrade_ShapeDivideClosed, ShapeUpgrade_ShapeDivideClosedEdges):
        tool = tool_class(traced.shape)
        tool.SetNbSplitPoints(1)
        if tolerance is not None:
            tool.SetMaxTolerance(tolerance)
        if attempted(tool.Perform, "dividing closed faces", on=[traced.shape]):
            context = tool.GetContext()
            traced.replace(context.Apply(traced.shape), context.Apply)


def _drop_tiny(traced: Traced, old_edges: Any) -> None:
    """Drop new edges of no length: two faces that are divided at one point of their common edge do not agree on it."""
    longest = _tiny(traced.shape)
    new = (edge for edge in subshapes(traced.shape, EDGE) if not old_edges.Contains(edge))
    if not any(_length(edge) < longest for edge in new):
        return
    context = ShapeBuild_ReShape()
    wires = ShapeFix_Wireframe(traced.shape)
    wires.SetContext(context)
    wires.SetPrecision(longest)
    wires.SetMaxTolerance(longest)
    wires.ModeDropSmallEdges = True
    if wires.FixSmallEdges():
        traced.replace(wires.Shape(), context.Apply)


def _tiny(shape: Any) -> float:
    return TINY * float(np.linalg.norm(np.diff(bounds(shape), axis=0)))


def _length(edge: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.LinearProperties_s(edge, properties)
    return float(properties.Mass())


def _quarter_whole_surfaces(traced: Traced) -> None:
    """Divide every face that is a whole surface, closed both ways, into four.

    OpenCASCADE's tool loses edges of such a face unless it is a torus.
    """
    reshape = BRepTools_ReShape()
    found = False
    for face in subshapes(traced.shape, FACE):
        surface = BRep_Tool.Surface_s(face)
        if GeomAdaptor_Surface(surface).GetType() in _OPEN or [n for _, n in _uses(face)] != [2, 2]:
            continue
        u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
        u, v = (u0 + u1) / 2, (v0 + v1) / 2
        sewing = BRepBuilderAPI_Sewing(1e-6)
        for box in ((u0, u, v0, v), (u, u1, v0, v), (u0, u, v, v1), (u, u1, v, v1)):
            # A copy each: on one common surface the edges of two quarters would count as seams.
            quarter = BRepBuilderAPI_MakeFace(surface.Copy(), *box, 1e-7).Face()
            sewing.Add(quarter.Oriented(face.Orientation()))
        sewing.Perform()
        # In the shell the face stands forward or reversed; the replacement takes that orientation on again.
        replacement = sewing.SewedShape()
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            replacement = replacement.Reversed()
        reshape.Replace(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD), replacement)
        found = True
    if found:
        traced.replace(reshape.Apply(traced.shape), reshape.Apply)


def _uses(face: Any) -> list[tuple[Any, int]]:
    """The edges of a face, each with how often it runs through it: twice on a seam."""
    numbers = index_map(face, EDGE)
    counts = Counter(numbers.FindIndex(edge) for edge in explore(face, EDGE))
    return [(edge, counts[j + 1]) for j, edge in enumerate(mapped(numbers, EDGE))]


def is_divided(shape: Any) -> bool:
    """Whether no face and no edge of a shape is closed upon itself."""
    return _closed_upon_itself(shape) is None


def _closed_upon_itself(shape: Any) -> tuple[int, Any] | None:
    """The first face with a seam or an edge that begins where it ends, and that edge."""
    uses = TopTools_IndexedDataMapOfShapeListOfShape()
    faces = index_map(shape, FACE)
    # One walk for all faces, a face between two solids once: an edge has its face twice where that is closed along it.
    TopExp.MapShapesAndAncestors_s(compound(mapped(faces, FACE)), EDGE, FACE, uses)
    found = []
    for j in range(1, uses.Extent() + 1):
        edge, of_edge = typed(uses.FindKey(j), EDGE), uses.FindFromIndex(j)
        if BRep_Tool.Degenerated_s(edge) or not of_edge.Extent():
            continue
        is_between_two = of_edge.Extent() == 2 and not of_edge.First().IsSame(of_edge.Last())
        if is_between_two and not TopExp.FirstVertex_s(edge).IsSame(TopExp.LastVertex_s(edge)):
            continue
        numbers = [faces.FindIndex(face) for face in listed(of_edge)]
        seams = [n for n in numbers if numbers.count(n) > 1]
        if seams or TopExp.FirstVertex_s(edge).IsSame(TopExp.LastVertex_s(edge)):
            found.append((min(seams or numbers) - 1, edge))
    return min(found, key=lambda pair: pair[0], default=None)


def _mend(traced: Traced, old_faces: Any) -> None:
    """Mend the wires of new faces that OpenCASCADE made unlike what it takes for valid itself.

    Every later cut through such a face would be refused for a fault that was there before. What is said of single
    edges, such as the ranges of their curves, was so in the file, and hinders no cut.
    """
    new = [face for face in subshapes(traced.shape, FACE) if not old_faces.Contains(face)]
    doubtful = [face for face in new if not is_valid_apart(face)]
    # All at once, for what they share is looked at once; who is at fault is asked where one is.
    if not doubtful or BRepCheck_Analyzer(compound(doubtful)).IsValid():
        return
    reshape = BRepTools_ReShape()
    found = False
    for face in doubtful:
        if _is_sound(face):
            continue
        fix = ShapeFix_Face(face)
        fix.Perform()  # in place, or by another face of the same edges
        mended = fix.Face()
        if not mended.IsSame(face) and BRepCheck_Analyzer(mended).IsValid():
            reshape.Replace(face.Oriented(TopAbs_Orientation.TopAbs_FORWARD), _as_forward(mended, face))
            found = True
    if found:
        traced.replace(reshape.Apply(traced.shape), reshape.Apply)


def _is_sound(face: Any) -> bool:
    """Whether OpenCASCADE finds no fault with a face as a whole, such as wires that do not bound it."""
    checked = BRepCheck_Analyzer(face)
    return checked.IsValid() or all(s == BRepCheck_Status.BRepCheck_NoError for s in checked.Result(face).Status())


def _as_forward(mended: Any, face: Any) -> Any:
    """A replacement of a face, turned as that is when it stands forward."""
    is_turned = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
    return mended.Reversed() if is_turned else mended


def _refuse_closed(closed: tuple[int, Any] | None) -> None:
    """Refuse a shape with a face or an edge that is still closed."""
    if closed is not None:
        number, edge = closed
        raise CadError(
            f"face {number} at {place(edge)} is closed upon itself and could not be divided. "
            "Split it in the CAD program, for example by drawing the section in two halves."
        )


def _check_divided(shape: Any, old_faces: Any) -> None:
    """Refuse a shape that dividing has damaged."""
    new_faces = index_map(shape, FACE)
    gone = [f for f in mapped(old_faces, FACE) if not new_faces.Contains(f)]
    come = [f for f in mapped(new_faces, FACE) if not old_faces.Contains(f)]
    before, after = _curved_area(gone), _curved_area(come)
    if abs(after - before) > 1e-3 * before:
        # OpenCASCADE's areas of a flat ellipse's or spline's side differ from its halves' by per cents.
        before, after = (_curved_area(faces, precise=True) for faces in (gone, come))
    if abs(after - before) > 1e-3 * before:
        for number, face in enumerate(mapped(old_faces, FACE)):
            vertex = None if new_faces.Contains(face) else _touched_by_itself(face)
            if vertex is not None:
                p = BRep_Tool.Pnt_s(typed(vertex, VERTEX))
                raise CadError(
                    f"face {number} touches itself at ({p.X():.4g}, {p.Y():.4g}, {p.Z():.4g}), as that of a bore does "
                    "which another one only touches from inside, and cannot be divided there. Move one of the features "
                    "that meet there."
                )
        raise CadError(
            "dividing the closed faces changed the surface, so OpenCASCADE failed at it. "
            "Split closed faces in the CAD program."
        )


def _touched_by_itself(face: Any) -> Any:
    """A vertex that the outlines of a face run through more than once; None where there is none."""
    ends = TopTools_IndexedMapOfShape()
    counts: Counter[int] = Counter()
    for edge, n_uses in _uses(face):
        if n_uses == 1 and not BRep_Tool.Degenerated_s(edge):
            for vertex in (TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)):
                counts[ends.Add(vertex)] += 1
    crowded = [number for number, n in sorted(counts.items()) if n > 2]
    return ends.FindKey(crowded[0]) if crowded else None


def _curved_area(faces: Sequence[Any], *, precise: bool = False) -> float:
    """Area of the faces that can be closed; a plane is not, and the area of one with many holes takes long."""
    total = 0.0
    for face in faces:
        if GeomAdaptor_Surface(BRep_Tool.Surface_s(face)).GetType() != GeomAbs_SurfaceType.GeomAbs_Plane:
            area = measure_closed_area(face) if precise else None
            if area is None:
                properties = GProp_GProps()
                BRepGProp.SurfaceProperties_s(face, properties)
                area = properties.Mass()
            total += area
    return total


def _make_exact(shape: Any, old_edges: Any) -> None:
    """Give every new edge that runs along an isoparametric line the exact curve of that line."""
    builder = BRep_Builder()
    uses = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(shape, EDGE, FACE, uses)
    for edge in subshapes(shape, EDGE):
        if old_edges.Contains(edge) or not _is_spline(edge):
            continue
        iso = _exact_curve(edge, listed(uses.FindFromKey(edge)))
        if iso is not None:
            first, last = space_range(edge)
            builder.UpdateEdge(edge, iso, TopLoc_Location(), BRep_Tool.Tolerance_s(edge))
            builder.Range(edge, first, last, True)


def _exact_curve(edge: Any, faces: Sequence[Any]) -> Any:
    """The parameter line of one of its faces that an edge runs along; None where there is none."""
    curve = BRep_Tool.Curve_s(edge, 0.0, 1.0)
    first, last = space_range(edge)
    tolerance = BRep_Tool.Tolerance_s(edge) + 1e-6
    for face in faces:
        pcurve = BRep_Tool.CurveOnSurface_s(edge, typed(face, FACE), 0.0, 1.0)
        iso = None if pcurve is None else _isoparametric(BRep_Tool.Surface_s(typed(face, FACE)), pcurve)
        # Both curves must run alike in the parameter, or the edge is left as it is.
        at = np.linspace(first, last, 9).tolist()
        if iso is not None and max(iso.Value(t).Distance(curve.Value(t)) for t in at) <= 10 * tolerance:
            return iso
    return None


def _is_spline(edge: Any) -> bool:
    curve = BRep_Tool.Curve_s(edge, 0.0, 1.0)
    return curve is not None and GeomAdaptor_Curve(curve).GetType() == GeomAbs_CurveType.GeomAbs_BSplineCurve


def _align_ranges(shape: Any, old_edges: Any) -> None:
    """Give all curves of every new edge the range of that in space."""
    for edge in subshapes(shape, EDGE):
        if not old_edges.Contains(edge) and not BRep_Tool.SameRange_s(edge):
            BRepLib.SameRange_s(edge)


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
