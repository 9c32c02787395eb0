"""Faces on splines that are elementary, or of revolution, get these surfaces, and their edges true curves.

Place in the flow: part of healing, before :mod:`.elementary`. Some programs write every face as a B-spline; whatever
parts a solid, stacks layers or turns about an axis asks for planes and radii, which such faces have without saying so.

Method: points and normals of a face tell what it is (:mod:`..geometry.elementary_fit`), to a tolerance that is that of
the file. Edges between such faces that are straight or circular get lines and circles. Curves in the parameters of the
new surfaces are made by projection, as for a file that has none. All of it is done in a copy, which is taken only where
it is one valid solid with the same faces, which hold the same places. (Its volume tells nothing:
OpenCASCADE's integrals over splines are some per cent off.)

A solid of which some faces are elementary in the file, and a spline is not, stays as it is: it was drawn so, and
parameters of what its splines share would have to follow. In one that has nothing but splines and is round somewhere,
as some programs write all they have, those that are something else are read as that.

Not handled: ellipses; surfaces of extrusion.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import takewhile
from math import pi
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepClass import BRepClass_FaceClassifier
from OCP.BRepTools import BRepTools
from OCP.Geom import (
    Geom_Circle,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Line,
    Geom_Plane,
    Geom_SphericalSurface,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
    Geom_TrimmedCurve,
)
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor_Surface
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt, gp_Pnt2d, gp_Vec
from OCP.ShapeBuild import ShapeBuild_Edge
from OCP.ShapeFix import ShapeFix_Edge, ShapeFix_Shape
from OCP.TopAbs import TopAbs_State
from OCP.TopLoc import TopLoc_Location
from OCP.TopTools import TopTools_IndexedMapOfShape

from ...arrays import BoolArray, FloatArray
from ..geometry.elementary_fit import Elementary, fit_axis, fit_elementary, fit_sphere, regular
from ..shapes import EDGE, FACE, SOLID, bounds, explore, index_map, mapped, space_range, subshapes, typed
from ..trial import attempted
from .tracing import Traced
from .validate import faults

NEAR = 1e-8
"""Distance, as a share of the shape's size, up to which a face or edge is an elementary one, whatever its tolerance."""
FAR = 1e-5
"""The same, above which it is not, whatever its tolerance: that is as near as loose faces are sewn."""
_SPLINES = (
    GeomAbs_SurfaceType.GeomAbs_BSplineSurface,
    GeomAbs_SurfaceType.GeomAbs_BezierSurface,
    GeomAbs_SurfaceType.GeomAbs_OffsetSurface,
)
_SPLINE_CURVES = (
    GeomAbs_CurveType.GeomAbs_BSplineCurve,
    GeomAbs_CurveType.GeomAbs_BezierCurve,
    GeomAbs_CurveType.GeomAbs_OffsetCurve,
)
_SURFACES = {
    "cylinder": Geom_CylindricalSurface,
    "sphere": Geom_SphericalSurface,
    "cone": Geom_ConicalSurface,
    "torus": Geom_ToroidalSurface,
}
_FREE = (*_SPLINES, GeomAbs_SurfaceType.GeomAbs_SurfaceOfRevolution, GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion)
"""Faces whose parameters follow the parameters of the curves that bound them."""
_PLACES = np.array([0.09, 0.37, 0.61, 0.93])
"""Where in the box of its parameters a face is looked at, before and after."""
_N_FIRST = 4
"""Samples of a face in each of its parameters to begin with."""
_N_ACROSS = 9
"""Samples of a face in each of its parameters, and of an edge."""


