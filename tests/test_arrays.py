"""Sets of ids, and boxes of points."""

import numpy as np
import pytest

from cadsweep.arrays import cross_product, distinct, limits


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint64])
@pytest.mark.parametrize(("low", "high"), [(0, 60), (1000, 1060), (0, 10**6), (7, 8)])
def test_distinct_is_unique_whether_ids_are_dense_or_not(kind, low, high):
    ids = np.random.default_rng(3).integers(low, high, (40, 4)).astype(kind)
    found = distinct(ids)
    np.testing.assert_array_equal(found, np.unique(ids))
    assert found.dtype == kind


def test_distinct_takes_negative_huge_and_no_ids():
    np.testing.assert_array_equal(distinct(np.array([3, -2, 3, -1])), [-2, -1, 3])
    huge = np.array([2**64 - 1, 2**64 - 1, 2**64 - 2], dtype=np.uint64)
    np.testing.assert_array_equal(distinct(huge), np.unique(huge))
    assert len(distinct(np.empty(0, dtype=np.int64))) == 0


def test_limits_are_the_least_and_greatest_coordinates():
    points = np.random.default_rng(3).normal(size=(50, 3))
    low, high = limits(points)
    assert np.array_equal(low, points.min(axis=0))
    assert np.array_equal(high, points.max(axis=0))
    assert np.isnan(limits(np.array([[1.0, np.nan], [2.0, 0.0]]))[0][1])


def test_the_cross_product_is_that_of_numpy():
    one, other = np.random.default_rng(0).normal(size=(2, 3))
    assert cross_product(one, other).tolist() == np.cross(one, other).tolist()
