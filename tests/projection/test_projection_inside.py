"""The inside of a mesh goes with its boundary: exactly under an affine map, and in steps without folding."""

import numpy as np
import pytest

from cadsweep.projection.inside import carry_inside
from cadsweep.quality import scaled_jacobians


def block(n):
    """Nodes and hexes of a unit cube of n x n x n, and its nodes on the boundary."""
    axis = np.arange(n + 1) / n
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange((n + 1) ** 3).reshape((n + 1,) * 3)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    hexes = np.stack([number[i : n + i, j : n + j, k : n + k].ravel() for i, j, k in corners], axis=1)
    rim = np.flatnonzero(((points == 0) | (points == 1)).any(axis=1))
    return points, hexes, rim


@pytest.mark.parametrize("n_steps", [1, 4])
def test_an_affine_map_is_carried_exactly(n_steps):
    points, hexes, rim = block(4)
    linear = np.array([[2.0, 0.3, 0.0], [0.0, 1.5, -0.4], [0.2, 0.0, 0.7]])
    wanted = points @ linear + [3.0, -1.0, 2.0]
    assert np.allclose(carry_inside(points, hexes, rim, wanted[rim], n_steps=n_steps), wanted, atol=1e-9)


def test_a_boundary_that_moves_far_folds_fewer_hexes_in_steps():
    points, hexes, rim = block(8)
    places = points[rim].copy()
    top = places[:, 2] == 1.0
    places[top, 2] -= 0.95 * np.prod(np.sin(np.pi * places[top, :2]), axis=1) ** 0.25  # a stamp pressed in
    folded = [
        int((scaled_jacobians(carry_inside(points, hexes, rim, places, n_steps=n), hexes) <= 0.0).sum()) for n in (1, 4)
    ]
    assert folded[1] < folded[0]
