"""Heights of free levels along the lines between cells: linear along a wall, whatever its segments, and in order."""

import numpy as np
import pytest

from cadsweep.stacks.rims import even_out, segments_of, short_sides

MEANS = np.array([0.0, 1.0, 1.5, 4.0, 5.0])


NO_SIDES = np.empty((0, 2), dtype=np.int64)


def wall(along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Segments of a straight wall, and their lengths."""
    return segments_of([np.arange(len(along))], NO_SIDES, np.stack([along, 2.0 * along, 0.0 * along], axis=1))


@pytest.mark.parametrize("seed", range(3))
def test_a_level_off_its_mean_height_along_a_straight_wall_is_linear_whatever_the_segments(seed):
    along = np.cumsum(np.random.default_rng(seed).uniform(1e-4, 1.0, 12) ** 3)
    exact = MEANS[:, None] + 0.05 * along * MEANS[:, None] + 0.02 * along + 0.1
    known = np.zeros(exact.shape, dtype=bool)
    known[[0, -1]] = True  # all around
    known[:, [0, -1]] = True
    given = np.where(known, exact, MEANS[:, None])
    assert np.allclose(even_out(given, given, known, MEANS, *wall(along)), exact, rtol=0.0, atol=1e-6)


def test_a_level_does_not_jump_at_the_end_of_a_rim():
    """Known on one side of a short segment; the other side is beside it, not at its share of its own place."""
    along = np.array([0.0, 1.0, 2.0, 2.001, 3.0, 4.0])
    known = np.zeros((5, 6), dtype=bool)
    known[[0, -1]] = True
    known[2, :3] = True
    given = np.repeat(MEANS[:, None], 6, axis=1)
    given[1:3, :3] += [[0.5], [1.0]]
    found = even_out(given, given, known, MEANS, *wall(along))
    assert np.array_equal(found[known], given[known])
    assert abs(found[2, 3] - found[2, 2]) < 0.01
    assert found[2, 2] > found[2, 3] > found[2, 4] > found[2, 5] > MEANS[2]


@pytest.mark.parametrize("seed", range(5))
def test_levels_keep_their_order_and_every_layer_part_of_its_height(seed):
    random = np.random.default_rng(seed)
    along = np.cumsum(random.uniform(1e-4, 1.0, 40) ** 4)
    known = random.random((5, 40)) < 0.3
    known[[0, -1]] = True
    own = np.cumsum(random.uniform(1e-3, 1.0, (5, 40)) ** 3, axis=0)
    found = even_out(own, own, known, MEANS, *wall(along))
    assert np.array_equal(found[known], own[known])
    assert not np.array_equal(found, own)
    assert (np.diff(found, axis=0) >= 0.1 * np.diff(own, axis=0) - 1e-14).all()


def test_what_is_at_its_mean_height_stays_and_what_is_not_there_is_left_out():
    given = np.repeat(MEANS[:, None], 4, axis=1)
    given[3:, 2] = np.nan  # nothing is known over there
    known = np.zeros(given.shape, dtype=bool)
    known[[0, 2]] = True
    known[4, [0, 1, 3]] = True
    assert np.array_equal(even_out(given, given, known, MEANS, *wall(np.arange(4.0))), given, equal_nan=True)
    given[2, 0] += 0.2
    found = even_out(given, given, known, MEANS, *wall(np.arange(4.0)))
    assert np.array_equal(np.isnan(found), np.isnan(given))
    assert found[1, 0] > MEANS[1]


def test_lines_that_come_near_each_other_have_their_levels_at_one_height():
    """One rim is known on each of two lines, at unlike levels; a short side of a quad joins their ends."""
    points = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.001, 0.0, 0.0], [4.0, 0.0, 0.0]])
    lines = [np.array([0, 1]), np.array([2, 3])]
    known = np.zeros((5, 4), dtype=bool)
    known[[0, -1]] = True
    known[2, :2] = known[3, 2:] = True
    given = np.repeat(MEANS[:, None], 4, axis=1)
    given[2, :2] += 1.0
    far, near = (
        even_out(given, given, known, MEANS, *segments_of(lines, sides, points))
        for sides in (NO_SIDES, short_sides(np.array([[1, 2, 3, 0]]), points, MEANS))
    )
    assert abs(far[2, 1] - far[2, 2]) > 0.5
    assert abs(near[2, 1] - near[2, 2]) < 0.05
    assert np.array_equal(near[known], given[known])
