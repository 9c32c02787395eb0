"""When a run begins nothing more."""

import pytest

from cadsweep.pipeline import run as runs
from cadsweep.pipeline.run import TO_END, Run, Tries, silent


@pytest.fixture
def clock(monkeypatch):
    """Processor time that only the test moves on."""
    now = [100.0]
    monkeypatch.setattr(runs, "spent", lambda: now[0])
    return now


def lasts(seconds, clock, tries):
    with tries.one():
        clock[0] += seconds


def fails_after(seconds, clock, tries):
    with tries.one():
        clock[0] += seconds
        raise TypeError


@pytest.mark.parametrize(
    ("takes", "latest"), [(0.0, 40.0), (TO_END, 40.0), (TO_END + 10.0, 30.0), (TO_END + 40.0, 0.0)]
)
def test_what_is_begun_ends_in_time_if_it_takes_as_long_as_is_said(clock, takes, latest):
    run = Run(on_progress=silent, total=40.0, _begun=clock[0])
    clock[0] += latest
    assert not run.is_over(takes)
    clock[0] += 0.1
    assert run.is_over(takes)


def test_another_is_tried_as_long_as_the_longest_so_far_would_end_in_time(clock):
    run = Run(on_progress=silent, total=40.0, _begun=clock[0])
    tries = Tries(run)
    lasts(20.0, clock, tries)
    lasts(5.0, clock, tries)
    assert not tries.is_over()  # at 25 of 40 seconds: one of 20 ends at 45, and all may end at 55
    lasts(12.0, clock, tries)
    assert tries.is_over()
    assert not run.is_over()


def test_what_fails_has_taken_its_time_too(clock):
    tries = Tries(Run(on_progress=silent, total=40.0, _begun=clock[0]))
    with pytest.raises(TypeError):
        fails_after(30.0, clock, tries)
    assert tries.is_over()


@pytest.mark.parametrize(
    ("is_valid", "asked", "is_spare", "ends"),
    [(True, False, False, True), (True, True, False, False), (False, False, False, False), (False, True, True, True)],
)
def test_what_is_not_valid_is_mended_however_long_it_takes_unless_there_is_another_mesh(
    clock, is_valid, asked, is_spare, ends
):
    run = Run(on_progress=silent, total=40.0, is_spare=is_spare, _begun=clock[0])
    assert not run.ends_smoothing(is_valid, asked=asked)
    clock[0] += 40.1
    assert run.ends_smoothing(is_valid, asked=asked) == ends
    assert run.left() == pytest.approx(TO_END - 0.1)
