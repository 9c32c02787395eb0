"""What must hold of every loaded solid, whatever its shape."""

import numpy as np
import pytest

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")

from cadsweep.cad import load  # noqa: E402

from .cad_zoo import zoo  # noqa: E402

FRACTIONS = np.linspace(0.0, 1.0, 9)
SHAPES = zoo()


@pytest.fixture(scope="module")
def solids():
    return {name: load(shape).solids[0] for name, shape in SHAPES.items()}


@pytest.fixture(params=SHAPES)
def solid(request, solids):
    return solids[request.param]


def test_every_edge_joins_two_vertices_and_two_faces(solid):
    uses = np.zeros(len(solid.edges), dtype=int)
    for face in solid.faces:
        for edge in face.edges:
            uses[edge] += 1
            assert face.id in solid.edges[edge].faces
    assert (uses == 2).all()
    assert all(edge.start != edge.end and edge.faces[0] != edge.faces[1] for edge in solid.edges)


def test_edges_are_run_once_in_each_direction(solid):
    directed = [d for face in solid.faces for loop in face.loops for d in loop.directed]
    assert sorted(directed) == [(e, f) for e in range(len(solid.edges)) for f in (False, True)]


def test_loops_chain_up(solid):
    for face in solid.faces:
        for loop in face.loops:
            ends = [(solid.edges[e].start, solid.edges[e].end)[:: 1 if f else -1] for e, f in loop.directed]
            for (_, end), (start, _) in zip(ends, ends[1:] + ends[:1], strict=True):
                assert end == start


def test_curves_begin_and_end_at_their_vertices(solid):
    for edge in solid.edges:
        points = edge.curve.evaluate(np.array([0.0, 1.0]))
        assert np.abs(points - solid.vertices[[edge.start, edge.end]]).max() < 1e-7 * solid.size


def test_fractions_are_of_arc_length(solid):
    for edge in solid.edges:
        points = edge.curve.evaluate(np.linspace(0.0, 1.0, 2001))
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        # Chords of a smooth curve fall short of the arc by the cube of the step.
        assert abs(steps.sum() - edge.length) < 1e-5 * edge.length
        assert steps.max() - steps.min() < 1e-3 * steps.mean()


@pytest.mark.parametrize("kind", ["Hyperbola", "Parabola"])
def test_open_conics_are_those_of_opencascade(kind):
    from OCP import Geom, Geom2d, gp

    from cadsweep.cad.geometry.convert import read_curve, read_curve_2d

    frame = gp.gp_Ax2(gp.gp_Pnt(1, 2, 3), gp.gp_Dir(1, 1, 2), gp.gp_Dir(1, -1, 0))
    frame_2d = gp.gp_Ax22d(gp.gp_Pnt2d(1, 2), gp.gp_Dir2d(1, 3), gp.gp_Dir2d(3, -1))
    radii = (2.0, 0.7) if kind == "Hyperbola" else (0.4,)
    curve = getattr(Geom, f"Geom_{kind}")(frame, *radii)
    curve_2d = getattr(Geom2d, f"Geom2d_{kind}")(frame_2d, *radii)
    at = np.array([-1.3, 0.0, 0.4, 2.0])
    for known, read, n in ((curve, read_curve(curve).geometry, 3), (curve_2d, read_curve_2d(curve_2d), 2)):
        found = read.derivatives(at, 2)
        for t, *rows in zip(at, *found, strict=True):
            wanted = [known.Value(t), known.DN(t, 1), known.DN(t, 2)]
            wanted = [[p.X(), p.Y(), p.Z()] if n == 3 else [p.X(), p.Y()] for p in wanted]
            np.testing.assert_allclose(rows, wanted, atol=1e-12)


