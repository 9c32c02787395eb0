"""Sizes inside a cap: fine where something is fine, and growing away from it."""

from types import SimpleNamespace

import numpy as np
import pytest

from cadsweep.polygons import is_inside
from cadsweep.surface.background import GROWTH, limited, make_background, triangulated, typical_length
from cadsweep.surface.chart import Chart
from cadsweep.surface.filling import must_grow
from cadsweep.surface.flatten import conformal_map, make_locator


def rectangle(width, height, *, n):
    """Outline of `n` segments a side, counter-clockwise."""
    t = np.arange(n) / n
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], dtype=float)
    return np.concatenate(
        [a + t[:, None] * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    )


@pytest.mark.parametrize("way", [(1.0, 0.0), (3.0, -2.0), (0.1, 0.7)])
def test_places_on_one_line_are_graded_along_it(way):
    at = np.array([3.0, 0.0, 1.0, 2.0, 7.0])
    places = at[:, None] * np.array(way) / np.linalg.norm(way)
    sizes = limited(places, triangulated(places), np.array([9.0, 1.0, 9.0, 9.0, 9.0]), 0.5)
    np.testing.assert_allclose(sizes, 1.0 + 0.5 * at, rtol=1e-12)


def test_sizes_rise_no_faster_than_they_may_and_no_further_than_they_must():
    outline = rectangle(10.0, 10.0, n=10)
    small = np.array([4.3, 6.1])
    field = make_background([outline], largest=1.0, sizes_at=lambda p: 0.05 + np.linalg.norm(p - small, axis=1))
    ends = np.concatenate([field.triangles[:, [0, 1]], field.triangles[:, [1, 2]], field.triangles[:, [2, 0]]])
    ways = np.linalg.norm(np.subtract(*field.places[ends.T]), axis=1)
    rises = np.abs(np.subtract(*field.sizes[ends.T]))
    assert np.all(rises <= (GROWTH - 1.0) * ways * (1 + 1e-9))
    assert field.sizes.max() == pytest.approx(1.0)
    # Ways along the edges are no shorter than straight ones, so no size is below the cone over the smallest.
    away = np.linalg.norm(field.places - small, axis=1)
    assert np.all(
        field.sizes >= np.minimum(0.05 + (GROWTH - 1.0) * away, 1.0) - 0.3 * ways.max() * (GROWTH - 1.0) - 1e-9
    )


def test_limited_sizes_that_rise_slowly_stay():
    places = np.random.default_rng(1).random((50, 2))
    from scipy.spatial import Delaunay

    triangles = Delaunay(places).simplices.astype(np.int64)
    sizes = 1.0 + 0.2 * places[:, 0]
    assert limited(places, triangles, sizes, 0.3) == pytest.approx(sizes, abs=1e-12)


def test_places_in_a_hole_are_outside():
    loops = [rectangle(4.0, 4.0, n=3), (rectangle(2.0, 2.0, n=2) + 1.0)[::-1]]
    places = np.array([[0.5, 0.5], [2.0, 2.0], [3.5, 2.0], [5.0, 1.0], [-1.0, 1.0]])
    assert is_inside(loops, places).tolist() == [True, False, True, False, False]


def test_the_typical_segment_is_that_of_half_the_outline():
    fine = np.column_stack([np.linspace(0.0, 1.0, 11)[:-1], np.zeros(10)])
    outline = np.concatenate([fine, [[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]])
    assert typical_length([outline]) == 1.0


def grid_triangles(n):
    ids = np.arange(n * n).reshape(n, n)
    a, b, c, d = ids[:-1, :-1].ravel(), ids[1:, :-1].ravel(), ids[1:, 1:].ravel(), ids[:-1, 1:].ravel()
    return np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def test_what_can_be_unrolled_is_unrolled_exactly():
    # A quarter of a cylinder is isometric to a rectangle: the conformal map is that, whatever its size.
    n = 9
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    plane = np.stack([2.0 * u.ravel() + v.ravel(), 1.5 * v.ravel()], axis=1)
    triangles = grid_triangles(n)
    bent = np.stack([plane[:, 0], plane[:, 1], np.zeros(n * n)], axis=1)
    turn, _ = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))
    flat = conformal_map(bent @ turn.T, triangles)
    for i, j in ((0, 1), (5, 40), (8, 72), (3, 77)):
        assert np.linalg.norm(flat[i] - flat[j]) == pytest.approx(np.linalg.norm(plane[i] - plane[j]), rel=1e-9)


