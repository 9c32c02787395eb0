"""Smoothing mends what can be mended, touches nothing else, and never makes a mesh worse."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.cells import sweep_hexes
from cadsweep.quality import boundary_limit, corner_limits, positive_inside, scaled_jacobians
from cadsweep.smoothing import improve
from cadsweep.smoothing.cutting import grown, hex_nodes, patches
from cadsweep.smoothing.energy import hex_energy

from .smoothing_meshes import block, closed_ring, disturbed, domed_bend, folded_angle, swept_grid


def after(points, smoothed):
    result = points.copy()
    result[smoothed.nodes] = smoothed.positions
    return result


def hexes_of(structure):
    return sweep_hexes(structure.quads, structure.n_nodes, structure.n_layers, periodic=structure.periodic)


def values_of(points, structure):
    return scaled_jacobians(points, hexes_of(structure))


def test_a_good_mesh_is_left_alone():
    points, structure, fixed = block()
    smoothed = improve(points, structure, fixed=fixed)
    assert len(smoothed.nodes) == 0
    assert smoothed.steps == ()
    assert smoothed.before == smoothed.after == pytest.approx(1)


MESHES = {"block": block, "domed bend": domed_bend, "ring": closed_ring}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("amount", [0.1, 0.3, 1.0])
@pytest.mark.parametrize("make", MESHES.values(), ids=MESHES)
def test_any_disturbance_of_the_inside_is_mended(make, amount, seed):
    points, structure, fixed = disturbed(make(), amount, seed)
    given = points.copy()
    smoothed = improve(points, structure, fixed=fixed)
    assert np.array_equal(points, given)  # the argument is not changed
    mended = after(points, smoothed)
    values = values_of(mended, structure)
    assert values.min() == pytest.approx(smoothed.after)
    assert smoothed.after >= min(0.3, 0.9 * boundary_limit(points, structure).value)
    assert smoothed.n_inverted_after == 0
    assert np.all(positive_inside(mended, hexes_of(structure))[0])
    assert np.array_equal(mended[fixed], points[fixed])  # bit for bit


def test_layers_that_an_affine_map_folds_are_mended():
    # An angle whose arms grow and shrink again: both caps are fine, the layers between them fold at the corner.
    points, structure, fixed = folded_angle()
    smoothed = improve(points, structure, fixed=fixed)
    assert smoothed.before < 0
    assert smoothed.after >= 0.3
    assert len(smoothed.nodes) < 0.6 * np.count_nonzero(~fixed)


def test_only_the_neighbourhood_of_bad_hexes_moves():
    points, structure, fixed = block(12, 12)
    centre = 6 * structure.n_nodes + 6 * 13 + 6
    points[centre] += [0.3, 0.25, 0.3]  # nearly two quads of size 1/6
    smoothed = improve(points, structure, fixed=fixed)
    assert smoothed.before < 0
    assert smoothed.after >= 0.3
    distance = np.abs(points[smoothed.nodes] - [0, 0, 1]).max(axis=1)
    assert np.all(distance <= 0.34 + 4 / 6)
    assert len(smoothed.nodes) < 0.4 * np.count_nonzero(~fixed)


def test_graded_layers_stay_graded():
    # Layers that grow by 1.7 each: the disturbed ones come back near their heights, not to even ones.
    steps = 1.7 ** np.arange(8)
    heights = np.r_[0, np.cumsum(steps)] / steps.sum() * 2
    points, structure, fixed = block(8, 8, heights=heights)
    disturbed_points = points.copy()
    n = structure.n_nodes
    inner = np.flatnonzero(~fixed)
    thin = inner[(inner // n >= 1) & (inner // n <= 3)]
    disturbed_points[thin, 2] += np.random.default_rng(0).normal(size=len(thin)) * 0.06
    smoothed = improve(disturbed_points, structure, fixed=fixed)
    assert smoothed.before < 0
    assert smoothed.after >= 0.3
    mended = after(disturbed_points, smoothed)
    levels = mended[:, 2].reshape(-1, n)[:, ~fixed.reshape(-1, n)[1]].mean(axis=1)
    np.testing.assert_allclose(np.diff(levels)[:3] / np.diff(heights)[:3], 1, atol=0.25)


def test_a_folded_boundary_is_not_made_worse_and_said_to_be_hopeless():
    # A corner of the source is pulled across its quad: no inner node can mend the hexahedra on it.
    points, structure, fixed = block(5, 4)
    points[7] += [-0.7, -0.7, 0.0]
    limit = boundary_limit(points, structure)
    smoothed = improve(points, structure, fixed=fixed)
    assert limit.value < 0
    assert smoothed.after >= smoothed.before
    assert smoothed.after <= limit.value


def test_a_hex_with_a_bad_fixed_corner_does_not_stop_the_mending_of_others():
    points, structure, fixed = block(8, 8)
    # Rings of the sheared corner column limit some hexes to a poor value; others are merely disturbed.
    points[np.flatnonzero(np.all(points == [-1, -1, 0], axis=1))] += [0.11, 0.11, 0.0]
    limit = boundary_limit(points, structure).value
    assert 0 < limit < 0.3
    bad, structure, fixed = disturbed((points, structure, fixed), 0.12)
    smoothed = improve(bad, structure, fixed=fixed)
    values = values_of(after(bad, smoothed), structure)
    assert smoothed.after >= 0.9 * limit
    assert np.count_nonzero(values < 0.3) <= 3  # the hexahedra at that corner


def test_meshes_without_inner_nodes():
    points, structure, fixed = swept_grid(1, 3, lambda t, xy: np.c_[xy + 3 * t, np.full(len(xy), 1 + 0 * t)])
    smoothed = improve(points, structure, fixed=fixed)
    assert len(smoothed.nodes) == 0
    assert smoothed.after == smoothed.before


@pytest.mark.parametrize(("power", "amplitude", "wanted"), [(0.0, 0.5, 1.0), (8.0, 0.08, 1.0), (8.0, 0.08, 150.0)])
def test_the_gradient_is_that_of_the_energy(power, amplitude, wanted):
    # Edges of 1 that should be 150 long are short.
    rng = np.random.default_rng(1)
    points, structure, _ = block(2, 2)
    x = points + rng.normal(size=points.shape) * amplitude
    hexes = sweep_hexes(structure.quads, structure.n_nodes, 2)
    inverse = rng.uniform(0.5, 2, size=(len(hexes), 3)) / wanted
    free = np.ones(len(x), dtype=bool)

    def energy(y):
        gradient = np.zeros_like(y)
        return hex_energy(y, hexes, free, inverse, gradient, 0.2, 0.1, power, 0.5)[0], gradient

    _, gradient = energy(x)
    for i, c in rng.integers((len(x), 3), size=(12, 2)):
        step = np.zeros_like(x)
        step[i, c] = 1e-6
        slope = (energy(x + step)[0] - energy(x - step)[0]) / 2e-6
        assert slope == pytest.approx(gradient[i, c], rel=1e-4, abs=1e-4 * np.abs(gradient).max())


@pytest.mark.parametrize("power", [4.0, 16.0, 64.0])
def test_a_vanishing_edge_is_worse_than_a_poor_corner(power):
    # A box has right angles, however thin it is: polishing would push nodes upon each other to mend a corner elsewhere.
    points, structure, _ = block(1, 1)
    hexes, free = hexes_of(structure), np.ones(len(points), dtype=bool)

    def energy(x):
        inverse, weight = np.full((1, 3), 0.5), 0.05
        return hex_energy(x, hexes, free, inverse, np.zeros_like(x), 1e-9, weight, power, weight)[0]

    sheared = points @ np.array([[1.0, 0, 0], [10.0, 1, 0], [0, 0, 1]])
    assert values_of(sheared, structure).min() < 0.1
    assert [energy(points * [share, 1, 1]) > energy(sheared) for share in (1.0, 0.1, 1e-3, 1e-4)] == [
        False, False, True, True
    ]  # fmt: skip


def test_patches_and_their_growth():
    _, structure, _ = block(6, 6)
    marked = np.zeros((6, 36), dtype=bool)
    marked[0, 0] = marked[5, 35] = True
    assert [len(p) for p in patches(marked, structure)] == [1, 1]
    wide = grown(marked, structure, 1)
    assert np.count_nonzero(wide) == 2 * 2**3  # corners of the block: one ring more in each direction
    assert np.all(grown(marked, structure, 6))
    ids = np.flatnonzero(wide.ravel())
    expected = sweep_hexes(structure.quads, structure.n_nodes, 6)[ids]
    assert np.array_equal(hex_nodes(structure, ids), expected)


def test_what_fixed_nodes_allow():
    points, structure, fixed = block(3, 3)
    hexes = hexes_of(structure)
    assert np.all(corner_limits(points, hexes, fixed) == pytest.approx(1))
    # The cap's quad at a node in the middle of its first edge loses its right angles: three fixed nodes at each corner.
    points[1] += [0.1, 0.15, 0.0]
    bounds = corner_limits(points, hexes, fixed)
    inner = points.copy()
    for seed in range(20):
        rng = np.random.default_rng(seed)
        inner[~fixed] = points[~fixed] + rng.normal(size=(np.count_nonzero(~fixed), 3)) * 0.05
        assert np.all(values_of(inner, structure) <= bounds + 1e-12)
    assert bounds[:2].max() < 0.98
    assert bounds.min() == pytest.approx(min(bounds[:2]))


def test_hexes_at_their_limit_are_left_alone():
    # A corner of the cap is pulled in: two of its hexahedra are as good as their fixed nodes allow, and poor.
    points, structure, fixed = block(6, 6)
    points[0] += [0.29, 0.29, 0.0]
    values, bounds = values_of(points, structure), corner_limits(points, hexes_of(structure), fixed)
    assert values.min() < 0.3
    assert values[0] == pytest.approx(bounds[0])
    smoothed = improve(points, structure, fixed=fixed)
    assert smoothed.steps == ()
    assert len(smoothed.nodes) == 0


def test_without_time_what_is_inverted_is_mended_and_what_is_valid_is_not_polished():
    points, structure, fixed = disturbed(block(), 1.0)
    assert values_of(points, structure).min() < 0
    smoothed = improve(points, structure, fixed=fixed, is_over=lambda is_valid: is_valid)
    assert smoothed.n_inverted_after == 0
    assert not any(step.startswith("polish ") for step in smoothed.steps)


def test_what_is_inverted_stays_so_where_it_is_told_to():
    points, structure, fixed = disturbed(block(), 1.0)
    smoothed = improve(points, structure, fixed=fixed, is_over=lambda is_valid: True)
    assert not len(smoothed.nodes)
    assert smoothed.n_inverted_after == smoothed.n_inverted_before > 0
