"""Curves and surfaces from their records are those of the formulas in numpy, and so is what is summed over a face."""

from dataclasses import replace

import numpy as np
import pytest

from cadsweep.cad.geometry import parametric, surfaces
from cadsweep.cad.geometry.face_surface import FaceSurface
from cadsweep.cad.geometry.feet_kernels import grid_places
from cadsweep.cad.geometry.nurbs import BSpline, BSplineSurface
from cadsweep.cad.geometry.record_kernels import curve_points, surface_points
from cadsweep.cad.geometry.records import curve_record, surface_record

cq = pytest.importorskip("cadquery")
pytestmark = pytest.mark.cad

RANDOM = np.random.default_rng(4)
A, B, C, D = RANDOM.standard_normal((4, 3))
KNOTS = np.array([0.0, 0, 0, 0, 0.3, 0.6, 1, 1, 1, 1])
SPLINE = BSpline(degree=3, knots=KNOTS, poles=RANDOM.standard_normal((6, 3)), weights=RANDOM.uniform(0.5, 2, 6))
CURVES = {
    "line": parametric.Line(origin=A, direction=B),
    "ellipse": parametric.Ellipse(center=A, x_axis=B, y_axis=C),
    "hyperbola": parametric.Hyperbola(center=A, x_axis=B, y_axis=C),
    "parabola": parametric.Parabola(vertex=A, x_axis=B, y_axis=C),
    "spline": SPLINE,
    "plane spline": BSpline(degree=3, knots=KNOTS, poles=SPLINE.poles[:, :2]),
    "plane line": parametric.Line(origin=A[:2], direction=B[:2]),
    "periodic": parametric.Periodic(spline=SPLINE, period=1.0),
    "turned round": parametric.Reparametrised(curve=SPLINE, offset=0.9, rate=-0.7),
}
X, Y = np.linalg.qr(np.stack([A, B], axis=1))[0].T
FRAME = surfaces.Frame(origin=D, x=X, y=Y, z=-np.cross(X, Y))
SURFACES = {
    "plane": surfaces.Plane(frame=FRAME),
    "cylinder": surfaces.Cone(frame=FRAME, radius=2.0),
    "cone": surfaces.Cone(frame=FRAME, radius=2.0, half_angle=0.4),
    "sphere": surfaces.Torus(frame=FRAME, major=0.0, minor=2.0, periods=(surfaces.TWO_PI, None)),
    "torus": surfaces.Torus(frame=FRAME, major=3.0, minor=1.0),
    "extruded": surfaces.Extruded(curve=SPLINE, direction=D),
    "revolved": surfaces.Revolved(curve=SPLINE, origin=A, axis=X),
    "spline": surfaces.Spline(
        spline=BSplineSurface(
            degrees=(3, 3),
            u_knots=KNOTS,
            v_knots=KNOTS,
            poles=RANDOM.standard_normal((6, 6, 3)),
            weights=RANDOM.uniform(0.5, 2, (6, 6)),
        )
    ),
}
UV = RANDOM.uniform(0.05, 0.95, (40, 2))


@pytest.mark.parametrize("name", CURVES)
def test_curve(name):
    curve = CURVES[name]
    expected = curve.derivatives(UV[:, 0])[0]
    found = np.empty((1, len(UV), expected.shape[1]))
    shift = np.full((1, expected.shape[1]), 0.25)
    curve_points(curve_record(curve), np.array([0]), shift, UV[None, :, 0].copy(), found)
    np.testing.assert_allclose(found[0], expected + 0.25, rtol=0, atol=1e-13)


@pytest.mark.parametrize("name", SURFACES)
def test_surface_and_its_partial_derivatives(name):
    found = np.empty((3, len(UV), 3))
    surface_points(surface_record(SURFACES[name]), UV, found)
    np.testing.assert_allclose(found, SURFACES[name].derivatives(UV), rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", SURFACES)
def test_a_grid_holds_the_surface_place_by_place(name):
    u, v = np.linspace(0.05, 0.9, 5), np.linspace(0.1, 0.95, 4)
    uv, places, normals = (np.empty((20, width)) for width in (2, 3, 3))
    grid_places(surface_record(SURFACES[name]), u, v, uv, places, normals)
    np.testing.assert_array_equal(uv, [(a, b) for a in u for b in v])
    found, by_u, by_v = SURFACES[name].derivatives(uv)
    cross = np.cross(by_u, by_v)
    np.testing.assert_allclose(places, found, rtol=0, atol=1e-12)
    np.testing.assert_allclose(normals, cross / np.linalg.norm(cross, axis=1)[:, None], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", SURFACES)
def test_normals_are_those_of_the_partial_derivatives(name):
    box = np.array([[0.0, 0.0], [1.0, 1.0]])
    face = FaceSurface(geometry=SURFACES[name], outward=-1.0, box=box, limits=box)
    _, by_u, by_v = SURFACES[name].derivatives(UV)
    cross = np.cross(by_u, by_v)
    expected = -cross / np.linalg.norm(cross, axis=1)[:, None]
    np.testing.assert_allclose(face.normals(UV), expected, rtol=0, atol=1e-12)


def test_what_has_no_record_says_so():
    called = parametric.Called(function=lambda t, order: ((t, 0.0, 0.0),) * (order + 1))
    offset = surfaces.Offset(basis=SURFACES["torus"], distance=0.1, step=(1e-5, 1e-5))
    assert curve_record(called) is None
    assert surface_record(surfaces.Extruded(curve=called, direction=D)) is None
    assert surface_record(offset) is None


def solids():
    from cadsweep.cad import load

    wave = [(0, 0), (2, 1), (4, 0), (6, 1)]
    holed = cq.Workplane().spline(wave).lineTo(6, 4).lineTo(0, 4).close().extrude(2)
    for part in (
        cq.Workplane().circle(3).circle(1).extrude(2).faces(">Z").edges().fillet(0.3),
        holed.faces("<Y").workplane().circle(0.4).cutThruAll(),
        cq.Workplane().rect(4, 2).twistExtrude(3, 40),
        cq.Workplane().circle(2).workplane(3).circle(0.5).loft(),
    ):
        yield load(part).solids[0]


def test_a_face_without_records_is_the_same_face():
    """All that is asked of a face while it is read and checked, by compiled loops and in numpy."""
    from cadsweep.cad.extract.gaps import border_gaps
    from cadsweep.cad.extract.sampling import sample_edges, sample_face
    from cadsweep.cad.geometry.measure import measure_face

    for solid in solids():
        samples = sample_edges([edge.curve for edge in solid.edges])
        for face in solid.faces:
            compiled = replace(face.surface)
            general = replace(face.surface)
            general.__dict__.update(record=None, edge_records=None, curved=None)
            if not isinstance(face.surface.geometry, surfaces.Cone | surfaces.Torus):
                points = compiled.evaluate(compiled.box.mean(axis=0)[None]) + 0.01
                np.testing.assert_allclose(compiled.distance(points), general.distance(points), atol=1e-9)
            for one, other in zip(measure_face(compiled, face.loops), measure_face(general, face.loops), strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-9)
            (_, one), (_, other) = (border_gaps(own, samples, solid.size) for own in (compiled, general))
            np.testing.assert_allclose(one, other, atol=1e-9)
            found = sample_face(compiled, samples)
            assert found.gap < 1e-6