@pytest.mark.parametrize("hook", [0.0, 1e-4])
def test_hooks_at_the_ends_of_an_edge_are_no_corners(hook):
    from cadsweep.cad.geometry.curves import EdgeCurve
    from cadsweep.cad.geometry.nurbs import BSpline

    # the first ten-thousandth of the edge goes across, the rest straight on along x
    poles = np.array([[0.0, 0.0, 0.0], [0.0, hook, 0.0], [1.0, hook, 0.0]])
    spline = BSpline(degree=1, knots=np.array([0.0, 0.0, 1e-4, 1.0, 1.0]), poles=poles, weights=None)
    if hook == 0.0:  # a true corner in the middle stays one
        poles = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
        spline = BSpline(degree=1, knots=np.array([0.0, 0.0, 0.5, 1.0, 1.0]), poles=poles, weights=None)
    curve = EdgeCurve(geometry=spline, first=0.0, last=1.0, breaks=spline.breaks, constant_speed=False)
    expected = [[1, 0, 0], [1, 0, 0]] if hook else [[0, 1, 0], [1, 0, 0]]
    np.testing.assert_allclose(curve.end_tangents, expected, atol=1e-6)


def test_a_spline_is_as_long_by_compiled_loops_as_by_numpy():
    from cadsweep.cad.geometry.curves import EdgeCurve
    from cadsweep.cad.geometry.nurbs import BSpline
    from cadsweep.cad.geometry.parametric import Reparametrised

    poles = np.random.default_rng(5).standard_normal((7, 3)).cumsum(axis=0)
    knots = np.array([0, 0, 0, 0, 0.2, 0.2, 0.7, 1, 1, 1, 1])
    weights = np.array([1.0, 3.0, 1.0, 0.2, 1.0, 1.0, 2.0])
    spline = BSpline(degree=3, knots=knots, poles=poles, weights=weights)
    by_numpy = Reparametrised(curve=spline, offset=0.0, rate=1.0)
    compiled, plain = (
        EdgeCurve(geometry=own, first=0.1, last=0.95, breaks=spline.breaks) for own in (spline, by_numpy)
    )
    assert compiled.length == pytest.approx(plain.length, rel=1e-14)
    at = np.linspace(0.0, 1.0, 11)
    np.testing.assert_allclose(compiled.parameters(at), plain.parameters(at), atol=1e-13)


def test_projection_inverts_evaluation(solid):
    for edge in solid.edges:
        points = edge.curve.evaluate(FRACTIONS)
        assert np.abs(edge.curve.project(points) - FRACTIONS).max() < 1e-9


def test_parameters_of_an_edge_lie_on_the_edge(solid):
    for face in solid.faces:
        for edge in face.edges:
            on_surface = face.surface.evaluate(face.surface.edge_uv(edge, FRACTIONS))
            on_curve = solid.edges[edge].curve.evaluate(FRACTIONS)
            assert np.abs(on_surface - on_curve).max() < 1e-7 * solid.size


def test_parameters_of_a_face_lie_in_one_branch(solid):
    for face in solid.faces:
        for loop in face.loops:
            runs = [face.surface.edge_uv(e, FRACTIONS)[:: 1 if f else -1] for e, f in loop.directed]
            for run, following in zip(runs, runs[1:] + runs[:1], strict=True):
                jump = np.abs(run[-1] - following[0])
                for j, period in enumerate(face.surface.periods):
                    if period is not None:
                        # At a pole the angle may jump by less than a period; a whole one is another branch.
                        assert jump[j] < 0.9 * period


def test_outer_loops_turn_left_and_holes_right(solid):
    for face in solid.faces:
        for number, loop in enumerate(face.loops):
            runs = [face.surface.edge_uv(e, FRACTIONS)[:: 1 if f else -1][:-1] for e, f in loop.directed]
            u, v = np.concatenate(runs).T
            area = np.sum(u * np.roll(v, -1) - v * np.roll(u, -1))
            normal = face.surface.normals(face.surface.edge_uv(loop.edges[0], np.array([0.5])))
            by_u, by_v = face.surface.derivatives(face.surface.edge_uv(loop.edges[0], np.array([0.5])))
            area *= np.sign(np.einsum("md,md->m", np.cross(by_u, by_v), normal)[0])
            assert (area > 0) == (number == 0)


def test_corners_of_flat_faces_sum_up(solid):
    # On a plane the turns of a loop add up to one revolution, holes the other way round.
    for face in solid.faces:
        if face.kind != "plane" or any(solid.edges[e].kind != "line" for e in face.edges):
            continue
        for number, loop in enumerate(face.loops):
            turns = np.pi - np.array(loop.angles)
            assert turns.sum() == pytest.approx(2 * np.pi if number == 0 else -2 * np.pi)


