"""The nearest facets: distances that are known by construction."""

import numpy as np
import pytest

from cadsweep.fitted.facets import Facets, Nearest


@pytest.fixture(scope="module")
def tetrahedron():
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    return Nearest(Facets(points, triangles, np.arange(4)))


def test_a_place_over_a_facet_is_as_far_off_as_it_was_lifted(tetrahedron):
    weights = np.random.default_rng(4).dirichlet(np.full(3, 3.0), size=(4, 50))
    feet = np.einsum("tmc,tcd->tmd", weights, tetrahedron.corners)
    for lift in (0.0, 0.7):
        places = feet + lift * tetrahedron.normals[:, None]
        away, nearest = tetrahedron(places.reshape(-1, 3))
        np.testing.assert_allclose(away, lift, atol=1e-12)
        if lift:
            assert (nearest == np.repeat(np.arange(4), 50)).all()


def test_beyond_an_edge_the_edge_is_nearest_and_beyond_a_corner_the_corner(tetrahedron):
    away, _ = tetrahedron(np.array([[1.0, -3.0, -4.0], [5.0, 0.0, 0.0], [-1.0, -2.0, -2.0]]))
    np.testing.assert_allclose(away, [5.0, 3.0, 3.0])


def test_boxes_of_facets_leave_none_out_that_is_nearest():
    random = np.random.default_rng(9)
    points = random.normal(size=(120, 3))
    triangles = random.permuted(np.arange(120)).reshape(40, 3)
    nearest = Nearest(Facets(points, triangles, np.arange(40)))
    places = 2.0 * random.normal(size=(300, 3))
    alone = [Nearest(Facets(points, triangles[[t]], np.arange(1)))(places)[0] for t in range(40)]
    away, found = nearest(places)
    np.testing.assert_array_equal(away, np.min(alone, axis=0))
    np.testing.assert_array_equal(found, np.argmin(alone, axis=0))
