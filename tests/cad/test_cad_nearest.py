"""Nearest points: the compiled loop against the formulas in numpy, and against what may lie nearer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cadsweep
from cadsweep.cad.geometry.feet import Feet
from cadsweep.cad.geometry.feet_kernels import descended_feet
from cadsweep.cad.geometry.nearest_kernels import block_boxes, near_on_lines
from cadsweep.cad.geometry.nurbs import BSplineSurface
from cadsweep.cad.geometry.patch import Patch
from cadsweep.cad.geometry.records import surface_record
from cadsweep.cad.geometry.surfaces import Spline

cq = pytest.importorskip("cadquery")
pytestmark = pytest.mark.cad


def clamped(degree, n_poles):
    """A clamped knot vector with even inner knots, one of them double where that leaves no crease."""
    inner = np.linspace(0, 1, n_poles - degree + 1)[1:-1]
    if len(inner) > 2 and degree > 2:
        inner[1] = inner[0]
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def wavy(degrees=(3, 2), shape=(7, 5), *, rational=True, seed=0):
    """A bumpy patch over the unit square."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 1, shape[0]), np.linspace(0, 1, shape[1]), indexing="ij")
    poles = np.stack([x, y, 0.2 * rng.normal(size=shape)], axis=-1)
    weights = rng.uniform(0.5, 2.0, shape) if rational else None
    return BSplineSurface(
        degrees=degrees,
        u_knots=clamped(degrees[0], shape[0]),
        v_knots=clamped(degrees[1], shape[1]),
        poles=poles,
        weights=weights,
    )


def feet(spline, points, start):
    uv, distances = np.array(start, dtype=float), np.empty(len(points))
    descended_feet(surface_record(Spline(spline=spline)), np.zeros(2), np.ones(2), points, uv, distances)
    return uv, distances


@pytest.mark.parametrize("rational", [False, True])
@pytest.mark.parametrize(("degrees", "shape"), [((3, 2), (7, 5)), ((1, 1), (2, 2)), ((5, 1), (6, 4)), ((2, 7), (9, 8))])
def test_points_of_the_surface_are_their_own_feet(degrees, shape, rational):
    spline = wavy(degrees, shape, rational=rational)
    rng = np.random.default_rng(1)
    uv = np.concatenate([rng.random((200, 2)), [[0, 0], [1, 1], [0, 1], [0.5, 1]]])
    start = np.clip(uv + rng.uniform(-0.02, 0.02, uv.shape), 0, 1)
    found, distances = feet(spline, spline.evaluate(uv), start)
    assert distances.max() < 1e-14
    assert np.abs(spline.evaluate(found) - spline.evaluate(uv)).max() < 1e-14


def test_feet_are_perpendicular_and_the_distance_is_theirs():
    spline = wavy()
    rng = np.random.default_rng(2)
    uv = rng.uniform(0.1, 0.9, (200, 2))
    points, by_u, by_v = spline.derivatives(uv)
    normals = np.cross(by_u, by_v)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    lifted = points + 0.01 * normals
    found, distances = feet(spline, lifted, uv + 0.01)
    place, by_u, by_v = spline.derivatives(found)
    assert np.abs(np.linalg.norm(place - lifted, axis=1) - distances).max() < 1e-15
    assert np.all(distances <= 0.01 * (1 + 1e-9))
    inside = np.all((found > 0) & (found < 1), axis=1)
    assert inside.mean() > 0.9
    for partial in (by_u, by_v):
        cosine = np.einsum("md,md->m", partial, lifted - place) / np.linalg.norm(partial, axis=1) / distances
        assert np.abs(cosine[inside]).max() < 1e-5


def test_beyond_the_limits_the_foot_is_on_the_rim():
    flat = BSplineSurface(
        degrees=(1, 1),
        u_knots=clamped(1, 2),
        v_knots=clamped(1, 2),
        poles=np.array([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1.5, 1, 0]]], dtype=float),
    )
    outside = np.array([[-1, 0.5, 0], [0.5, -2, 0], [3, 3, 0], [0.3, 0.4, 0.7]])
    _, distances = feet(flat, outside, np.full((4, 2), 0.5))
    np.testing.assert_allclose(distances, [1, 2, np.hypot(1.5, 2), 0.7], rtol=1e-9)


