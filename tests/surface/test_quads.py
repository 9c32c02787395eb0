"""Quads on the source cap: the boundary stays, quads alone, and relaxing never lowers the worst."""

from dataclasses import replace

import numpy as np
import pytest

from cadsweep.errors import SurfaceMeshError
from cadsweep.surface import mesh_boundary, quads
from cadsweep.surface.filling import best_quads
from cadsweep.surface.gmsh_quads import parted
from cadsweep.surface.mend import mend_flat_corners, wanted_valences
from cadsweep.surface.relax import corner_sines, relax_quads
from cadsweep.surface.triangles import remove_triangles

from .surface_shapes import Plane, count_segments, l_shape, polygon_angles, polygon_prism, raised, square


def divided(polygon, n):
    ends = np.roll(polygon, -1, axis=0)
    s = np.arange(n)[:, None] / n
    return np.concatenate([a + s * (b - a) for a, b in zip(polygon, ends, strict=True)])


def polygon_area(loop):
    x, y = loop.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def quad_areas(points, quads):
    return sum(polygon_area(points[q]) for q in quads)


def check_quads(mesh):
    """Conforming, counter-clockwise about the sweep direction, its border the loops."""
    edges = np.sort(np.stack([mesh.quads, np.roll(mesh.quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    assert uses.max() <= 2
    border = {tuple(edge) for edge in unique[uses == 1]}
    wanted = {tuple(sorted(pair)) for loop in mesh.loops for pair in zip(loop, np.roll(loop, -1), strict=True)}
    assert border == wanted
    assert set(np.unique(mesh.quads)) == set(range(len(mesh.points)))


def test_a_four_sided_cap_is_a_grid():
    sweep = polygon_prism([square()], [raised(0), raised(2)])
    mesh = mesh_boundary(sweep, count_segments(sweep, [4, 6, 4, 6], 2)).source
    check_quads(mesh)
    assert len(mesh.quads) == 24
    assert (corner_sines(mesh.points, mesh.quads, np.tile([0.0, 0, 1], (len(mesh.points), 1))) > 1 - 1e-12).all()
    for edge, nodes in mesh.edge_nodes.items():
        ends = sweep.solid.vertices[[sweep.solid.edges[edge].start, sweep.solid.edges[edge].end]]
        assert np.array_equal(mesh.points[nodes[[0, -1]]], ends)


def test_ring_and_cap_share_their_nodes():
    sweep = polygon_prism([square()], [raised(0), raised(2, 2 * np.eye(2))])
    mesh = mesh_boundary(sweep, count_segments(sweep, 5, 3))
    assert np.array_equal(mesh.rings[0], mesh.source.points[np.concatenate(mesh.source.loops)])


def test_an_l_has_angles_that_the_wanted_valences_count():
    wanted, angle = wanted_valences([divided(l_shape(), 2)])
    assert angle[::2] == pytest.approx(polygon_angles(l_shape()))
    assert wanted.tolist() == [1, 2, 1, 2, 1, 2, 3, 2, 1, 2, 1, 2]


def test_a_good_mesh_is_not_mended():
    loop = divided(square(2.0), 2)
    quads = np.array([[0, 1, 8, 7], [1, 2, 3, 8], [8, 3, 4, 5], [7, 8, 5, 6]])
    inner, same = mend_flat_corners([loop], np.zeros((1, 2)), quads)
    assert np.array_equal(same, quads)
    assert len(inner) == 1


def test_corners_that_are_flat_on_the_other_cap_get_an_edge_of_their_own():
    n = 4
    loop = divided(square(float(n)), n)
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0)))
    points = np.column_stack([x, y])
    inside = np.flatnonzero((x > 0) & (x < n) & (y > 0) & (y < n))
    shifted = loop - loop.min(axis=0)
    number = np.empty(len(points), dtype=np.int64)
    for k, place in enumerate(np.concatenate([shifted, points[inside]])):
        number[np.argmin(np.linalg.norm(points - place, axis=1))] = k
    ids = number[np.arange((n + 1) ** 2).reshape(n + 1, n + 1)]
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    corners = np.arange(0, 4 * n, n)
    assert (np.bincount(quads.ravel())[corners] == 1).all()
    opposite = np.full(len(loop), np.nan)
    opposite[corners] = np.pi
    inner, mended = mend_flat_corners([shifted], points[inside], quads, opposite)
    assert (np.bincount(mended.ravel())[corners] >= 2).all()
    everything = np.concatenate([shifted, inner])
    assert quad_areas(everything, mended) == pytest.approx(n * n)
    edges = np.sort(np.stack([mended, np.roll(mended, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 1).sum() == 4 * n
    assert uses.max() == 2


def test_triangles_walk_until_they_meet():
    n = 6
    ids = np.arange(n * n).reshape(n, n)
    x, y = np.meshgrid(np.arange(n), np.arange(n))
    points = np.column_stack([x.ravel(), y.ravel()]).astype(float)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    # The first and the last cell lose a boundary corner each: two triangles, at opposite ends.
    triangles = np.array([np.roll(quads[0], -1)[:3], np.roll(quads[-1], -3)[:3]])
    merged = remove_triangles(points, quads[1:-1], triangles)
    assert merged.shape == (len(quads) - 1, 4)
    assert quad_areas(points, merged) == pytest.approx((n - 1) ** 2 - 1)
    edges = np.sort(np.stack([merged, np.roll(merged, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert uses.max() == 2
    assert (uses == 1).sum() == 4 * (n - 1) - 2


def test_one_triangle_alone_finds_no_partner():
    points = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [2, 0.5]])
    assert remove_triangles(points, np.array([[0, 1, 2, 3]]), np.array([[1, 4, 2]])) is None


@pytest.mark.parametrize("seed", range(3))
def test_relaxing_never_lowers_the_worst_corner_and_keeps_the_boundary(seed):
    n = 9
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])
    ids = np.arange(n * n).reshape(n, n)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    border = np.concatenate([ids[0], ids[-1], ids[1:-1, 0], ids[1:-1, -1]])
    inside = np.setdiff1d(ids, border)
    order = np.concatenate([border, inside])
    number = np.empty(n * n, dtype=np.int64)
    number[order] = np.arange(n * n)
    points, quads = points[order], number[quads]
    points[len(border) :, :2] += np.random.default_rng(seed).uniform(-0.12, 0.12, (len(inside), 2))
    plane = Plane(np.zeros(3), [0, 0, -1.0])
    normals = np.tile([0.0, 0, 1], (n * n, 1))
    before = corner_sines(points, quads, normals).min()
    after, _, worst = relax_quads(plane, points, plane.project(points), quads, n_fixed=len(border))
    assert np.array_equal(after[: len(border)], points[: len(border)])
    assert worst == pytest.approx(corner_sines(after, quads, normals).min())
    assert worst >= before
    assert worst > 0.6


def gmsh_quads():
    pytest.importorskip("gmsh")
    from cadsweep.surface import gmsh_quads

    return gmsh_quads


@pytest.mark.cad
@pytest.mark.parametrize(("n_nodes", "accepted"), [(2000, 0.3), (12000, 0.2)])
def test_blossom_is_not_asked_for_minutes_where_subdivided_triangles_are_fair(n_nodes, accepted):
    turn = np.linspace(0.0, 2.0 * np.pi, n_nodes, endpoint=False)
    settings = gmsh_quads().settings_for([np.stack([np.cos(turn), np.sin(turn)], axis=1)])
    first_blossom = next(j for j, each in enumerate(settings) if each.recombination == 1)
    assert min(each.good_enough for each in settings[:first_blossom]) == accepted


@pytest.mark.cad
@pytest.mark.parametrize("n_hole", [4, 10, 40])
def test_polygons_are_meshed_on_their_own_boundary(n_hole):
    module = gmsh_quads()
    angles = -2 * np.pi * np.arange(n_hole) / n_hole
    loops = [divided(square(2.0), 9), 0.4 * np.column_stack([np.cos(angles), np.sin(angles)])]
    made = 0
    for setting in module.settings_for(loops):
        try:
            inner, quads = module.mesh_polygon(loops, setting)
        except SurfaceMeshError:
            continue
        made += 1
        points = np.concatenate([*loops, inner])
        assert quad_areas(points, quads) == pytest.approx(sum(polygon_area(loop) for loop in loops), rel=1e-12)
        assert set(np.unique(quads)) == set(range(len(points)))
    assert made >= 2


@pytest.mark.cad
@pytest.mark.parametrize("turn", [0, 1])
def test_no_boundary_node_is_left_with_one_flat_corner(turn):
    # Subdivision starts from every second node: with nine segments a side it cuts two corners off.
    module = gmsh_quads()
    loops = [np.roll(divided(square(2.0), 9), -turn, axis=0)]
    subdivision = next(s for s in module.settings_for(loops) if s.recombination == 3)
    _, quads = module.mesh_polygon(loops, subdivision)
    _, angle = wanted_valences(loops)
    uses = np.bincount(quads.ravel())[: len(angle)]
    assert (angle / uses < np.radians(150)).all()


@pytest.mark.cad
def test_many_holes_as_one_curve_give_the_quads_of_a_curve_each(monkeypatch):
    module = gmsh_quads()
    angles = -2 * np.pi * np.arange(16) / 16
    hole = 0.25 * np.column_stack([np.cos(angles), np.sin(angles)])
    middles = np.stack(np.divmod(np.arange(25), 5), axis=1) - 2.0
    loops = [divided(square(5.0), 40), *(hole + middle for middle in middles)]
    loops[0] -= (loops[0].min(axis=0) + loops[0].max(axis=0)) / 2
    setting = next(s for s in module.settings_for(loops) if s.recombination == 3)
    together = module.mesh_polygon(loops, setting)
    monkeypatch.setattr(module, "_MANY_LOOPS", len(loops) + 1)
    apart = module.mesh_polygon(loops, setting)
    assert quad_areas(np.concatenate([*loops, together[0]]), together[1]) == pytest.approx(
        sum(polygon_area(loop) for loop in loops), rel=1e-12
    )
    for one, other in zip(together, apart, strict=True):
        assert one.tobytes() == other.tobytes()


@pytest.mark.cad
def test_the_same_polygon_gives_the_same_bytes():
    module = gmsh_quads()
    loops = [divided(l_shape(), 8)]
    first, second = (module.mesh_polygon(loops, module.settings_for(loops)[0]) for _ in range(2))
    assert first[0].tobytes() == second[0].tobytes()
    assert first[1].tobytes() == second[1].tobytes()


@pytest.mark.cad
@pytest.mark.parametrize(("outline", "n_around"), [(l_shape(), 6), (square(3.0), 12), (l_shape(), 7)])
def test_caps_with_a_hole(outline, n_around):
    gmsh_quads()
    hole = 0.3 * square()[::-1] + outline.min(axis=0) + 0.5
    sweep = polygon_prism([outline, hole], [raised(0), raised(2)])
    around = [n_around] * len(outline) + [2, 3, 2, 3]
    mesh = mesh_boundary(sweep, count_segments(sweep, around, 3)).source
    check_quads(mesh)
    normals = np.tile([0.0, 0, 1], (len(mesh.points), 1))
    assert corner_sines(mesh.points, mesh.quads, normals).min() > 0.3
    area = polygon_area(outline) + polygon_area(hole)
    assert quad_areas(mesh.points[:, :2], mesh.quads) == pytest.approx(area, rel=1e-12)


@pytest.mark.cad
def test_an_odd_loop_is_refused_by_name():
    gmsh_quads()
    sweep = polygon_prism([l_shape()], [raised(0), raised(2)])
    with pytest.raises(SurfaceMeshError, match=r"face 6 .* 13 boundary segments; .* even"):
        mesh_boundary(sweep, count_segments(sweep, [3, 2, 2, 2, 2, 2], 3))


def test_congruent_faces_are_filled_once_and_alike(monkeypatch):
    """Three like floors, one of them turned, and one that is larger."""
    floors = []

    def counted(outline):
        floors.append(outline.face.id)
        return best_quads(outline)

    monkeypatch.setattr(quads, "best_quads", counted)
    memory = quads.Memory()
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    made = []
    for matrix, shift in ((np.eye(2), (0, 0)), (np.eye(2), (7, 2)), (turn, (3, -9)), (1.5 * np.eye(2), (0, 0))):
        outline = l_shape() @ matrix.T + shift
        sweep = polygon_prism([outline], [raised(0), raised(1)])
        intervals = count_segments(sweep, 2, 1)
        ring = divided(outline, 2)
        cap = quads.CapBuilder(
            sweep,
            intervals,
            np.column_stack([ring, np.zeros(len(ring))]),
            [np.arange(len(ring))],
            np.full(len(ring), np.nan),
            memory=memory,
        ).build()
        check_quads(cap)
        made.append((matrix, shift, cap))
    assert len(floors) == 2
    first = made[0][2]
    for matrix, shift, cap in made[:3]:
        assert np.array_equal(cap.quads, first.quads)
        np.testing.assert_allclose(cap.points[:, :2], first.points[:, :2] @ matrix.T + shift, atol=1e-12)


@pytest.mark.cad
def test_short_segments_in_one_place_do_not_make_finer_settings_fill_the_whole_polygon_with_them():
    # Most segments, but little of the outline's length, are around a small hole.
    module = gmsh_quads()
    angles = -2 * np.pi * np.arange(60) / 60
    loops = [divided(square(40.0), 10), 1.9 * np.column_stack([np.cos(angles), np.sin(angles)])]
    for setting in (each for each in module.settings_for(loops) if each.size_factor < 1):
        _, quads = module.mesh_polygon(loops, setting)
        _, usual = module.mesh_polygon(loops, replace(setting, size_factor=1.0))
        assert len(quads) < 2 * len(usual) / setting.size_factor**2


@pytest.mark.parametrize("n", [12, 24, 40])
def test_a_hole_that_touches_the_outline_along_a_tangent_is_gone_through_once(n):
    """Where chords of the hole lie inside of the disc's, they are one way around; else they cross, which is refused."""
    angles, own = (2 * np.pi * np.arange(k) / k for k in (24, n))
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    hole = np.array([0.5, 0]) + 0.5 * np.stack([np.cos(own), -np.sin(own)], axis=1)
    hole[0] = circle[0]  # the place where they touch, to the last bit
    loops, order = parted([circle, hole])
    assert sorted(order.tolist()) == list(range(24 + n))
    assert n > 24 or len(loops) == 1
