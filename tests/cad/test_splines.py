"""Compiled B-splines: identities of the basis, and scipy's own as a second opinion."""

import numpy as np
import pytest
from scipy.interpolate import BSpline as Reference
from scipy.interpolate import NdBSpline

from cadsweep.cad.geometry.curves import EdgeCurve
from cadsweep.cad.geometry.nurbs import BSpline, BSplineSurface
from cadsweep.cad.geometry.parametric import Periodic, Reparametrised

RNG = np.random.default_rng(7)


def clamped(degree, n_poles, multiplicity=1):
    inner = np.repeat(np.sort(RNG.random(-(-(n_poles - degree - 1) // multiplicity))), multiplicity)
    return np.concatenate([np.zeros(degree + 1), inner[: n_poles - degree - 1], np.ones(degree + 1)])


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("multiplicity", [1, 2])
def test_curve_and_two_derivatives_as_scipy_has_them(degree, multiplicity):
    knots = clamped(degree, degree + 9, multiplicity=min(multiplicity, degree))
    poles = RNG.random((degree + 9, 3))
    t = np.concatenate([[0.0, 1.0], RNG.random(40)])
    mine = BSpline(degree=degree, knots=knots, poles=poles).derivatives(t, 2)
    reference = Reference(knots, poles, degree)
    for order, values in enumerate(mine):
        wanted = reference(t, order)
        np.testing.assert_allclose(values, wanted, atol=1e-12 * max(1.0, np.abs(wanted).max()))


def test_rational_arc_is_a_circle():
    """The quadratic with weights 1, 1/sqrt 2, 1 on a right angle: radius one, speed across the radius."""
    arc = BSpline(
        degree=2,
        knots=np.array([0.0, 0, 0, 1, 1, 1]),
        poles=np.array([[1.0, 0], [1, 1], [0, 1]]),
        weights=np.array([1.0, np.sqrt(0.5), 1.0]),
    )
    points, slopes, curvatures = arc.derivatives(np.linspace(0, 1, 21), 2)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-15)
    np.testing.assert_allclose((points * slopes).sum(axis=1), 0.0, atol=1e-14)
    # Of |x|^2 = 1, differentiated twice.
    np.testing.assert_allclose((points * curvatures).sum(axis=1), -(slopes**2).sum(axis=1), atol=1e-13)


def test_period_brings_parameters_into_the_knots():
    knots, poles = clamped(3, 10), RNG.random((10, 3))
    curve = BSpline(degree=3, knots=knots, poles=poles)
    t = np.array([0.125, 0.5, 0.75])
    np.testing.assert_array_equal(curve.derivatives(t + 2.0, 1, period=1.0), curve.derivatives(t, 1))
    np.testing.assert_array_equal(curve.derivatives(t - 3.0, 1, period=1.0), curve.derivatives(t, 1))


@pytest.mark.parametrize("weighted", [False, True])
def test_surface_as_scipy_has_it(weighted):
    u_knots, v_knots = clamped(2, 7), clamped(3, 9)
    poles = RNG.random((7, 9, 3))
    weights = RNG.random((7, 9)) + 0.5 if weighted else np.ones((7, 9))
    surface = BSplineSurface(
        degrees=(2, 3), u_knots=u_knots, v_knots=v_knots, poles=poles, weights=weights if weighted else None
    )
    uv = np.concatenate([[[0, 0], [1, 1], [0, 1]], RNG.random((30, 2))])
    homogeneous = NdBSpline(
        (u_knots, v_knots), np.concatenate([poles * weights[..., None], weights[..., None]], axis=2), (2, 3)
    )
    h, hu, hv = homogeneous(uv), homogeneous(uv, nu=(1, 0)), homogeneous(uv, nu=(0, 1))
    point = h[:, :3] / h[:, 3:]
    found = surface.derivatives(uv)
    np.testing.assert_allclose(found[0], point, atol=1e-14)
    np.testing.assert_allclose(found[1], (hu[:, :3] - hu[:, 3:] * point) / h[:, 3:], atol=1e-11)
    np.testing.assert_allclose(found[2], (hv[:, :3] - hv[:, 3:] * point) / h[:, 3:], atol=1e-11)
    np.testing.assert_array_equal(surface.evaluate(uv), found[0])


def quarter(**periodic):
    """A quarter of a circle as a rational curve: its arc length is known."""
    spline = BSpline(
        degree=2,
        knots=np.array([0.0, 0, 0, 1, 1, 1]),
        poles=np.array([[1.0, 0, 0], [1, 1, 0], [0, 1, 0]]),
        weights=np.array([1.0, np.sqrt(0.5), 1.0]),
    )
    return Periodic(spline=spline, period=1.0) if periodic else spline


@pytest.mark.parametrize("geometry", [quarter(), quarter(period=1.0)])
def test_arc_lengths_are_those_of_a_circle_and_no_answer_depends_on_the_others(geometry):
    curve = EdgeCurve(geometry=geometry, first=0.0, last=1.0)
    fractions = np.linspace(0.0, 1.0, 33)
    assert curve.length == pytest.approx(np.pi / 2, rel=1e-14)
    together = curve.parameters(fractions)
    np.testing.assert_allclose(curve.fractions(together), fractions, atol=1e-14)
    angles = np.pi / 2 * fractions
    np.testing.assert_allclose(curve.evaluate(fractions)[:, 0], np.cos(angles), atol=1e-14)
    alone = np.array([curve.parameters(fractions[j : j + 1])[0] for j in range(len(fractions))])
    assert np.array_equal(together, alone)


def test_compiled_arc_lengths_are_those_of_the_general_way():
    knots, poles = clamped(3, 12), np.random.default_rng(3).random((12, 3))
    spline = BSpline(degree=3, knots=knots, poles=poles)
    # A parametrisation by itself hides what the curve is.
    hidden = Reparametrised(curve=spline, offset=0.0, rate=1.0)
    breaks = np.unique(knots)
    mine, general = (EdgeCurve(geometry=g, first=0.0, last=1.0, breaks=breaks) for g in (spline, hidden))
    assert mine.length == pytest.approx(general.length, rel=1e-14)
    at = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(mine.parameters(at), general.parameters(at), atol=1e-12)


@pytest.mark.parametrize("weighted", [False, True])
def test_compiled_nearest_points_are_those_of_the_general_way(weighted):
    random = np.random.default_rng(5)
    knots, poles = clamped(3, 12), random.random((12, 3))
    spline = BSpline(degree=3, knots=knots, poles=poles, weights=random.uniform(0.5, 2.0, 12) if weighted else None)
    hidden = Reparametrised(curve=spline, offset=0.0, rate=1.0)
    breaks = np.unique(knots)
    mine, general = (EdgeCurve(geometry=g, first=0.0, last=1.0, breaks=breaks) for g in (spline, hidden))
    points = np.concatenate([random.uniform(-0.5, 1.5, (60, 3)), mine.evaluate(np.linspace(0.0, 1.0, 21))])
    found = mine.distance(points)
    np.testing.assert_allclose(found, general.distance(points), atol=1e-12)
    # None of the curve's own points is nearer.
    dense = mine.evaluate(np.linspace(0.0, 1.0, 20_001))
    assert (found <= np.linalg.norm(dense[None] - points[:, None], axis=2).min(axis=1) + 1e-12).all()
    assert found[60:].max() < 1e-14
