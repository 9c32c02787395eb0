"""Quads between two loops, without a mesher: they cover the wall, and no corner is flat."""

import numpy as np
import pytest

from cadsweep.surface.annulus import fill_wall, wall_thickness
from cadsweep.surface.relax import corner_sines

from .surface_shapes import square


def circle(n, radius, turn=0.0):
    angles = turn + 2 * np.pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(angles), np.sin(angles)])


def frame(n_outer, n_hole):
    loops = []
    for n, side in ((n_outer, 2.0), (n_hole, 1.0)):
        corners = square(side) - square(side).mean(axis=0)
        s = np.arange(n)[:, None] / n
        loops.append(
            np.concatenate([a + s * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)])
        )
    return [loops[0], loops[1][::-1]]


def doubled_area(polygon):
    x, y = polygon.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@pytest.mark.parametrize(
    ("loops", "n_quads", "least"),
    [
        # Octagons turned against one another: corners of 67.5 degrees; two rings, since one does not bend.
        ([circle(8, 1.0), circle(8, 0.7, 0.01)[::-1]], 16, 0.9),
        ([circle(24, 1.0), circle(24, 0.4)[::-1]], None, 0.9),
        # Squares of four segments and two: a whole square at every corner.
        (frame(4, 2), 12, 1 - 1e-12),
        (frame(1, 1), 8, np.sqrt(0.5) - 1e-12),
    ],
)
def test_walls_are_filled_to_their_boundary(loops, n_quads, least):
    inner, quads = fill_wall(loops)
    points = np.concatenate([*loops, inner])
    assert sum(doubled_area(points[q]) for q in quads) == pytest.approx(sum(map(doubled_area, loops)))
    assert set(np.unique(quads)) == set(range(len(points)))
    if n_quads is not None:
        assert len(quads) == n_quads
    flat = np.column_stack([points, np.zeros(len(points))])
    assert corner_sines(flat, quads, np.tile([0.0, 0, 1], (len(flat), 1))).min() >= least


def test_thickness_is_counted_in_segments():
    # Area 4 - 1 over a mean outline of 6 is half; 24 segments of 12 in all are half each.
    assert wall_thickness(frame(4, 2)) == pytest.approx(1.0)


def test_odd_differences_and_thick_unequal_walls_are_left_to_the_mesher():
    assert fill_wall([circle(9, 1.0), circle(8, 0.8)[::-1]]) is None
    assert fill_wall([circle(40, 1.0), circle(20, 0.2)[::-1]]) is None


@pytest.mark.parametrize("flat", [(0, 8), (4, 12)])
def test_a_corner_that_is_flat_on_the_other_cap_is_joined_to_the_hole(flat):
    """Sixteen segments around twelve: two quads take two of the outer ones, and stand at corners."""
    loops = frame(4, 3)
    opposite = np.full(28, np.nan)
    opposite[list(flat)] = np.pi
    _, quads = fill_wall(loops, opposite)
    uses = np.bincount(quads.ravel())
    assert (uses[list(flat)] >= 2).all()
    assert (uses[:16] == 1).sum() == 2


def test_many_nodes_are_joined_straight_across():
    """Between rings of 156 nodes quads that are off by one have corners of 0.98: good, but not symmetric."""
    outer, hole = circle(156, 20.0), circle(156, 11.0, 2 * np.pi / 156)
    inner, quads = fill_wall((outer, hole[::-1]))
    points = np.concatenate([outer, hole[::-1], inner])
    angles = np.unwrap(np.arctan2(*points[quads].T[::-1]), axis=0)
    assert np.allclose(np.ptp(angles, axis=0), 2 * np.pi / 156)
