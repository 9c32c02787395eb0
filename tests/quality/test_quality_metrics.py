"""Metrics of hexes and quads: plain formulas, VTK, invariance, and shapes that must not look good."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.quality import measure_hexes, quad_areas, quad_scaled_jacobians, scaled_jacobians

from . import quality_plain as plain
from .quality_meshes import UNIT_CUBE, hex_soup, random_hexes

NAMES = ("scaled_jacobian", "aspect", "skew", "taper", "condition", "warpage", "volume")
SOME = random_hexes(3001, 0.2)  # three chunks of lanes and a rest
VALID = SOME[plain.scaled_jacobian(SOME) > 0.01]


@pytest.mark.parametrize("name", NAMES)
def test_kernels_compute_the_plain_formulas(name):
    found = getattr(measure_hexes(*hex_soup(VALID)), name)
    np.testing.assert_allclose(found, getattr(plain, name)(VALID), rtol=1e-11, atol=1e-13)


def test_scaled_jacobian_kernel_is_the_same_as_in_the_full_measure():
    points, hexes = hex_soup(SOME)
    assert np.array_equal(scaled_jacobians(points, hexes), measure_hexes(points, hexes).scaled_jacobian)


@pytest.mark.parametrize(
    ("name", "vtk_name"),
    [
        ("scaled_jacobian", "scaled_jacobian"),
        ("aspect", "max_edge_ratio"),
        ("skew", "skew"),
        ("taper", "taper"),
        ("condition", "condition"),
        ("volume", "volume"),
    ],
)
def test_hex_metrics_agree_with_vtk(name, vtk_name):
    pv = pytest.importorskip("pyvista")
    if not hasattr(pv.UnstructuredGrid, "cell_quality"):
        pytest.skip("this pyvista names metrics otherwise")
    points, hexes = hex_soup(VALID)
    grid = pv.UnstructuredGrid({pv.CellType.HEXAHEDRON: hexes}, points)
    expected = grid.cell_quality(vtk_name)[vtk_name]
    np.testing.assert_allclose(getattr(measure_hexes(points, hexes), name), expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("name", "vtk_name"), [("sj", "scaled_jacobian"), ("warpage", "warpage")])
def test_quad_metrics_agree_with_vtk(name, vtk_name):
    pv = pytest.importorskip("pyvista")
    if not hasattr(pv.UnstructuredGrid, "cell_quality"):
        pytest.skip("this pyvista names metrics otherwise")
    points, hexes = hex_soup(VALID)
    if name == "sj":
        quads = hexes[:, :4]
        found = quad_scaled_jacobians(points, quads)
    else:
        quads = hexes[:, plain.QUAD_FACES].reshape(-1, 4)
        found = measure_hexes(points, hexes).warpage
    grid = pv.UnstructuredGrid({pv.CellType.QUAD: quads}, points)
    expected = grid.cell_quality(vtk_name)[vtk_name]
    if name == "warpage":
        expected = expected.reshape(-1, 6).min(axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_cube_is_perfect_wherever_it_lies():
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    for corners in (UNIT_CUBE, 1e-6 * UNIT_CUBE, 1e6 * UNIT_CUBE @ rotation.T + 7e6):
        found = measure_hexes(*hex_soup(corners[None]))
        size = np.linalg.norm(corners[1] - corners[0])
        assert found.scaled_jacobian[0] == pytest.approx(1, abs=1e-9)
        assert found.condition[0] == pytest.approx(1, abs=1e-9)
        assert found.warpage[0] == pytest.approx(1, abs=1e-9)
        assert found.volume[0] == pytest.approx(size**3, rel=1e-9)


def test_mirrored_hexes_have_the_opposite_jacobian():
    mirrored = VALID * [1, 1, -1]
    np.testing.assert_allclose(measure_hexes(*hex_soup(mirrored)).volume, -plain.volume(VALID), atol=1e-12)
    assert np.all(scaled_jacobians(*hex_soup(mirrored)) < 0)


@pytest.mark.parametrize("pair", [(0, 1), (1, 2), (0, 4), (3, 7)])
def test_a_zero_edge_is_never_good(pair):
    corners = UNIT_CUBE.copy()
    corners[pair[0]] = corners[pair[1]]
    found = measure_hexes(*hex_soup(corners[None]))
    assert found.scaled_jacobian[0] <= 0
    assert found.condition[0] == np.inf


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e200])
def test_coordinates_beyond_measure_are_never_good(value):
    corners = UNIT_CUBE.copy()
    corners[6, 1] = value
    points, hexes = hex_soup(corners[None])
    assert scaled_jacobians(points, hexes)[0] <= 0
    assert np.isfinite(scaled_jacobians(points, hexes)[0])
    assert not measure_hexes(points, hexes).bound[0] > 0


def test_all_nodes_at_one_point_are_never_good():
    points, hexes = hex_soup(np.zeros((1, 8, 3)))
    found = measure_hexes(points, hexes)
    assert found.scaled_jacobian[0] <= 0
    assert not found.bound[0] > 0


def test_indices_out_of_range_are_refused():
    points, hexes = hex_soup(UNIT_CUBE[None])
    for wrong in (hexes + 1, hexes - 1):
        with pytest.raises(IndexError):
            scaled_jacobians(points, wrong)


def test_order_2_hexes_are_measured_at_their_corners():
    points, hexes = hex_soup(VALID)
    wide = np.hstack([hexes, np.zeros((len(hexes), 12), dtype=np.int64)])
    assert np.array_equal(scaled_jacobians(points, wide), scaled_jacobians(points, hexes))


def test_quads_are_signed_by_their_own_normal_in_space_and_by_orientation_in_the_plane():
    square = np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    forward, backward = np.array([[0, 1, 2, 3]]), np.array([[3, 2, 1, 0]])
    assert quad_scaled_jacobians(square, forward)[0] == pytest.approx(1)
    assert quad_scaled_jacobians(square, backward)[0] == pytest.approx(1)
    assert quad_scaled_jacobians(square[:, :2], forward)[0] == pytest.approx(1)
    assert quad_scaled_jacobians(square[:, :2], backward)[0] == pytest.approx(-1)
    dart = np.array([[0.0, 0, 0], [2, 0, 0], [0.3, 0.3, 0], [0, 2, 0]])
    assert quad_scaled_jacobians(dart, forward)[0] < 0
    folded = square.copy()
    folded[1] = folded[0]
    assert quad_scaled_jacobians(folded, forward)[0] <= 0
    folded[1, 2] = np.nan
    assert quad_scaled_jacobians(folded, forward)[0] == -1


def test_area_of_flat_quads_is_exact_and_of_a_saddle_is_its_integral():
    flat = np.array([[0.0, 0, 0], [3, 0, 0], [2, 2, 0], [0, 1, 0]])
    x, y = flat[:, 0], flat[:, 1]
    shoelace = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    assert quad_areas(flat, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(shoelace, rel=1e-12)
    # z = s t over the unit square: the integral of sqrt(1 + s^2 + t^2), here by a fine midpoint rule.
    saddle = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]])
    s, t = np.meshgrid((np.arange(400) + 0.5) / 400, (np.arange(400) + 0.5) / 400)
    assert quad_areas(saddle, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(np.sqrt(1 + s**2 + t**2).mean(), rel=1e-6)


@pytest.mark.parametrize("turn", [1e-3, 0.05, 0.2, 1.0, 2.5])
def test_area_of_a_long_strip_that_is_wrung(turn):
    # Straight lines between two edges of length w, h apart, one turned by an angle: the bilinear surface, whose
    # area is the integral of |du x dv|; here by a midpoint rule of 2,000 x 2,000 cells.
    w, h = 0.3, 2.0
    quad = np.array(
        [[-w, 0, 0], [w, 0, 0], [w * np.cos(turn), w * np.sin(turn), h], [-w * np.cos(turn), -w * np.sin(turn), h]]
    )
    s = (np.arange(2000) + 0.5) / 2000
    a, b, c, d = quad
    du = (b - a) + s[:, None] * (c - d - b + a)
    dv = (d - a) + s[:, None] * (c - b - d + a)
    area = np.mean(np.linalg.norm(np.cross(du[:, None], dv[None]), axis=2))
    assert quad_areas(quad, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(area, rel=1e-6)
