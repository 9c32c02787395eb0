"""Steps that may end the process are tried where their end harms nobody."""

import os
import signal
import time

import cadquery as cq
import pytest

import cadsweep as cs
from cadsweep.cad import noting
from cadsweep.cad.trial import survives


def test_what_comes_to_its_end_survives_and_leaves_no_note():
    with noting() as notes:
        assert survives(lambda: None, "nothing")
        assert survives(lambda: 1 / 0, "an exception, which is an end")
    assert notes == []


def test_what_ends_its_process_is_given_up_with_a_note():
    with noting() as notes:
        assert not survives(lambda: os.kill(os.getpid(), signal.SIGSEGV), "a step")
    assert notes == ["a step was given up: OpenCASCADE ended its process (SIGSEGV)"]


def test_what_does_not_end_is_given_up_in_time():
    start = time.monotonic()
    with noting() as notes:
        assert not survives(lambda: time.sleep(60), "a step", seconds=0.2)
    assert time.monotonic() - start < 20
    assert "took more than 0.2 s" in notes[0]


def test_what_a_step_changes_stays_in_the_copy():
    changed = []
    assert survives(lambda: changed.append(1), "a step")
    assert changed == []


def test_no_process_is_left():
    survives(lambda: time.sleep(60), "a step", seconds=0.05)
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)


def test_a_run_goes_on_without_the_step_and_says_so(monkeypatch):
    """A plate whose top is in two halves has a sweep once they are one; without merging it is meshed otherwise."""
    from cadsweep.cad.edit import merging

    halves = cq.Workplane().box(20, 20, 4).val()
    for x in (-5, 5):
        tool = cq.Workplane(origin=(x, 0, 2)).rect(10, 20).extrude(1).val()
        halves = halves.fuse(tool)  # the top is divided, the bottom is not
    monkeypatch.setattr(merging, "survives", lambda step, what: survives(os.abort, what))
    mesh = cs.sweep_mesh(halves, size=5.0)
    assert mesh.quality().valid
    assert not any("merged" in note for note in mesh.info["notes"])
