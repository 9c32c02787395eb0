"""The grid convergence index of figures whose order and limit are known."""

import math

import pytest

from cadsweep.errors import InputError
from cadsweep.quality.convergence import SAFETY, convergence_index


@pytest.mark.parametrize("order", [1.0, 2.0, 3.5])
@pytest.mark.parametrize("ratio", [2.0, 1.5])
def test_order_and_limit_of_a_power_law_are_found(order, ratio):
    limit, steps = 3.0, [ratio**-level for level in range(4)]
    found = convergence_index([limit + 0.1 * h**order for h in steps], step_ratio=ratio)
    assert found.order == pytest.approx(order)
    assert found.extrapolated == pytest.approx(limit)
    assert found.index == pytest.approx(SAFETY * abs(found.values[-1] - limit) / found.values[-1])
    assert found.ratio == pytest.approx(1.0, abs=0.05)


def test_a_figure_that_does_not_change_is_sure_and_one_that_swings_has_no_order():
    flat = convergence_index([2.0, 2.0, 2.0])
    assert (flat.order, flat.extrapolated, flat.index) == (None, 2.0, 0.0)
    for values in ([1.0, 2.0, 1.5], [1.0, 1.1, 1.3], [1.0, 2.0, 2.0]):
        assert convergence_index(values).order is None
        assert convergence_index(values).index is None


def test_too_little_is_refused():
    with pytest.raises(InputError, match="three finite values"):
        convergence_index([1.0, 2.0])
    with pytest.raises(InputError, match="three finite values"):
        convergence_index([1.0, 2.0, math.nan])
    with pytest.raises(InputError, match="above 1"):
        convergence_index([1.0, 2.0, 3.0], step_ratio=1.0)