def coil():
    helix = cq.Wire.makeHelix(1, 9, 5)
    return cq.Solid.sweep(cq.Wire.makeCircle(0.3, cq.Vector(5, 0, 0), cq.Vector(0, 1, 0)), [], helix, True, True)


def strip():
    """Turns of a square section that nearly touch: places of another turn are nearer than a point's own."""
    helix = cq.Workplane(cq.Wire.makeHelix(2.4, 7.2, 6))
    return cq.Workplane("XZ").center(6, 0).rect(2, 2).sweep(helix, isFrenet=True)


PARTS = {
    "coil": coil,
    "strip": strip,
    "skewed loft": lambda: cq.Workplane().rect(1, 1).workplane(offset=5).center(-3, -1.5).ellipse(0.8, 0.7).loft(),
    "flat loft": lambda: cq.Workplane().rect(3, 0.4).workplane(offset=1).ellipse(0.2, 1.5).loft(),
    "oval": lambda: cq.Workplane("XZ").center(9, 0).ellipse(4, 1).revolve(200, (-9, 0, 0), (-9, 1, 0)),
    "curl": lambda: (
        cq.Workplane()
        .spline([(4, 0), (4, 4), (0, 4), (0.5, 1), (2, 2)], includeCurrent=True)
        .lineTo(2, 0)
        .close()
        .extrude(3)
    ),
}


@pytest.mark.parametrize("name", PARTS)
def test_no_point_of_a_face_is_lost(name):
    """Coils lie close to each other, and a descent that begins on the wrong one stays there."""
    solid = cadsweep.load(PARTS[name]()).solids[0]
    rng = np.random.default_rng(0)
    for face in solid.faces:
        low, high = face.surface.box
        points = face.surface.evaluate(low + rng.random((2000, 2)) * (high - low))
        assert face.surface.distance(points, close=1e-6 * solid.size).max() < 1e-9 * solid.size
        assert face.surface.distance(points).max() < 1e-9 * solid.size
        lifted = points + 1e-4 * solid.size * face.surface.normals(face.surface.project(points))
        off = face.surface.distance(lifted[:200], close=1e-6 * solid.size)
        assert off.max() < 1.01e-4 * solid.size


def test_the_right_wall_of_a_thin_twisted_tip_is_found():
    """Places of the grid that are nearest may all be on the other wall: the section turns between two rows of them."""
    at = 2 * np.pi * np.arange(24) / 24 + np.pi / 2
    section = [tuple(p) for p in np.column_stack([10 * np.cos(at), 0.5 * np.sin(at)]).tolist()]
    blade = cq.Workplane().spline(section, periodic=True).wire().twistExtrude(40, 60)
    face = next(f for f in cadsweep.load(blade).solids[0].faces if f.kind == "bspline").surface
    low, high = face.box
    u = low[0] + (high[0] - low[0]) * (np.arange(400) + 0.5) / 400
    v = low[1] + (high[1] - low[1]) * np.linspace(0.15, 0.85, 7)
    rows = face.evaluate(np.stack(np.meshgrid(v, u), axis=-1)[..., ::-1].reshape(-1, 2)).reshape(400, 7, 3)
    chords = (0.5 * (rows[:-6] + rows[6:])).reshape(-1, 3)[::7]
    np.testing.assert_allclose(face.distance(chords), face.second_opinion(chords), atol=1e-7)
    feet = face.evaluate(face.project(chords))
    np.testing.assert_allclose(np.linalg.norm(feet - chords, axis=1), face.distance(chords), atol=1e-12)


