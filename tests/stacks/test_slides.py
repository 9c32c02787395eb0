"""Nodes that slide on the faces of a stack stay on them, wherever smoothing has put them."""

import numpy as np

from cadsweep.stack_mesh import Slides


def test_what_may_not_rise_keeps_its_height_and_what_may_does_not():
    up = np.array([1.0, 0.0, 0.0])
    slides = Slides(
        mask=np.array([True, True, False]),
        up=up,
        rises=np.array([False, True, False]),
        curve=np.full(3, -1),
        curves={},
    )
    start = np.zeros((3, 3))
    moved = np.array([[0.3, 1.0, 2.0]] * 3)
    held = slides.snapped(np.arange(3), moved, start)
    assert np.array_equal(held[0], [0.0, 1.0, 2.0])  # a cap's
    assert np.array_equal(held[1:], moved[1:])  # a wall's, and one inside


class _Segment:
    """A straight edge that leans: a step along it rises by two."""

    def evaluate(self, fractions):
        return fractions[:, None] * np.array([1.0, 0.0, 2.0])

    def project(self, points):
        return np.clip(points @ np.array([1.0, 0.0, 2.0]) / 5.0, 0.0, 1.0)


def test_on_a_wall_under_a_leaning_rim_the_place_in_plan_is_what_counts():
    slides = Slides(
        mask=np.ones(2, dtype=bool),
        up=np.array([0.0, 0.0, 1.0]),
        rises=np.ones(2, dtype=bool),
        curve=np.zeros(2, dtype=np.int64),
        curves={0: _Segment()},
    )
    nodes, wall = np.arange(2), np.array([[0.4, 0.0, 0.5], [0.7, 0.0, 1.9]])
    np.testing.assert_allclose(slides.snapped(nodes, wall, wall), wall, atol=1e-12)
    beside = wall + np.array([0.0, 0.1, 0.0])
    np.testing.assert_allclose(slides.snapped(nodes, beside, wall), wall, atol=1e-12)
    along = slides.projectors(nodes, wall)
    np.testing.assert_allclose(along, np.broadcast_to(np.diag([1.0, 0.0, 1.0]), (2, 3, 3)), atol=1e-9)