def make_canonical(traced: Traced) -> list[str]:
    """Give spline faces that are elementary, or of revolution, their surfaces, in a copy; return a note on how many."""
    size = float(np.linalg.norm(np.diff(bounds(traced.shape), axis=0)))
    faces = subshapes(traced.shape, FACE)
    splines = [face for face in faces if _is_spline(face)]
    tried: Iterable[tuple[Any, Any | None]] = ((face, _surface(face, size)) for face in splines)
    # The flat side of a loft is one of a kind with its bent ones: their parameters go together, as they were drawn. A
    # file that has nothing but splines, and round ones among them, was drawn otherwise.
    if len(splines) < len(faces):
        tried = takewhile(lambda own: own[1] is not None, tried)
    known = [own for own in tried if own[1] is not None]
    was_converted = len(splines) == len(faces) and any(not isinstance(surface, Geom_Plane) for _, surface in known)
    if not known or not (was_converted or len(known) == len(splines)):
        return []
    tool = BRepBuilderAPI_Copy(traced.shape)
    shape = tool.Shape()
    found = [(typed(tool.ModifiedShape(face), FACE), surface) for face, surface in known]
    inner = [_inner_places(face) for face, _ in found]
    for face, _ in found:
        _drop_parameter_curves(face, explore(face, EDGE))
    for face, surface in found:
        BRep_Builder().UpdateFace(face, surface, TopLoc_Location(), BRep_Tool.Tolerance_s(face))
    _make_true(shape, size, [face for face, _ in found])
    for face, _ in found:
        _add_parameter_curves(face, explore(face, EDGE))
    repair = ShapeFix_Shape(shape)
    if not attempted(repair.Perform, "reading splines as what they are"):
        return []
    solids = subshapes(repair.Shape(), SOLID)
    if len(solids) != 1 or len(subshapes(solids[0], FACE)) != len(subshapes(shape, FACE)) or faults(solids[0]):
        return []
    now = [typed(repair.Context().Apply(face), FACE) for face, _ in found]
    if not all(_lie_in(face, *places) for face, places in zip(now, inner, strict=True)):
        return []
    within = {kind: index_map(traced.shape, kind) for kind in (FACE, EDGE)}  # of loose edges there are no copies
    traced.replace(shape, lambda sub: tool.ModifiedShape(sub) if within[sub.ShapeType()].Contains(sub) else sub)
    traced.replace(solids[0], repair.Context().Apply)
    its = "1 spline face is a plane, a cylinder or another surface of revolution, and read as that"
    more = f"{len(found)} spline faces are planes, cylinders or other surfaces of revolution, and read as these"
    return [more if len(found) > 1 else its]


def _is_spline(face: Any) -> bool:
    """Whether a face is on a spline."""
    return GeomAdaptor_Surface(BRep_Tool.Surface_s(face)).GetType() in _SPLINES


