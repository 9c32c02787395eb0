"""The estimate on the bar."""

import pytest

from cadsweep.cli.progress import SHARES, ProgressBar


def at(bar, stage, fraction, now):
    bar._seen = (bar._done(stage, fraction), bar._begin + now)


def test_shares_are_of_a_whole_run():
    assert sum(SHARES.values()) == pytest.approx(1.0)


def test_nothing_is_promised_before_anything_is_known():
    assert ProgressBar().left(1e9) == "-:--"


def test_what_is_left_takes_as_long_in_proportion():
    bar = ProgressBar()
    at(bar, "cad", 1.0, 30.0)
    assert bar.left(bar._begin + 30.0) == f"{int(30 / SHARES['cad'] - 30) // 60}:{int(30 / SHARES['cad'] - 30) % 60:02}"
    assert bar.left(bar._begin + 40.0) == "1:00"
    assert bar.left(bar._begin + 1e6) == "0:00"


def test_the_bar_never_goes_back():
    bar = ProgressBar()
    done = [
        bar._done(stage, 1.0) for stage in ("cad", "surface", "quality", "surface", "smoothing", "quality", "write")
    ]
    assert done == sorted(done)
    assert done[-1] == pytest.approx(1.0)


def test_other_work_is_measured_by_itself():
    bar = ProgressBar()
    assert [bar._done("expand", f) for f in (None, 0.25, 0.5)] == [0.0, 0.25, 0.5]
