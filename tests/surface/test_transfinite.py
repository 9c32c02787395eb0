"""Filling logical rectangles: what is reproduced exactly, and what is mended."""

import numpy as np
import pytest

from cadsweep.surface.sides import slide_rows
from cadsweep.surface.spacing import divide_like, fit_linear_parts, graded_places
from cadsweep.surface.transfinite import (
    blend_variables,
    chain_fractions,
    fill,
    interpolate,
    solve_winslow,
    worst_corner,
)

from .surface_shapes import Bilinear, Plane

UP = np.array([0.0, 0.0, 1.0])


def lifted(plane_points):
    return np.concatenate([plane_points, np.zeros((*plane_points.shape[:-1], 1))], axis=-1)


def chains_of(grid):
    return grid[0], grid[:, -1], grid[-1], grid[:, 0]


def plane():
    surface = Plane(np.zeros(3), UP)
    surface.frame = np.eye(3)[:2]
    return surface


@pytest.mark.parametrize("grading", [1.0, 3.0, 0.2])
def test_a_bilinear_patch_with_graded_chains_is_reproduced(grading):
    surface = Bilinear((0, 0, 0), (2, 0, 0), (3, 2, 0), (-0.5, 1, 0))
    u, v = graded_places(7, grading), graded_places(5, 1 / grading)
    uv = np.stack(np.meshgrid(u, v), axis=-1)
    grid = surface.evaluate(uv.reshape(-1, 2)).reshape(*uv.shape[:2], 3)
    points, filled_uv, worst = fill(surface, chains_of(uv), chains_of(grid))
    assert np.abs(points - grid).max() < 1e-14
    assert np.abs(filled_uv - uv).max() < 1e-14
    assert worst > 0.3


def test_blend_variables_meet_the_four_chains():
    rng = np.random.default_rng(2)

    def rising(n):
        return np.concatenate([[0], np.sort(rng.uniform(0, 1, n - 2)), [1]])

    b, t, left, right = rising(6), rising(6), rising(4), rising(4)
    xi, eta = blend_variables(b, right, t, left)
    assert np.array_equal(xi[0], b)
    assert np.allclose(xi[-1], t, atol=1e-15)
    assert np.array_equal(eta[:, 0], left)
    assert np.allclose(eta[:, -1], right, atol=1e-15)


def test_interpolation_meets_its_chains():
    rng = np.random.default_rng(3)
    corners = rng.normal(size=(2, 2, 3))
    grid = rng.normal(size=(5, 8, 3))
    grid[0, 0], grid[0, -1], grid[-1, 0], grid[-1, -1] = corners.reshape(4, 3)
    chains = chains_of(grid)
    xi, eta = np.meshgrid(np.linspace(0, 1, 8), np.linspace(0, 1, 5))
    filled = interpolate(chains, xi, eta)
    for got, chain in zip(chains_of(filled), chains, strict=True):
        assert np.allclose(got, chain, atol=1e-14)


def folded_outline(depth):
    """A unit square with a dent from above and one from the left: plain interpolation folds."""
    s = np.linspace(0, 1, 21)
    t = s[::2]
    top = np.column_stack([s, 1 - depth * np.exp(-(((s - 0.5) / 0.12) ** 2))])
    left = np.column_stack([0.3 * np.sin(np.pi * t), t])
    return np.column_stack([s, 0 * s]), np.column_stack([1 + 0 * t, t]), top, left


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("depth", [0.5, 0.8])
def test_a_folded_filling_is_unfolded(depth, side):
    chains = folded_outline(depth)
    chains[2][[0, -1], 1] = 1.0  # the dent's tail, so that the chains meet
    fractions = [chain_fractions(chain) for chain in chains]
    plain = lifted(interpolate(chains, *blend_variables(*fractions)))
    assert worst_corner(plain, np.broadcast_to(UP, plain.shape), plain[..., :2]) < -0.4
    surface = plane() if side > 0 else Downwards()
    points, uv, worst = fill(surface, chains, tuple(lifted(chain) for chain in chains), side=side)
    assert worst > 0.05
    assert worst_corner(points, np.broadcast_to(UP, points.shape), uv) == pytest.approx(worst)
    assert np.abs(surface.evaluate(uv.reshape(-1, 2)) - points.reshape(-1, 3)).max() < 1e-12


class Downwards(Plane):
    """The same plane, seen as the bottom of a solid."""

    def __init__(self):
        super().__init__(np.zeros(3), UP)
        self.frame = np.eye(3)[:2]

    def normals(self, uv):
        return -super().normals(uv)