def _surface(face: Any, size: float) -> Any | None:
    """The elementary surface of a spline face, its normals to the same side; None where it has none."""
    own = BRep_Tool.Surface_s(face)
    edges = list(explore(face, EDGE))
    near = min(max(NEAR * size, *(BRep_Tool.Tolerance_s(edge) for edge in edges)), FAR * size)
    seen = _fitted(own, BRepTools.UVBounds_s(face), near)
    if seen is None:
        return _revolved(own, BRepTools.UVBounds_s(face), near)
    found, points, normals, clear = seen
    seams = [edge for j, edge in enumerate(edges) if any(edge.IsSame(other) for other in edges[:j])]
    if found.kind == "plane":
        axis = found.axis if found.axis @ normals[0] > 0.0 else -found.axis
        return None if seams else Geom_Plane(_frame(found.place, axis))
    if found.kind == "sphere":
        found = found._replace(axis=_pole(found.place, points, clear))
    middle = points[len(points) // 2]
    start = next((place for seam in seams if (place := _on_meridian(seam, found)) is not None), None)
    begin = _out(middle, found)
    begin = -begin if start is None else _out(start, found)
    sense = float(normals[0] @ _outward(points[clear][0], found))
    if found.kind == "cone":
        height = float((middle - found.place) @ found.axis)
        found = found._replace(
            place=found.place + height * found.axis, sizes=(found.sizes[0], height * np.tan(found.sizes[0]))
        )
    return _SURFACES[found.kind](_frame(found.place, found.axis, begin, left_handed=sense < 0.0), *found.sizes)


def _fitted(
    surface: Any, box: Sequence[float], near: float
) -> tuple[Elementary, FloatArray, FloatArray, BoolArray] | None:
    """What a surface is over a box of its parameters; points of it, normals at those that have one, and which have."""
    found = None
    for n in (_N_FIRST, _N_ACROSS):  # most free-form faces are told by a few places
        points, normals = _samples(surface, box, n)
        clear = regular(normals)
        if not clear.any():
            return None
        unit = normals[clear] / np.linalg.norm(normals[clear], axis=1)[:, None]
        found = fit_elementary(points[clear], unit, near)
        if found is None:
            break
    return None if found is None else (found, points, unit, clear)


def _revolved(surface: Any, box: Sequence[float], near: float) -> Any | None:
    """The surface of revolution that a spline is over a box of its parameters; None where it is none."""
    for n in (_N_FIRST, _N_ACROSS):
        points, normals = _samples(surface, box, n)
        clear = regular(normals)
        unit = normals[clear] / np.linalg.norm(normals[clear], axis=1)[:, None]
        center, extent = points.mean(axis=0), float(np.ptp(points, axis=0).max())
        found = fit_axis((points[clear] - center) / extent, unit) if clear.any() and extent > 0.0 else None
        if found is None:
            return None
        place, axis = center + extent * found[0], found[1]
        along = ((points - place) @ axis).reshape(n, n)
        out = np.linalg.norm(points - place - along.reshape(-1, 1) * axis, axis=1).reshape(n, n)
        around = next((k for k in (0, 1) if max(np.ptp(along, axis=k).max(), np.ptp(out, axis=k).max()) < near), None)
        if around is None:
            return None
    u0, u1, v0, v1 = box
    iso, ends = (surface.UIso(0.5 * (u0 + u1)), (v0, v1)) if around == 0 else (surface.VIso(0.5 * (v0 + v1)), (u0, u1))
    line = gp_Ax1(gp_Pnt(*place.tolist()), gp_Dir(*axis.tolist()))
    # Angles count from opposite of the middle of the face, which is where a closed one begins.
    meridian = Geom_TrimmedCurve(iso, *ends)
    meridian.Rotate(line, pi)
    made = Geom_SurfaceOfRevolution(meridian, line)
    there = normals.reshape(n, n, 3)[n // 2, n // 2]
    own = _samples(made, (pi, pi, *ends), n)[1].reshape(n, n, 3)[0, n // 2]
    return made if own @ there > 0.0 else Geom_SurfaceOfRevolution(meridian, line.Reversed())


def _pole(center: FloatArray, points: FloatArray, clear: BoolArray) -> FloatArray:
    """Direction from a sphere's centre to a pole of its face: a degenerate point, or the axis of a closed row."""
    if not clear.all():
        return _unit(points[~clear][0] - center)
    grid = points.reshape(_N_ACROSS, _N_ACROSS, 3)
    rows = (grid[:, _N_ACROSS // 2], grid[_N_ACROSS // 2])
    row = min(rows, key=lambda row: float(np.linalg.norm(row[0] - row[-1])))
    return np.asarray(np.linalg.svd(row - row.mean(axis=0))[2][2])


def _out(place: FloatArray, found: Elementary) -> FloatArray:
    """Unit vector away from the axis at a place."""
    offset = place - found.place
    return _unit(offset - (offset @ found.axis) * found.axis)


def _outward(place: FloatArray, found: Elementary) -> FloatArray:
    """The normal that OpenCASCADE gives such a surface in a right-handed frame, or what has its sign."""
    if found.kind == "sphere":
        return place - found.place
    if found.kind == "torus":
        return place - found.place - found.sizes[0] * _out(place, found)
    return _out(place, found)


def _on_meridian(edge: Any, found: Elementary) -> FloatArray | None:
    """The middle of an edge that lies in a half plane with the axis; None for others."""
    curve = BRepAdaptor_Curve(edge)
    places = [_array(curve.Value(t)) for t in np.linspace(*space_range(edge), 5).tolist()[1:-1]]
    outs = [_out(place, found) for place in places]
    return places[1] if min(float(outs[1] @ outs[0]), float(outs[1] @ outs[2])) > 1.0 - 1e-9 else None


def _inner_places(face: Any) -> tuple[list[Any], list[Any]]:
    """Places of a face's surface on the face, and such as are off it, within the box of its parameters."""
    surface = BRep_Tool.Surface_s(face)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    on: list[Any] = []
    off: list[Any] = []
    states = {TopAbs_State.TopAbs_IN: on, TopAbs_State.TopAbs_OUT: off}
    for u in (u0 + (u1 - u0) * _PLACES).tolist():
        for v in (v0 + (v1 - v0) * _PLACES).tolist():
            state = BRepClass_FaceClassifier(face, gp_Pnt2d(u, v), BRep_Tool.Tolerance_s(face)).State()
            if state in states:
                states[state].append(surface.Value(u, v))
    return on, off


def _lie_in(face: Any, on: Sequence[Any], off: Sequence[Any]) -> bool:
    """Whether a face holds the first places, and none of the others."""
    near = BRep_Tool.Tolerance_s(face)

    def state(place: Any) -> Any:
        return BRepClass_FaceClassifier(face, place, near).State()

    return all(state(place) != TopAbs_State.TopAbs_OUT for place in on) and all(
        state(place) != TopAbs_State.TopAbs_IN for place in off
    )


def _make_true(shape: Any, size: float, found: Sequence[Any]) -> None:
    """Give spline edges between elementary faces and those `found`, in place, lines and circles where they are that."""
    faces = subshapes(shape, FACE)
    edges = index_map(shape, EDGE)
    replaced = TopTools_IndexedMapOfShape()
    for face in found:
        replaced.Add(face)
    beside: list[list[Any]] = [[] for _ in range(edges.Extent())]
    for face in faces:
        for edge in explore(face, EDGE):
            if number := edges.FindIndex(edge):
                beside[number - 1].append(face)
    for edge, own in zip(mapped(edges, EDGE), beside, strict=True):
        others = (BRep_Tool.Surface_s(face) for face in own if not replaced.Contains(face))
        if any(GeomAdaptor_Surface(other).GetType() in _FREE for other in others):
            continue
        if BRepAdaptor_Curve(edge).GetType() not in _SPLINE_CURVES:
            continue
        true = _true_curve(edge, size)
        if true is None:
            continue
        curve, last = true
        for face in own:
            _drop_parameter_curves(face, [edge])
        builder = BRep_Builder()
        builder.UpdateEdge(edge, curve, TopLoc_Location(), BRep_Tool.Tolerance_s(edge))
        builder.Range(edge, 0.0, last)
        for face in own:
            _add_parameter_curves(face, [edge])


def _true_curve(edge: Any, size: float) -> tuple[Any, float] | None:
    """The line or circle that a spline edge is, and its last parameter, the first being 0; None where it is neither."""
    curve = BRepAdaptor_Curve(edge)
    places = np.array([_array(curve.Value(t)) for t in np.linspace(*space_range(edge), 2 * _N_ACROSS).tolist()])
    near = min(max(NEAR * size, BRep_Tool.Tolerance_s(edge)), FAR * size)
    first, last = places[0], places[-1]
    length = float(np.linalg.norm(last - first))
    if length > near:
        along = (last - first) / length
        offsets = places - first
        if float(np.linalg.norm(offsets - np.outer(offsets @ along, along), axis=1).max()) < near:
            return Geom_Line(gp_Pnt(*first.tolist()), gp_Dir(*along.tolist())), length
    mean = places.mean(axis=0)
    across = np.linalg.svd(places - mean)[2]
    if float(np.abs((places - mean) @ across[2]).max()) > near:
        return None
    middle, radius = fit_sphere(places @ across[:2].T)
    center = across[:2].T @ middle + (mean @ across[2]) * across[2]
    if float(np.abs(np.linalg.norm(places - center, axis=1) - radius).max()) > near:
        return None
    x = _unit(first - center)
    turn = np.cross(x, places[1] - center)
    z = across[2] if across[2] @ turn > 0.0 else -across[2]
    angle = float(np.arctan2((last - center) @ np.cross(z, x), (last - center) @ x)) % (2.0 * pi)
    closed = BRep_Tool.IsClosed_s(edge)
    frame = gp_Ax2(gp_Pnt(*center.tolist()), gp_Dir(*z.tolist()), gp_Dir(*x.tolist()))
    return Geom_Circle(frame, radius), 2.0 * pi if closed else angle


def _drop_parameter_curves(face: Any, edges: Iterable[Any]) -> None:
    for edge in edges:
        ShapeBuild_Edge().RemovePCurve(edge, face)


def _add_parameter_curves(face: Any, edges: Iterable[Any]) -> None:
    """Curves in the parameters of a face for edges that have none there; on a plane they need none."""
    if isinstance(BRep_Tool.Surface_s(face), Geom_Plane):
        return
    of_face = list(explore(face, EDGE))
    for edge in edges:
        if not BRep_Tool.Degenerated_s(edge):
            is_seam = sum(edge.IsSame(other) for other in of_face) > 1
            ShapeFix_Edge().FixAddPCurve(edge, face, is_seam, BRep_Tool.Tolerance_s(edge))


def _samples(surface: Any, box: Sequence[float], n: int) -> tuple[FloatArray, FloatArray]:
    """Points of a surface and its normals (n, 3) over a box of its parameters, of any length."""
    u0, u1, v0, v1 = box
    points, normals = [], []
    place, along, across = gp_Pnt(), gp_Vec(), gp_Vec()
    for u in np.linspace(u0, u1, n).tolist():
        for v in np.linspace(v0, v1, n).tolist():
            surface.D1(u, v, place, along, across)
            points.append(_array(place))
            normals.append(_array(along.Crossed(across)))
    return np.array(points), np.array(normals)


def _frame(place: FloatArray, z: FloatArray, x: FloatArray | None = None, *, left_handed: bool = False) -> gp_Ax3:
    frame = gp_Ax3(gp_Pnt(*place.tolist()), gp_Dir(*z.tolist()))
    if x is not None:
        frame = gp_Ax3(gp_Pnt(*place.tolist()), gp_Dir(*z.tolist()), gp_Dir(*x.tolist()))
    if left_handed:
        frame.YReverse()
    return frame


def _unit(vector: FloatArray) -> FloatArray:
    return vector / float(np.linalg.norm(vector))


def _array(thing: Any) -> FloatArray:
    return np.array([thing.X(), thing.Y(), thing.Z()])
