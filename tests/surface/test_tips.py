"""Quads in sharp corners: they fill what they cut off, and leave a loop that is one to be filled."""

import numpy as np
import pytest

from cadsweep.surface.tips import interior_angles, lay_tips


def wedge(degrees: float, n: int = 6) -> np.ndarray:
    """A sharp corner at the origin with n segments a side, and a box at its open end."""
    ahead, back = np.array([[1.0, 0.0], [np.cos(np.radians(degrees)), np.sin(np.radians(degrees))]]) * n
    steps = np.linspace(0.0, 1.0, n + 1)[:, None]
    box = [[n, -2.0], [n + 2.0, -2.0], [n + 2.0, 2.0 + n], [n, 2.0 + n]]
    return np.concatenate([steps * ahead, box, (back * (1 - steps))[:-1]])


def area(loop: np.ndarray) -> float:
    x, y = loop.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2.0


@pytest.mark.parametrize("degrees", [2.0, 10.0, 25.0])
def test_tips_and_what_is_left_are_the_polygon(degrees):
    loop = wedge(degrees)
    inner, quads, (left,) = lay_tips([loop])
    places = np.concatenate([loop, inner])
    whole = sum(area(places[quad]) for quad in quads) + area(places[left])
    assert whole == pytest.approx(area(loop), rel=1e-12)
    assert min(area(places[quad]) for quad in quads) > 0.0
    assert (len(loop) - len(left)) % 2 == 0  # a loop of an even number of segments has one still
    assert interior_angles(places[left]).min() > np.radians(32)


def test_the_quad_at_the_tip_is_as_good_as_the_corner():
    loop = wedge(10.0)
    inner, quads, _ = lay_tips([loop])
    places = np.concatenate([loop, inner])
    tip = places[quads[0]]
    sines = np.sin(interior_angles(tip))
    assert sines[0] == pytest.approx(np.sin(np.radians(10.0)))
    assert sines[1:].min() > 0.6


def test_blunt_polygons_are_left_alone():
    assert lay_tips([np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])]) is None
