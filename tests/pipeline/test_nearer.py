"""The loop that comes nearer to the CAD: it asks the clock, and what the user asks for is made whatever that says."""

from typing import NamedTuple

import pytest

from cadsweep.options import SweepOptions
from cadsweep.pipeline.nearness.nearer import come_nearer
from cadsweep.pipeline.run import Run, silent


class Off(NamedTuple):
    """How far a mesh is off, in limits."""

    shortfall: float


@pytest.mark.parametrize("in_time", [0, 1, 2, 5])
def test_no_nearer_mesh_is_begun_once_time_is_over(in_time):
    made = []

    def make(asked):
        made.append(asked)
        return Off(16.0 / asked)

    best, stop = come_nearer(
        Off(16.0), 1, make=make, finer=lambda last, asked, _: 2 * asked, is_over=lambda: len(made) >= in_time
    )
    # Every round halves what is missing: four of them are all that is needed.
    assert made == [2, 4, 8, 16][:in_time]
    assert best.shortfall == 16.0 / 2 ** min(in_time, 4)
    assert ("no time" in stop) == (in_time < 4)


def test_what_is_asked_for_has_all_the_time_that_it_takes():
    over = Run(on_progress=silent, total=-1.0)
    assert over.ends_refining(SweepOptions())
    assert not over.ends_refining(SweepOptions(tolerance=0.1))
    assert not over.ends_refining(SweepOptions(size=1.0))
    assert not Run(on_progress=silent).ends_refining(SweepOptions())
