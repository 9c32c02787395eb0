"""Faces on turned and extruded lines and circles that are cylinders, cones, spheres, tori or planes get these surfaces.

Place in the flow: part of healing. Some programs write every turned face as a surface of revolution; whatever parts a
solid asks for axes and radii, which such a face has without saying so.

Method: the elementary surface is laid so that its parameters are those of the swept one, but for a shift of the second,
so that the edges keep their curves in them. (OpenCASCADE's ``ShapeCustom_SweptToElementary`` ends the process on some
faces with seams.)

Not handled: turned lines square to the axis, whose parameters are polar. Splines are :mod:`.canonical`'s.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepTools import BRepTools
from OCP.Geom import (
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Plane,
    Geom_SphericalSurface,
    Geom_ToroidalSurface,
)
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor_Surface
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt

from ...arrays import FloatArray
from ..shapes import FACE, bounds, subshapes, typed
from .shared_surfaces import change_surface
from .tracing import Traced

ALONG = 1e-9
"""Sine of the angle up to which two directions are one, or square to each other."""
SAME = 1e-8
"""Distance, as a share of the shape's size, up to which two surfaces are one."""


def make_elementary(traced: Traced) -> list[str]:
    """Give faces on swept lines and circles their elementary surfaces, in a copy; return a note on how many."""
    found = [(face, _elementary(face)) for face in subshapes(traced.shape, FACE)]
    if not any(made for _, made in found):
        return []
    near = SAME * float(np.linalg.norm(np.diff(bounds(traced.shape), axis=0)))
    chosen = [(face, *made) for face, made in found if made is not None and _is_same(face, *made, near)]
    if not chosen:
        return []
    tool = BRepBuilderAPI_Copy(traced.shape)
    for face, surface, shift in chosen:
        change_surface(typed(tool.ModifiedShape(face), FACE), surface, partial(_along_second, shift))
    traced.replace(tool.Shape(), tool.ModifiedShape)
    return [f"{len(chosen)} swept faces are cylinders, cones, spheres, tori or planes, and read as these"]


def _along_second(shift: float, _: tuple[float, float]) -> tuple[float, float]:
    return 0.0, shift


def _elementary(face: Any) -> tuple[Any, float] | None:
    """The elementary surface of a swept face, and by how much its second parameter is more; None where it has none."""
    adaptor = GeomAdaptor_Surface(BRep_Tool.Surface_s(face))
    kind = adaptor.GetType()
    if kind not in {GeomAbs_SurfaceType.GeomAbs_SurfaceOfRevolution, GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion}:
        return None
    curve = adaptor.BasisCurve()
    basis = curve.GetType()
    if kind == GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion:
        way = _array(adaptor.Direction())
        if basis == GeomAbs_CurveType.GeomAbs_Line:
            return _extruded_line(curve.Line(), way)
        return _extruded_circle(curve.Circle(), way) if basis == GeomAbs_CurveType.GeomAbs_Circle else None
    axis = adaptor.AxeOfRevolution()
    place, way = _array(axis.Location()), _array(axis.Direction())
    if basis == GeomAbs_CurveType.GeomAbs_Line:
        return _turned_line(curve.Line(), place, way)
    if basis != GeomAbs_CurveType.GeomAbs_Circle:
        return None
    *_, low, high = BRepTools.UVBounds_s(face)
    return _turned_circle(curve.Circle(), place, way, 0.5 * (low + high))


def _extruded_line(line: Any, way: FloatArray) -> tuple[Any, float] | None:
    along = _array(line.Direction())
    normal = np.cross(along, way)
    if float(np.linalg.norm(normal)) < ALONG:
        return None
    return Geom_Plane(_frame(_array(line.Location()), normal, along)), 0.0


def _extruded_circle(circle: Any, way: FloatArray) -> tuple[Any, float] | None:
    x, y = _array(circle.XAxis().Direction()), _array(circle.YAxis().Direction())
    if max(abs(float(x @ way)), abs(float(y @ way))) > ALONG:
        return None
    return Geom_CylindricalSurface(_frame(_array(circle.Location()), way, x, y), circle.Radius()), 0.0


def _turned_line(line: Any, place: FloatArray, way: FloatArray) -> tuple[Any, float] | None:
    """A line along the axis, or one that meets it, at its first parameter's distance from the axis."""
    start, along = _array(line.Location()), _array(line.Direction())
    foot = place + ((start - place) @ way) * way
    aside, rise = start - foot, float(along @ way)
    radius = float(np.linalg.norm(aside))
    out = along - rise * way
    slope = float(np.linalg.norm(out))
    if slope < ALONG:
        if radius < ALONG:
            return None
        x = aside / radius
        return Geom_CylindricalSurface(_frame(foot, rise * way, x, np.cross(way, x)), radius), 0.0
    x = aside / radius if radius > ALONG else out / slope
    outward = float(out @ x)
    if slope - abs(outward) > ALONG or abs(rise) < ALONG:  # a hyperboloid, or a plane
        return None
    frame = _frame(foot, rise * way, x, np.cross(way, x))
    return Geom_ConicalSurface(frame, float(np.arctan2(outward, abs(rise))), radius), 0.0


def _turned_circle(circle: Any, place: FloatArray, way: FloatArray, middle: float) -> tuple[Any, float] | None:
    """A circle in a plane with the axis; its parameter, `middle` on the face, counts from where it is farthest out."""
    center, radius = _array(circle.Location()), circle.Radius()
    x, y = _array(circle.XAxis().Direction()), _array(circle.YAxis().Direction())
    normal = np.cross(x, y)
    foot = place + ((center - place) @ way) * way
    aside = center - foot
    major = float(np.linalg.norm(aside))
    if abs(float(normal @ way)) > ALONG or abs(float(normal @ aside)) > ALONG * max(major, radius):
        return None
    is_sphere = major < ALONG * radius
    out = np.cross(way, normal) if is_sphere else aside / major
    if is_sphere and float((np.cos(middle) * x + np.sin(middle) * y) @ out) < 0.0:
        out = -out  # the other half of the circle is turned
    first = float(np.arctan2(out @ y, out @ x))
    shift = float(np.angle(np.exp(1j * (middle - first)))) - middle
    frame = _frame(foot, np.cos(first) * y - np.sin(first) * x, out, np.cross(way, out))
    if is_sphere:
        return Geom_SphericalSurface(frame, radius), shift
    # A circle that reaches its axis, by rounding maybe, turns into a surface with poles, and no ring.
    return (Geom_ToroidalSurface(frame, major, radius), shift) if major > radius else None


def _is_same(face: Any, surface: Any, shift: float, near: float) -> bool:
    """Whether a surface has a face's places at the same parameters; those of a plane are not kept."""
    if isinstance(surface, Geom_Plane):
        return True
    own = BRep_Tool.Surface_s(face)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    pairs = [(float(u), float(v)) for u in np.linspace(u0, u1, 5) for v in np.linspace(v0, v1, 5)]
    return all(own.Value(u, v).Distance(surface.Value(u, v + shift)) < near for u, v in pairs)


def _frame(place: FloatArray, z: FloatArray, x: FloatArray, y: FloatArray | None = None) -> gp_Ax3:
    """A frame, left-handed where `y` asks for it."""
    frame = gp_Ax3(gp_Pnt(*map(float, place)), gp_Dir(*map(float, z)), gp_Dir(*map(float, x)))
    if y is not None and float(_array(frame.YDirection()) @ y) < 0.0:
        frame.YReverse()
    return frame


def _array(thing: Any) -> FloatArray:
    return np.array([thing.X(), thing.Y(), thing.Z()])
