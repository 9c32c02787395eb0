"""Positive inside: against dense sampling, at the edge of validity, and for order 2."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.quality import measure_hexes, positive_inside, scaled_jacobians

from . import quality_plain as plain
from .quality_meshes import UNIT_CUBE, hex_soup, raised, random_hexes


def grid(n):
    line = np.linspace(0, 1, n)
    return np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3)


SOUP = random_hexes(12_000, 0.3)


def test_a_positive_bound_means_positive_and_a_bad_corner_means_not():
    points, hexes = hex_soup(SOUP)
    found = measure_hexes(points, hexes)
    positive, volumes = positive_inside(points, hexes)
    assert np.all(positive[found.bound > 1e-12])
    assert not np.any(positive[found.scaled_jacobian <= 0])
    np.testing.assert_allclose(volumes, found.volume, atol=1e-12)


def test_undecided_hexes_are_decided_as_dense_sampling_does():
    points, hexes = hex_soup(SOUP)
    found = measure_hexes(points, hexes)
    undecided = np.flatnonzero((found.bound <= 0) & (found.scaled_jacobian > 0))
    positive, _ = positive_inside(points, hexes[undecided])
    sampled = plain.jacobian_at(SOUP[undecided], grid(13)).min(axis=1)
    assert 20 < np.count_nonzero(positive) < len(undecided) - 20  # both kinds are there
    assert np.all(sampled[positive] > 0)  # no false "valid"
    assert np.all(sampled[~positive] < 1e-3)  # no false alarm: the samples miss the least value by a little


@pytest.fixture(scope="module")
def twisted():
    """A hexahedron whose corners are positive while the inside is not."""
    points, hexes = hex_soup(SOUP)
    values = scaled_jacobians(points, hexes)
    candidates = np.flatnonzero((values > 0) & (measure_hexes(points, hexes).bound <= 0))
    bad = candidates[~positive_inside(points, hexes[candidates])[0]]
    return SOUP[bad[0]]


def test_the_edge_of_validity_is_found_where_it_is(twisted):
    def skewed(amount):
        return UNIT_CUBE + amount * (twisted - UNIT_CUBE)

    low, high = 0.0, 1.0  # a cube is valid, the whole way is not
    for _ in range(40):
        middle = (low + high) / 2
        if positive_inside(*hex_soup(skewed(middle)[None]))[0][0]:
            low = middle
        else:
            high = middle
    fine = grid(41)
    assert plain.jacobian_at(skewed(low - 1e-6)[None], fine).min() > 0
    assert plain.jacobian_at(skewed(high + 2e-2)[None], fine).min() < 0


def test_touching_zero_at_one_corner_or_inside_is_not_positive():
    flat = UNIT_CUBE.copy()
    flat[6] = [0.5, 0.5, 1.0]  # corner 6 falls on the diagonal of its face
    assert not positive_inside(*hex_soup(flat[None]))[0][0]


@pytest.mark.parametrize("n_nodes", [20, 27])
def test_straight_order_2_hexes_are_judged_like_their_corners(n_nodes):
    corners = SOUP[:2000]
    nodes = raised(corners, n_nodes)
    positive, volumes = positive_inside(nodes.reshape(-1, 3), np.arange(nodes[..., 0].size).reshape(-1, n_nodes))
    expected, expected_volumes = positive_inside(*hex_soup(corners))
    assert np.array_equal(positive, expected)
    np.testing.assert_allclose(volumes, expected_volumes, atol=1e-12)


@pytest.mark.parametrize(("n_nodes", "node"), [(20, 8), (27, 8), (27, 26), (27, 20)])
def test_a_curved_hex_is_valid_until_its_node_goes_too_far(n_nodes, node):
    nodes = raised(UNIT_CUBE[None], n_nodes)
    hexes = np.arange(n_nodes)[None]

    def judge(shift):
        moved = nodes.copy()
        moved[0, node, 0] += shift
        return positive_inside(moved.reshape(-1, 3), hexes)[0][0]

    assert judge(0.0)
    assert judge(0.1)
    # The middle of an edge of length 1 may move along it by less than a quarter (J = 0 at the end).
    limit = {8: 0.25, 26: 0.25, 20: 0.25}[node]
    assert not judge(limit * 2.5)
    if node == 8:
        assert judge(limit - 1e-3)
        assert not judge(limit + 1e-3)


def test_volume_of_a_curved_hex():
    # The middle of the top face and of its edges raised: x, y stay, z = s h(x, y); the volume is 1 + mean of h.
    nodes = raised(UNIT_CUBE[None], 27)
    nodes[0, 25, 2] += 0.3  # bump 16 x(1-x) y(1-y) * 0.3 on top has the mean 16/36 * 0.3
    nodes[0, 26, 2] += 0.15  # half of it half way up
    _, volumes = positive_inside(nodes.reshape(-1, 3), np.arange(27)[None])
    assert volumes[0] == pytest.approx(1 + 0.3 * 16 / 36, rel=1e-12)
