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
