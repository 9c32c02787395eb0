"""Loops that cross are told from loops that do not, so that gmsh never sees the former."""

import numpy as np
import pytest

from cadsweep.surface.crossings import loops_cross


def circle(n, radius=1.0, center=(0.0, 0.0)):
    t = 2 * np.pi * np.arange(n) / n
    return np.column_stack([np.cos(t), np.sin(t)]) * radius + center


def square(n, side=2.0):
    """A square of n segments a side: many of its segments are in line."""
    t = np.arange(n) / n
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2
    return np.concatenate(
        [a + t[:, None] * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    )


@pytest.mark.parametrize(
    ("loops", "cross"),
    [
        ([circle(3)], False),
        ([circle(50)], False),
        ([square(7)], False),
        ([square(7), circle(12, 0.5)[::-1]], False),
        ([square(7), circle(12, 0.5, (0.45, 0.0))[::-1]], False),
        ([square(7), circle(12, 0.5, (0.7, 0.0))[::-1]], True),
        ([square(7), circle(12, 0.3, (-0.3, 0))[::-1], circle(12, 0.3, (0.2, 0))[::-1]], True),
        ([np.array([[0.0, 0], [1, 1], [1, 0], [0, 1]])], True),
        ([np.array([[0.0, 0], [4, 0], [4, 1], [1, 1], [3, 0], [0, 2]])], True),  # a node on a segment
    ],
)
def test_crossings_are_found(loops, cross):
    assert loops_cross(loops) == cross
    assert loops_cross([loop * 1e-6 + 1.0 for loop in loops]) == cross


def test_a_thin_wall_crosses_once_it_is_halved():
    loops = [square(3), square(2, 1.4)[::-1]]
    assert not loops_cross(loops)
    assert loops_cross([loop[1::2] for loop in loops])


def test_a_straight_side_does_not_cross_itself_by_the_rounding_of_its_coordinates():
    fine = np.linspace(0.0, 0.8, 5)
    # Sides of one long segment, so that those of the fine sides are looked at together.
    box = np.array([*((x, 0.0) for x in fine), *((x, 2.0) for x in fine[::-1])]) + (26.0, 10.5)
    random = np.random.default_rng(0)
    for _ in range(100):
        assert not loops_cross([box + random.integers(-2, 3, box.shape) * np.spacing(box)])


def test_a_slanted_side_divided_unevenly_does_not_cross_itself_by_rounding():
    at = np.cumsum([0.0, 0.1, 0.9, 1.3, 0.2, 2.9, 1.8])
    random = np.random.default_rng(0)
    for turn in random.uniform(0.0, 2.0 * np.pi, 50):
        along = np.array([np.cos(turn), np.sin(turn)])
        side = at[:, None] * along
        loop = np.concatenate([side, side[::-1] + 0.5 * np.array([-along[1], along[0]])]) + (3.5, -2.3)
        assert not loops_cross([loop + random.normal(0.0, 2e-13, loop.shape)])  # as far off as a part's own outlines