def test_surface_projection_is_the_nearest_point(solid):
    rng = np.random.default_rng(3)
    for face in solid.faces:
        uv = np.concatenate([face.surface.edge_uv(e, rng.random(5)) for e in face.edges])
        points = face.surface.evaluate(uv)
        assert np.abs(face.surface.evaluate(face.surface.project(points)) - points).max() < 1e-7 * solid.size
        lifted = points + 1e-3 * solid.size * face.surface.normals(uv)
        back = face.surface.evaluate(face.surface.project(lifted))
        distance = np.linalg.norm(lifted - back, axis=1)
        assert distance.max() <= 1e-3 * solid.size * (1 + 1e-6)


def test_derivatives_are_those_of_evaluate(solid):
    step = 1e-5
    for face in solid.faces:
        uv = face.surface.edge_uv(face.edges[0], np.array([0.3, 0.6]))
        for j, partial in enumerate(face.surface.derivatives(uv)):
            h = np.zeros(2)
            h[j] = step
            slope = (face.surface.evaluate(uv + h) - face.surface.evaluate(uv - h)) / (2 * step)
            assert np.abs(slope - partial).max() < 1e-5 * (1 + np.abs(partial).max())


def test_the_boundary_is_closed(solid):
    from cadsweep.cad.geometry.measure import measure_face

    shares = [measure_face(face.surface, face.loops) for face in solid.faces]
    area = sum(face.area for face in solid.faces)
    assert np.linalg.norm(sum(s.vector for s in shares)) < 1e-6 * area
    assert sum(s.volume for s in shares) == pytest.approx(solid.volume, rel=1e-7)
    assert [s.area for s in shares] == pytest.approx([face.area for face in solid.faces], rel=1e-6)


@pytest.mark.parametrize("name", SHAPES)
def test_volume_is_that_of_the_cad(name, solids):
    # OpenCASCADE integrates splines by itself no better than this.
    assert solids[name].volume == pytest.approx(SHAPES[name].val().Volume(), rel=3e-4)


def test_volume_and_area_of_shapes_known_by_formula(solids):
    assert solids["box"].volume == pytest.approx(6.0, rel=1e-14)
    assert solids["half_torus"].volume == pytest.approx(np.pi * 4 * np.pi * 5, rel=1e-13)  # Pappus
    assert sum(f.area for f in solids["sphere"].faces) == pytest.approx(4 * np.pi, rel=1e-13)
    assert solids["oval_ring"].volume == pytest.approx(2 * np.pi * 15 * np.pi * 8, rel=1e-10)
    assert solids["ellipse"].volume == pytest.approx(2 * np.pi, rel=1e-13)


def test_dihedral_angles():
    box = load(cq.Workplane().box(1, 1, 1)).solids[0]
    assert [e.dihedral for e in box.edges] == pytest.approx([np.pi / 2] * 12)
    corner = load(cq.Workplane().box(2, 2, 1).cut(cq.Workplane().box(1, 1, 1).translate((1, 1, 0)))).solids[0]
    assert sorted(e.dihedral for e in corner.edges)[-1] == pytest.approx(3 * np.pi / 2)
    slot = load(cq.Workplane().slot2D(4, 1).extrude(1)).solids[0]
    tangent = [e.dihedral for e in slot.edges if e.kind == "line" and abs(e.tangents[0, 2]) > 0.9]
    assert tangent == pytest.approx([np.pi] * 4)


def test_a_round_side_becomes_two_faces_with_two_straight_rails(solids):
    tube = solids["tube"]
    rails = [e for e in tube.edges if e.kind == "line"]
    assert len(rails) == 4  # two on the outside, two in the bore
    assert all(abs(e.tangents[0, 2]) == pytest.approx(1.0) for e in rails)
    caps = [f for f in tube.faces if f.kind == "plane"]
    assert all(len(loop.edges) == 2 for cap in caps for loop in cap.loops)


def test_new_edges_of_a_torus_are_exact_circles(solids):
    half = solids["half_torus"]
    assert {e.kind for e in half.edges} == {"circle"}
    assert sorted({round(e.length, 9) for e in half.edges}) == [
        round(x, 9) for x in (2 * np.pi, 3 * np.pi, 7 * np.pi)
    ]  # half of the section, then half turns at 5 - 2 and 5 + 2
