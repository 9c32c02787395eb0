"""Where points lie in a lattice, by its cells: what triangles of its nodes say."""

import numpy as np
import pytest
import scipy

from cadsweep.surface import pierced


@pytest.mark.parametrize("shear", [0.0, 0.4])
def test_places_by_cells_are_those_of_the_affine_map_that_made_the_lattice(shear):
    places = np.argwhere(np.ones((30, 20), dtype=bool))
    nodes = places @ np.array([[0.5, shear], [0.0, 0.4]])
    wanted = np.random.default_rng(0).uniform(1.0, 18.0, (300, 2))
    found = pierced._in_cells(wanted @ np.array([[0.5, shear], [0.0, 0.4]]), scipy.spatial.cKDTree(nodes), places)
    assert found == pytest.approx(wanted, abs=1e-12)


def test_points_beyond_the_lattice_have_no_place():
    places = np.argwhere(np.ones((5, 5), dtype=bool))
    beyond = np.array([[-0.1, 2.0], [2.0, 4.1], [9.0, 9.0]])
    assert np.isnan(pierced._in_cells(beyond, scipy.spatial.cKDTree(places.astype(float)), places)).all()


@pytest.mark.parametrize("shear", [0.0, 0.4])
def test_an_even_lattice_says_without_triangles_where_points_lie(shear):
    places = np.argwhere(np.ones((12, 9), dtype=bool))
    steps, origin = np.array([[0.5, shear], [0.1, 0.4]]), np.array([3.0, -7.0])
    nodes = origin + places @ steps
    even = pierced._even_lattice(nodes, places)
    assert even is not None
    wanted = np.random.default_rng(0).uniform(0.5, 7.5, (40, 2))
    at = origin + wanted @ steps
    assert (at - even[0]) @ even[1] == pytest.approx(wanted, abs=1e-9)
    assert pierced._interpolated(at, nodes, places) == pytest.approx(wanted, abs=1e-9)


def test_a_lattice_that_is_bent_or_flat_is_not_even():
    places = np.argwhere(np.ones((12, 9), dtype=bool))
    bent = places.astype(float)
    bent[40] += 1e-3
    assert pierced._even_lattice(bent, places) is None
    assert pierced._even_lattice(places @ np.array([[1.0, 1.0], [1.0, 1.0]]), places) is None


def test_the_best_begin_of_a_ring_is_found_among_all():
    turn = 2.0 * np.pi * np.arange(24) / 24
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    apart = pierced._apart(ring, np.roll(ring, -7, axis=0), np.arange(24))
    assert int(np.argmin(apart)) == 7
    assert apart[7] == 0.0
