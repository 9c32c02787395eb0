"""Nodes that slide on the faces of a stack stay on them, wherever smoothing has put them."""

import numpy as np

from cadsweep.stack import Slides


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
