"""Curves and surfaces of OpenCASCADE read into numpy geometries.

Place in the flow: the first half of extraction; ``extract`` adds the topology. Kinds that have no
numpy counterpart (offsets, parabolas, hyperbolas) are called point by point.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from OCP.Geom import (
    Geom_BezierCurve,
    Geom_BSplineCurve,
    Geom_Circle,
    Geom_Ellipse,
    Geom_Line,
    Geom_TrimmedCurve,
)
from OCP.Geom2d import (
    Geom2d_BezierCurve,
    Geom2d_BSplineCurve,
    Geom2d_Circle,
    Geom2d_Ellipse,
    Geom2d_Line,
    Geom2d_TrimmedCurve,
)
from OCP.Geom2dAdaptor import Geom2dAdaptor_Curve
from OCP.Geom2dConvert import Geom2dConvert
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor_Curve, GeomAdaptor_Surface
from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Pnt, gp_Vec

from ...arrays import FloatArray
from . import parametric, surfaces
from .nurbs import BSpline, BSplineSurface
from .packed import CIRCLE, LINE, PackedConic, PackedCurve, unpack_curves, unpack_surface

_C = GeomAbs_CurveType
_S = GeomAbs_SurfaceType
_TRIMMED = (Geom_TrimmedCurve, Geom2d_TrimmedCurve)
_CONICS = (Geom_Line, Geom_Circle, Geom_Ellipse, Geom2d_Line, Geom2d_Circle, Geom2d_Ellipse)
_SPLINES = (Geom_BSplineCurve, Geom2d_BSplineCurve)


class CurveGeometry(NamedTuple):
    """A curve in numpy, its kind in the words of ``brep.Edge``, and where it may be less than smooth."""

    geometry: parametric.Parametric
    kind: str
    breaks: FloatArray
    constant_speed: bool


def read_curve(curve: Any) -> CurveGeometry:
    """Read a ``Geom_Curve``."""
    return read_curves([curve])[0]


def read_curve_2d(curve: Any) -> parametric.Parametric:
    """Read a ``Geom2d_Curve``."""
    return read_curves_2d([curve])[0]


def read_curves(found: Sequence[Any]) -> list[CurveGeometry]:
    """Read every ``Geom_Curve``."""
    return _read_curves(found, 3)


def read_curves_2d(found: Sequence[Any]) -> list[parametric.Parametric]:
    """Read every ``Geom2d_Curve``."""
    return [read.geometry for read in _read_curves(found, 2)]


def _read_curves(found: Sequence[Any], dimension: int) -> list[CurveGeometry]:
    """Lines, conics and splines are read together, each of the others by itself."""
    usual = [_usual(curve) for curve in found]
    packed, numbers = unpack_curves([own[0] for own in usual if own is not None], dimension)
    periods = [own[1] for own in usual if own is not None]
    made = {n: _of_packed(packed[n], period) for n, period in dict(zip(numbers, periods, strict=True)).items()}
    each = iter(numbers)
    return [
        made[next(each)] if own is not None else _read_unusual(curve, dimension)
        for curve, own in zip(found, usual, strict=True)
    ]


def _usual(curve: Any) -> tuple[Any, float | None] | None:
    """The line, conic or open spline that a curve is (a piece of), and its period; None for a curve of another kind."""
    basis = curve
    while isinstance(basis, _TRIMMED):
        basis = basis.BasisCurve()
    if isinstance(basis, _CONICS):
        return basis, None
    if isinstance(basis, Geom_BezierCurve):
        return GeomConvert.CurveToBSplineCurve_s(curve), None
    if isinstance(basis, Geom2d_BezierCurve):
        return Geom2dConvert.CurveToBSplineCurve_s(curve), None
    if not isinstance(basis, _SPLINES):
        return None
    if not basis.IsPeriodic():
        return basis, None
    period = basis.Period()
    basis = basis.Copy()
    basis.SetNotPeriodic()
    return basis, period


def _of_packed(packed: PackedConic | PackedCurve, period: float | None) -> CurveGeometry:
    none = np.empty(0)
    if isinstance(packed, PackedConic):
        if packed.kind == LINE:
            origin, direction = packed.vectors
            return CurveGeometry(parametric.Line(origin=origin, direction=direction), "line", none, True)
        (center, x, y), radii = packed.vectors, packed.radii
        ellipse = parametric.Ellipse(center=center, x_axis=radii[0] * x, y_axis=radii[-1] * y)
        return CurveGeometry(ellipse, "circle" if packed.kind == CIRCLE else "ellipse", none, packed.kind == CIRCLE)
    spline = BSpline(degree=packed.degree, knots=packed.knots, poles=packed.poles, weights=packed.weights)
    if period is None:
        return CurveGeometry(spline, "bspline", spline.breaks, False)
    breaks = np.concatenate([spline.breaks + k * period for k in (-2, -1, 0, 1, 2)])
    return CurveGeometry(parametric.Periodic(spline=spline, period=period), "bspline", np.unique(breaks), False)


def _read_unusual(curve: Any, dimension: int) -> CurveGeometry:
    row = _row3 if dimension == 3 else _row2
    adaptor = GeomAdaptor_Curve(curve) if dimension == 3 else Geom2dAdaptor_Curve(curve)
    if adaptor.GetType() in (_C.GeomAbs_Hyperbola, _C.GeomAbs_Parabola):
        return CurveGeometry(_open_conic(adaptor, row), "other", np.empty(0), False)
    return CurveGeometry(parametric.Called(function=_curve_function(curve, row)), "other", np.empty(0), False)


def _open_conic(adaptor: Any, row: Any) -> parametric.Parametric:
    if adaptor.GetType() == _C.GeomAbs_Hyperbola:
        conic = adaptor.Hyperbola()
        return parametric.Hyperbola(
            center=row(conic.Location()),
            x_axis=conic.MajorRadius() * row(conic.XAxis().Direction()),
            y_axis=conic.MinorRadius() * row(conic.YAxis().Direction()),
        )
    conic = adaptor.Parabola()
    axes = conic.Position() if hasattr(conic, "Position") else conic.Axis()  # in space, in the plane
    return parametric.Parabola(
        vertex=row(axes.Location()),
        x_axis=row(axes.XDirection()) / (4.0 * conic.Focal()),
        y_axis=row(axes.YDirection()),
    )


def _curve_function(curve: Any, row: Any) -> Any:
    def call(parameter: float, order: int) -> tuple[Any, ...]:
        derivatives = tuple(row(curve.DN(parameter, k)) for k in range(1, order + 1))
        return (row(curve.Value(parameter)), *derivatives)

    return call


def read_surface(surface: Any) -> surfaces.Geometry:
    """Read a ``Geom_Surface``."""
    adaptor = GeomAdaptor_Surface(surface)
    kind = adaptor.GetType()
    if kind in _ELEMENTARY:
        return _ELEMENTARY[kind](adaptor)
    while hasattr(surface, "BasisSurface") and kind != _S.GeomAbs_OffsetSurface:
        surface = surface.BasisSurface()  # a trimmed surface
    if kind in _SWEPT:
        return _SWEPT[kind](adaptor, surface)
    if kind == _S.GeomAbs_BSplineSurface:
        return _spline_surface(adaptor.BSpline())
    if kind == _S.GeomAbs_BezierSurface:
        return _spline_surface(GeomConvert.SurfaceToBSplineSurface_s(surface))
    if kind == _S.GeomAbs_OffsetSurface:
        return _offset(surface)
    return surfaces.Called(function=_surface_function(surface), periods=_periods(adaptor))


def distances_from(surface: Any, box: FloatArray) -> Callable[[FloatArray], FloatArray]:
    """OpenCASCADE's own distances (m,) of points (m, 3) from a ``Geom_Surface`` over a box of parameters.

    0.2 ms a point, and infinite where it finds no foot: for the few points that are in doubt.
    """

    def distances(points: FloatArray) -> FloatArray:
        (u0, v0), (u1, v1) = box.tolist()
        found = np.full(len(points), np.inf)
        for i in np.flatnonzero(np.isfinite(points).all(axis=1)):
            feet = GeomAPI_ProjectPointOnSurf(gp_Pnt(*points[i].tolist()), surface, u0, u1, v0, v1)
            if feet.NbPoints():
                found[i] = feet.LowerDistance()
        return found

    return distances


def surface_kind(surface: Any) -> str:
    """The kind of a ``Geom_Surface`` in the words of ``brep.Face``."""
    return _KINDS.get(GeomAdaptor_Surface(surface).GetType(), "other")


def _plane(adaptor: Any) -> surfaces.Geometry:
    return surfaces.Plane(frame=_frame(adaptor.Plane()))


def _cylinder(adaptor: Any) -> surfaces.Geometry:
    cylinder = adaptor.Cylinder()
    return surfaces.Cone(frame=_frame(cylinder), radius=cylinder.Radius())


def _cone(adaptor: Any) -> surfaces.Geometry:
    cone = adaptor.Cone()
    return surfaces.Cone(frame=_frame(cone), radius=cone.RefRadius(), half_angle=cone.SemiAngle())


def _sphere(adaptor: Any) -> surfaces.Geometry:
    sphere = adaptor.Sphere()
    periods = (surfaces.TWO_PI, None)
    return surfaces.Torus(frame=_frame(sphere), major=0.0, minor=sphere.Radius(), periods=periods)


def _torus(adaptor: Any) -> surfaces.Geometry:
    torus = adaptor.Torus()
    return surfaces.Torus(frame=_frame(torus), major=torus.MajorRadius(), minor=torus.MinorRadius())


def _extruded(adaptor: Any, surface: Any) -> surfaces.Geometry:
    basis = read_curve(surface.BasisCurve()).geometry
    periods = (adaptor.UPeriod() if adaptor.IsUPeriodic() else None, None)
    return surfaces.Extruded(curve=basis, direction=_row3(surface.Direction()), periods=periods)


def _revolved(adaptor: Any, surface: Any) -> surfaces.Geometry:
    basis = read_curve(surface.BasisCurve()).geometry
    axis = surface.Axis()
    revolved = surfaces.Revolved(
        curve=basis,
        origin=_row3(axis.Location()),
        axis=_row3(axis.Direction()),
        periods=(surfaces.TWO_PI, adaptor.VPeriod() if adaptor.IsVPeriodic() else None),
    )
    return revolved


def _offset(surface: Any) -> surfaces.Geometry:
    while not hasattr(surface, "Offset"):
        surface = surface.BasisSurface()
    basis = read_surface(surface.BasisSurface())
    u0, u1, v0, v1 = surface.Bounds()
    widths = [width if width < 1e6 else 1.0 for width in (u1 - u0, v1 - v0)]
    return surfaces.Offset(basis=basis, distance=surface.Offset(), step=(1e-5 * widths[0], 1e-5 * widths[1]))


_ELEMENTARY = {
    _S.GeomAbs_Plane: _plane,
    _S.GeomAbs_Cylinder: _cylinder,
    _S.GeomAbs_Cone: _cone,
    _S.GeomAbs_Sphere: _sphere,
    _S.GeomAbs_Torus: _torus,
}
_KINDS = {
    _S.GeomAbs_Plane: "plane",
    _S.GeomAbs_Cylinder: "cylinder",
    _S.GeomAbs_Cone: "cone",
    _S.GeomAbs_Sphere: "sphere",
    _S.GeomAbs_Torus: "torus",
    _S.GeomAbs_SurfaceOfExtrusion: "extrusion",
    _S.GeomAbs_SurfaceOfRevolution: "revolution",
    _S.GeomAbs_BSplineSurface: "bspline",
    _S.GeomAbs_BezierSurface: "bspline",
}
_SWEPT = {_S.GeomAbs_SurfaceOfExtrusion: _extruded, _S.GeomAbs_SurfaceOfRevolution: _revolved}


def _periods(surface: Any) -> surfaces.Periods:
    return (
        surface.UPeriod() if surface.IsUPeriodic() else None,
        surface.VPeriod() if surface.IsVPeriodic() else None,
    )


def _spline_surface(surface: Any) -> surfaces.Spline:
    periods = _periods(surface)
    if periods != (None, None):
        surface = surface.Copy()
        if periods[0] is not None:
            surface.SetUNotPeriodic()
        if periods[1] is not None:
            surface.SetVNotPeriodic()
    degrees, u_knots, v_knots, poles, weights = unpack_surface(surface)
    spline = BSplineSurface(degrees=degrees, u_knots=u_knots, v_knots=v_knots, poles=poles, weights=weights)
    return surfaces.Spline(spline=spline, periods=periods)


def _surface_function(surface: Any) -> Any:
    point, by_u, by_v = gp_Pnt(), gp_Vec(), gp_Vec()

    def call(u: float, v: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        surface.D1(u, v, point, by_u, by_v)
        return _row3(point), _row3(by_u), _row3(by_v)

    return call


def _frame(elementary: Any) -> surfaces.Frame:
    position = elementary.Position()
    return surfaces.Frame(
        origin=_row3(position.Location()),
        x=_row3(position.XDirection()),
        y=_row3(position.YDirection()),
        z=_row3(position.Direction()),
    )


def _row3(p: Any) -> FloatArray:
    return np.array([p.X(), p.Y(), p.Z()])


def _row2(p: Any) -> FloatArray:
    return np.array([p.X(), p.Y()])