def test_winslow_leaves_a_rectangle_alone_and_unfolds_a_moved_inside():
    x, y = np.meshgrid(np.linspace(0, 3, 9), np.linspace(0, 1, 6))
    grid = np.stack([x, y], axis=-1)
    assert np.abs(solve_winslow(grid) - grid).max() < 1e-12
    moved = grid.copy()
    moved[1:-1, 1:-1] += np.random.default_rng(0).uniform(-0.3, 0.3, moved[1:-1, 1:-1].shape)
    assert np.abs(solve_winslow(moved, n_steps=100, tolerance=1e-10) - grid).max() < 1e-4


def test_worst_corner_knows_the_side_it_is_seen_from():
    x, y = np.meshgrid(np.linspace(0, 1, 4), np.linspace(0, 1, 3))
    grid = lifted(np.stack([x, y], axis=-1))
    assert worst_corner(grid, np.broadcast_to(UP, grid.shape), grid[..., :2]) == pytest.approx(1)
    assert worst_corner(grid, np.broadcast_to(-UP, grid.shape), grid[..., :2]) == pytest.approx(-1)


def test_dividing_like_an_affine_image_is_exact_on_that_image():
    # A quarter of a circle goes to a quarter of an ellipse: nodes go to the images of nodes.
    a = np.diag([3.0, 0.5, 1.0])
    n, m = 8, 64

    def circle(t):
        return np.column_stack([np.cos(t), np.sin(t), 0 * t])

    fine = circle(np.linspace(0, np.pi / 2, n * m + 1))
    fractions = divide_like(np.diff(fine, axis=0).reshape(n, m, 3), a)
    dense = circle(np.linspace(0, np.pi / 2, 200_001)) @ a.T
    lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    wanted = lengths[:: 200_000 // n] / lengths[-1]
    assert np.abs(fractions - wanted).max() < 1e-5
    assert (np.diff(divide_like(np.diff(fine, axis=0).reshape(n, m, 3), np.zeros((3, 3)))) > 0).all()


def test_linear_parts_are_least_squares():
    rng = np.random.default_rng(5)
    ring, matrices = rng.normal(size=(30, 3)), rng.normal(size=(4, 3, 3))
    rings = ring @ matrices.transpose(0, 2, 1) + rng.normal(size=(4, 1, 3))
    assert np.abs(fit_linear_parts(ring, rings) - matrices).max() < 1e-12


def test_rows_that_stand_right_are_left_alone_and_others_keep_their_order():
    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 5))
    grid = lifted(np.stack([x, y], axis=-1))
    even = np.tile(np.linspace(0, 1, 9), (5, 1))
    assert slide_rows(grid, even) is None
    wanted = even.copy()
    wanted[2] = graded_places(8, 500.0)
    present, new = slide_rows(grid, wanted)
    assert np.array_equal(new[[0, -1]], present[[0, -1]])
    assert (np.diff(new, axis=1) > 0).all()


@pytest.mark.parametrize("n", [1, 2, 7])
@pytest.mark.parametrize("bias", [None, 1.0, 20.0, 0.05, (3.0, 1.0), (10.0, 10.0)])
def test_places_rise_from_nought_to_one(n, bias):
    places = graded_places(n, bias)
    assert places[0] == 0
    assert places[-1] == 1
    assert (np.diff(places) > 0).all()


def test_quads_that_cut_a_sharp_tip_off_are_not_folded_there():
    """A wall around a thin section, no node at its tips: the normals turn by half a circle along one chord."""
    at = 2 * np.pi * (np.arange(13) + 0.5) / 12
    section = np.column_stack([np.cos(at), 0.01 * np.sin(at)])
    normals = np.column_stack([0.01 * np.cos(at), np.sin(at), 0 * at])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    height = np.linspace(0, 1, 5)
    points = np.concatenate(
        [np.broadcast_to(section, (5, 13, 2)), np.broadcast_to(height[:, None, None], (5, 13, 1))], 2
    )
    uv = np.stack(np.meshgrid(at, height), axis=-1)
    seen = np.broadcast_to(normals, points.shape)
    assert worst_corner(points, seen, uv) > 0.9
    assert worst_corner(points[:, ::-1], seen[:, ::-1], uv[:, ::-1]) < -0.9
    folded, folded_uv = points.copy(), uv.copy()
    folded[2], folded_uv[2] = points[2, [*range(6), 4, *range(7, 13)]], uv[2, [*range(6), 4, *range(7, 13)]]
    assert worst_corner(folded, seen, folded_uv) < 0