def test_angles_of_a_hemisphere_stay():
    n = 41
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    x, y = (u * np.sqrt(1 - v**2 / 2)).ravel(), (v * np.sqrt(1 - u**2 / 2)).ravel()
    # A dome as high as the disc's radius, cut just above its equator.
    points = np.stack([x, y, np.sqrt(np.maximum(1.02 - x**2 - y**2, 0.0))], axis=1)
    flat = conformal_map(points, grid_triangles(n))
    inside = np.arange(n * n).reshape(n, n)[5:-5, 5:-5].ravel()
    for step in (1, n):
        across, along = points[inside + step] - points[inside], flat[inside + step] - flat[inside]
        other = points[inside + n + 1 - step] - points[inside], flat[inside + n + 1 - step] - flat[inside]
        stretch = np.linalg.norm(along, axis=1) / np.linalg.norm(across, axis=1)
        elsewhere = np.linalg.norm(other[1], axis=1) / np.linalg.norm(other[0], axis=1)
        assert np.abs(np.log(stretch / elsewhere)).max() < 0.1


def test_places_are_found_in_the_triangle_around_them():
    n = 6
    u, v = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    flat = np.stack([u.ravel(), v.ravel() + 0.2 * u.ravel() ** 2], axis=1)
    places = flat[grid_triangles(n)].mean(axis=1)
    nodes, weights = make_locator(flat, grid_triangles(n))(places)
    assert np.einsum("mk,mkd->md", weights, flat[nodes]) == pytest.approx(places, abs=1e-12)


def test_inside_is_what_the_parity_of_all_crossings_says():
    """Held against every place and every segment, with places at the heights of nodes."""
    rng = np.random.default_rng(5)
    loops = [rectangle(10.0, 10.0, n=7), (rectangle(2.0, 3.0, n=4) + [1.0, 2.0])[::-1], rectangle(1.5, 1.5, n=3) + 6.0]
    places = np.concatenate([12.0 * rng.random((500, 2)) - 1.0, np.array([[0.3, 2.0], [5.0, 2.75], [6.5, 7.0]])])
    starts = np.concatenate(loops)
    ends = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops])
    wanted = []
    for x, y in places:
        crossed = (starts[:, 1] > y) != (ends[:, 1] > y)
        s, e = starts[crossed], ends[crossed]
        wanted.append(
            np.count_nonzero(x < s[:, 0] + (y - s[:, 1]) / (e[:, 1] - s[:, 1]) * (e[:, 0] - s[:, 0])) % 2 == 1
        )
    assert np.array_equal(is_inside(loops, places), wanted)
    assert not is_inside(loops, np.empty((0, 2))).size


def dented(n_dents):
    """Nodes of a square of side 300 whose sides have dents of radius 1 in twelve segments, and segments of 10."""
    dent = np.linspace(np.pi, 0.0, 13)
    side = [np.column_stack([np.arange(0.0, 300.0, 10.0), np.zeros(30)])]
    for middle in 10.0 * np.round(np.linspace(1, 28, n_dents)) + 5.0 if n_dents else ():
        side.append(np.column_stack([middle + np.cos(dent), np.sin(dent)]))
    points = np.concatenate(side)
    points = points[np.argsort(points[:, 0], kind="stable")]
    turns = [np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), k) for k in range(4)]
    return np.concatenate([(points - 150.0) @ turn.T for turn in turns])


@pytest.mark.parametrize(("n_dents", "grow"), [(0, False), (14, True)])
def test_quads_grow_away_from_small_dents_whatever_mirrors_there_are(n_dents, grow):
    loops = [dented(n_dents)]
    outline = SimpleNamespace(
        nodes=loops,
        charts=lambda _: iter(
            [Chart(boundary=tuple(loops), boundary_uv=loops[0], lift=lambda places: (places, places))]
        ),
        background=lambda chart, _: make_background(chart.boundary, largest=10.0),
    )
    assert must_grow(outline) is grow
