"""Curves and splines read at once hold what OpenCASCADE says of every pole and knot."""

import numpy as np
import pytest
from OCP.Geom import (
    Geom_Circle,
    Geom_CylindricalSurface,
    Geom_Ellipse,
    Geom_Hyperbola,
    Geom_Line,
    Geom_RectangularTrimmedSurface,
    Geom_TrimmedCurve,
)
from OCP.Geom2d import Geom2d_Circle, Geom2d_Ellipse, Geom2d_Hyperbola, Geom2d_Line, Geom2d_TrimmedCurve
from OCP.Geom2dAPI import Geom2dAPI_PointsToBSpline
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax2, gp_Ax2d, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array1OfPnt2d

from cadsweep.cad.geometry.convert import read_curve, read_curve_2d, read_curves, read_curves_2d
from cadsweep.cad.geometry.packed import unpack_curves, unpack_surface

PLACES = np.random.default_rng(3).standard_normal((9, 3)).cumsum(axis=0)


def curve_through(dimension):
    array, point, fit = {
        2: (TColgp_Array1OfPnt2d, gp_Pnt2d, Geom2dAPI_PointsToBSpline),
        3: (TColgp_Array1OfPnt, gp_Pnt, GeomAPI_PointsToBSpline),
    }[dimension]
    points = array(1, len(PLACES))
    for j, place in enumerate(PLACES.tolist(), 1):
        points.SetValue(j, point(*place[:dimension]))
    return fit(points).Curve()


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("rational", [False, True])
def test_curve_has_every_pole_weight_and_knot(dimension, rational):
    curve = curve_through(dimension)
    if rational:
        curve.SetWeight(2, 1.7)
    [read], numbers = unpack_curves([curve, curve], dimension)
    assert numbers == [0, 0]
    assert read.degree == curve.Degree()
    assert read.knots.tolist() == list(curve.KnotSequence())
    assert read.poles.tolist() == [list(curve.Pole(j).Coord())[:dimension] for j in range(1, curve.NbPoles() + 1)]
    weights = [curve.Weight(j) for j in range(1, curve.NbPoles() + 1)]
    assert (read.weights is None) if not rational else (read.weights.tolist() == weights)


@pytest.mark.parametrize("rational", [False, True])
def test_surface_has_every_pole_weight_and_knot(rational):
    cylinder = Geom_CylindricalSurface(gp_Ax3(), 2.0)
    surface = GeomConvert.SurfaceToBSplineSurface_s(Geom_RectangularTrimmedSurface(cylinder, 0.1, 2.9, -1.0, 5.0))
    surface.InsertVKnot(2.0, 1, 0.0)
    n_u, n_v = surface.NbUPoles(), surface.NbVPoles()
    if not rational:
        for i in range(1, n_u + 1):
            for j in range(1, n_v + 1):
                surface.SetWeight(i, j, 1.0)
    read = unpack_surface(surface)
    assert read.degrees == (surface.UDegree(), surface.VDegree())
    assert read.u_knots.tolist() == list(surface.UKnotSequence())
    assert read.v_knots.tolist() == list(surface.VKnotSequence())
    pairs = [(i, j) for i in range(1, n_u + 1) for j in range(1, n_v + 1)]
    assert read.poles.reshape(-1, 3).tolist() == [list(surface.Pole(i, j).Coord()) for i, j in pairs]
    assert (
        (read.weights is None)
        if not rational
        else (read.weights.ravel().tolist() == [surface.Weight(i, j) for i, j in pairs])
    )


@pytest.mark.parametrize("dimension", [2, 3])
def test_many_curves_at_once_are_those_one_by_one(dimension):
    if dimension == 3:
        frame = gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(1, 2, 2))
        circle = Geom_Circle(frame, 7.0)
        others = [
            Geom_Line(gp_Pnt(3, 1, 2), gp_Dir(0, 1, 1)),
            Geom_Ellipse(frame, 7.0, 3.0),
            Geom_Hyperbola(frame, 2.0, 3.0),
        ]
        piece, one, many = Geom_TrimmedCurve(circle, 0.5, 1.5), read_curve, read_curves
    else:
        axis = gp_Ax2d(gp_Pnt2d(1, 2), gp_Dir2d(3, 4))
        circle = Geom2d_Circle(axis, 7.0)
        others = [Geom2d_Line(axis), Geom2d_Ellipse(axis, 7.0, 3.0), Geom2d_Hyperbola(axis, 2.0, 3.0, True)]
        piece, one, many = Geom2d_TrimmedCurve(circle, 0.5, 1.5), read_curve_2d, read_curves_2d
    curves = [circle, curve_through(dimension), *others, piece, circle]
    at = np.linspace(0.1, 0.9, 5)
    for curve, read in zip(curves, many(curves), strict=True):
        geometry, alone = (getattr(found, "geometry", found) for found in (read, one(curve)))
        for values, known in zip(geometry.derivatives(at, 2), alone.derivatives(at, 2), strict=True):
            np.testing.assert_array_equal(values, known)
        places = [curve.Value(float(t)).Coord() for t in at]
        np.testing.assert_allclose(geometry.derivatives(at)[0], places, atol=1e-12)
