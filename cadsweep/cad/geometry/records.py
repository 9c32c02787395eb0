"""Curves and surfaces as one array of numbers each, which the compiled loops of ``record_kernels`` take.

Place in the flow: ``face_surface``, ``measure`` and the gaps of ``extract`` evaluate a face and its edges many times at
a handful of parameters; where both have records, each of these questions is one compiled call.

Layout of a curve: kind, dimensions, offset and rate of its parameter, then for a line origin and direction, for a conic
centre and two axes (three numbers each, also in the plane), for a spline degree, number of poles, their width
(one more than the dimensions where rational), period (0: none), knots, poles.

Layout of a surface: kind, period in u and in v (0: none), then for plane, cone and torus origin, x, y, z and two
numbers (radius and half angle; both radii), for a spline degrees, numbers of poles, knots in u and v and homogeneous
poles, for an extruded surface its direction and the curve's record, for a revolved one origin, axis and that record.

Not handled: offsets, and what only OpenCASCADE can evaluate; these have no record, and numpy evaluates them.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from . import parametric, surfaces
from .nurbs import BSpline

LINE, ELLIPSE, HYPERBOLA, PARABOLA, SPLINE = range(5)
PLANE, CONE, TORUS, SPLINE_SURFACE, EXTRUDED, REVOLVED = range(6)


def curve_record(curve: parametric.Parametric) -> FloatArray | None:
    """The record of a curve in space or in the plane; None where it has none."""
    offset, rate = 0.0, 1.0
    while isinstance(curve, parametric.Reparametrised):
        offset, rate = curve.offset + curve.rate * offset, curve.rate * rate
        curve = curve.curve
    if isinstance(curve, parametric.Line):
        return _record([LINE, len(curve.origin), offset, rate], _three(curve.origin), _three(curve.direction))
    for kind, conic, middle in (
        (ELLIPSE, parametric.Ellipse, "center"),
        (HYPERBOLA, parametric.Hyperbola, "center"),
        (PARABOLA, parametric.Parabola, "vertex"),
    ):
        if isinstance(curve, conic):
            origin = getattr(curve, middle)
            axes = (_three(curve.x_axis), _three(curve.y_axis))
            return _record([kind, len(origin), offset, rate], _three(origin), *axes)
    spline, period = (curve.spline, curve.period) if isinstance(curve, parametric.Periodic) else (curve, 0.0)
    if not isinstance(spline, BSpline):
        return None
    knots, poles = spline.arrays
    n, width = poles.shape
    head = [SPLINE, spline.poles.shape[1], offset, rate, spline.degree, n, width, period]
    return _record(head, knots, poles.ravel())


def surface_record(surface: surfaces.Geometry) -> FloatArray | None:
    """The record of a surface; None where it has none."""
    periods = [0.0 if period is None else period for period in surface.periods]
    found = None
    if isinstance(surface, surfaces.Plane):
        found = _record([PLANE, *periods], *_axes(surface.frame), [0.0, 0.0])
    elif isinstance(surface, surfaces.Cone):
        found = _record([CONE, *periods], *_axes(surface.frame), [surface.radius, surface.half_angle])
    elif isinstance(surface, surfaces.Torus):
        found = _record([TORUS, *periods], *_axes(surface.frame), [surface.major, surface.minor])
    elif isinstance(surface, surfaces.Spline):
        u_knots, v_knots, p, q, poles = surface.spline.arrays
        head = [SPLINE_SURFACE, *periods, p, q, poles.shape[0], poles.shape[1]]
        found = _record(head, u_knots, v_knots, poles.ravel())
    elif isinstance(surface, surfaces.Extruded):
        curve = curve_record(surface.curve)
        found = None if curve is None else _record([EXTRUDED, *periods], surface.direction, curve)
    elif isinstance(surface, surfaces.Revolved):
        curve = curve_record(surface.curve)
        found = None if curve is None else _record([REVOLVED, *periods], surface.origin, surface.axis, curve)
    return found


def _record(*parts: object) -> FloatArray:
    return np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])


def _three(vector: FloatArray) -> FloatArray:
    return vector if len(vector) == 3 else np.append(vector, 0.0)


def _axes(frame: surfaces.Frame) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    return frame.origin, frame.x, frame.y, frame.z
