"""Grids found in quads, and values carried inside by their lines."""

from __future__ import annotations

import numpy as np
import pytest

from cadsweep.projection.caps import boundary_loops
from cadsweep.projection.face_grids import carry_inside, find_grid


def shuffled_grid(n_rows, n_columns, seed=0):
    """A bent grid of nodes numbered at random, its quads begun anywhere and in any order."""
    rng = np.random.default_rng(seed)
    number = rng.permutation(n_rows * n_columns).reshape(n_rows, n_columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    quads = np.stack([a, b, c, d], axis=2).reshape(-1, 4)
    quads = np.array([np.roll(q, k) for q, k in zip(quads, rng.integers(0, 4, len(quads)), strict=True)])
    rows, columns = np.meshgrid(np.linspace(0, 1, n_rows) ** 2, np.linspace(0, 2, n_columns), indexing="ij")
    points = np.empty((n_rows * n_columns, 3))
    points[number] = np.stack([columns, rows + 0.1 * columns, 0.0 * rows], axis=2)
    return number, rng.permutation(quads), points


@pytest.mark.parametrize("shape", [(2, 2), (2, 5), (4, 3), (6, 6)])
def test_a_grid_is_found_in_its_quads(shape):
    number, quads, points = shuffled_grid(*shape)
    for way in (1, -1):
        loops = tuple(loop[::way] for loop in boundary_loops(quads, points))
        grid = find_grid(quads, loops)
        turns = [np.rot90(n, k) for n in (number, number.T) for k in range(4)]
        assert any(grid.shape == turn.shape and np.array_equal(grid, turn) for turn in turns)


def test_what_is_no_grid_is_none():
    _, quads, points = shuffled_grid(4, 4)
    for some in (quads[:-1], quads[np.setdiff1d(np.arange(9), 4)]):
        nodes, local = np.unique(some, return_inverse=True)
        local = local.reshape(-1, 4)
        assert find_grid(local, boundary_loops(local, points[nodes])) is None


def test_what_is_linear_along_the_lines_is_carried_exactly():
    number, quads, points = shuffled_grid(5, 4)
    grid = find_grid(quads, boundary_loops(quads, points))
    values = np.stack([points[:, 0] * points[:, 1], 3.0 - points[:, 1], points[:, 0]], axis=1)
    rim = np.unique(np.concatenate([number[0], number[-1], number[:, 0], number[:, -1]]))
    known = np.full_like(values, np.nan)
    known[rim] = values[rim]
    carried = carry_inside(grid, points, known)
    assert np.array_equal(carried[rim], values[rim])
    assert np.allclose(carried[:, 1:], values[:, 1:], atol=1e-12)
