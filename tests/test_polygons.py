"""Closed polygons one after the other: the corner after each, and the lengths beside it."""

import numpy as np

from cadsweep.polygons import mean_sides, next_corners, signed_area, signed_areas


def test_the_corners_after_run_around_each_polygon_by_itself():
    loops = [np.zeros((n, 2)) for n in (3, 1, 4)]
    assert next_corners(loops).tolist() == [1, 2, 0, 3, 5, 6, 7, 4]


def test_a_corner_has_the_mean_of_the_sides_beside_it():
    rectangle = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])
    triangle = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])
    assert mean_sides([rectangle, triangle]).tolist() == [2.0, 2.0, 2.0, 2.0, 3.5, 4.0, 4.5]


def test_areas_of_many_polygons_are_those_of_each():
    rng = np.random.default_rng(7)
    polygons = [1e4 + rng.standard_normal((m, 2)) for m in (3, 8, 1, 5)]
    found = signed_areas(np.concatenate(polygons), np.cumsum([len(polygon) for polygon in polygons]))
    np.testing.assert_allclose(found, [signed_area(polygon) for polygon in polygons], atol=1e-10)