def test_opencascade_is_asked_about_what_stays_far():
    face = next(f for f in cadsweep.load(PARTS["skewed loft"]()).solids[0].faces if f.kind == "bspline")
    points = face.surface.evaluate(face.surface.box.mean(axis=0)[None]) + [[0.0, 0.0, 0.0], [0.1, 0.1, 0.1]]
    asked = []

    def opinion(places):
        asked.append(len(places))
        return np.zeros(len(places))

    doubtful = replace(face.surface, second_opinion=opinion)
    assert doubtful.distance(points, close=1e-3).tolist()[1] == 0
    assert asked == [1]
    own = face.surface.distance(points)
    np.testing.assert_allclose(face.surface.second_opinion(points), own, atol=1e-7)


def test_opencascade_says_infinite_where_it_finds_no_foot():
    from OCP.Geom import Geom_Plane
    from OCP.gp import gp_Dir, gp_Pnt

    from cadsweep.cad.geometry.convert import distances_from

    distances = distances_from(Geom_Plane(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), np.array([[0.0, 0.0], [1.0, 1.0]]))
    found = distances(np.array([[0.5, 0.5, 2.0], [np.nan, 0.0, 0.0]]))
    assert found[0] == pytest.approx(2)
    assert np.isinf(found[1])


@pytest.mark.parametrize("axis", [0, 1])
def test_the_nearest_place_on_the_lines_of_a_grid_comes_first(axis):
    random = np.random.default_rng(axis)
    grid, points = random.normal(size=(5, 4, 3)), random.normal(size=(20, 3))
    places = grid.reshape(-1, 3)
    blocks = np.empty((2, 2, 2, 3)), np.empty((2, 2)), 2
    block_boxes(places, 4, 2, *blocks[:2])
    rows, shares = np.empty((20, 3), dtype=np.int64), np.empty((20, 3))
    elsewhere = np.full((20, 2), -9)
    near_on_lines(places, 4, axis, blocks, points, np.full(20, np.inf), elsewhere, rows, shares)
    ahead = places[rows[:, 0] + (4 if axis == 0 else 1)]
    found = np.linalg.norm(places[rows[:, 0]] + shares[:, :1] * (ahead - places[rows[:, 0]]) - points, axis=1)
    lines = np.moveaxis(grid, axis, 0)
    shares_of_all = np.linspace(0.0, 1.0, 101)[:, None, None, None]
    dense = (lines[:-1] + shares_of_all * (lines[1:] - lines[:-1])).reshape(-1, 3)
    least = np.linalg.norm(dense - points[:, None], axis=2).min(axis=1)
    step = np.linalg.norm(np.diff(lines, axis=0), axis=2).max() / 200  # half of the samples' greatest distance
    assert (found <= least + 1e-12).all()
    assert (found >= least - step).all()
    # What was found beside it already is not looked for again, and what is too far away is left out.
    cells = np.stack(np.unravel_index(rows[:, 0], (5, 4)), axis=1)
    others = np.empty_like(rows)
    near_on_lines(places, 4, axis, blocks, points, least - step, cells, others, shares)
    assert (others != rows[:, :1]).all()
    far = points + [100.0, 0.0, 0.0]
    near_on_lines(places, 4, axis, blocks, far, np.ones(20), elsewhere, rows, shares)
    assert (rows == -1).all()


@pytest.mark.parametrize("side", ["low", "high"])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_knot_that_is_an_end_of_the_box_but_for_its_last_digits_is_no_place_of_its_own(axis, side):
    spline = wavy((3, 3), (7, 7), rational=False)
    geometry = Spline(spline=spline)
    box = np.array([[0.0, 0.0], [1.0, 1.0]])
    knot = float(np.unique(spline.u_knots)[2])
    box[0 if side == "low" else 1, axis] = np.nextafter(knot, -1.0 if side == "low" else 2.0)
    feet = Feet(Patch(geometry=geometry, box=box, limits=np.array([[0.0, 0.0], [1.0, 1.0]]), outward=1.0))
    uv = box[0] + np.random.default_rng(2).random((50, 2)) * (box[1] - box[0])
    points = geometry.evaluate(uv)
    assert (np.diff(feet._walls[0]) > 0).all()
    assert (np.diff(feet._walls[1]) > 0).all()
    assert feet.nearest(points)[1].max() < 1e-9
