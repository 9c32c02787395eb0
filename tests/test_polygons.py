"""Closed polygons one after the other: the corner after each, and the lengths beside it."""

import numpy as np

from cadsweep.polygons import mean_sides, next_corners


def test_the_corners_after_run_around_each_polygon_by_itself():
    loops = [np.zeros((n, 2)) for n in (3, 1, 4)]
    assert next_corners(loops).tolist() == [1, 2, 0, 3, 5, 6, 7, 4]


def test_a_corner_has_the_mean_of_the_sides_beside_it():
    rectangle = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]])
    triangle = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])
    assert mean_sides([rectangle, triangle]).tolist() == [2.0, 2.0, 2.0, 2.0, 3.5, 4.0, 4.5]
