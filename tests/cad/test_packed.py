"""Splines read at once hold what OpenCASCADE says of every pole and knot."""

import numpy as np
import pytest
from OCP.Geom import Geom_CylindricalSurface, Geom_RectangularTrimmedSurface
from OCP.Geom2dAPI import Geom2dAPI_PointsToBSpline
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax3, gp_Pnt, gp_Pnt2d
from OCP.TColgp import TColgp_Array1OfPnt, TColgp_Array1OfPnt2d

from cadsweep.cad.geometry.packed import unpack_curve, unpack_surface

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
    read = unpack_curve(curve, dimension)
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
