"""Steps that may end the process are tried where their end harms nobody."""

import os
import re
import signal
import time
from pathlib import Path

import cadquery as cq
import pytest
from OCP.gp import gp_Dir2d

import cadsweep as cs
import cadsweep.trial as trials
from cadsweep.cad import trial
from cadsweep.cad.edit import cutting
from cadsweep.cad.trial import attempted, survives
from cadsweep.trial import noting

CAD = Path(trial.__file__).parent


def test_what_comes_to_its_end_survives_and_leaves_no_note():
    with noting() as notes:
        assert survives(lambda: None, "nothing")
        assert survives(lambda: 1 / 0, "an exception, which is an end")
    assert notes == []


def test_what_ends_its_process_is_given_up_with_a_note():
    with noting() as notes:
        assert not survives(lambda: os.kill(os.getpid(), signal.SIGSEGV), "a step")
    assert notes == ["a step was given up: OpenCASCADE ended its process (SIGSEGV)"]


def works_on():
    while True:
        pass


@pytest.mark.parametrize("step", [works_on, lambda: time.sleep(60)])
def test_what_does_not_end_is_given_up_in_time(step):
    start = time.monotonic()
    with noting() as notes:
        assert not survives(step, "a step", seconds=0.2)
    assert time.monotonic() - start < 20
    assert "took more than 0.2 s" in notes[0]


def test_a_busy_machine_gives_up_no_sooner():
    """What waits as long as its step may work, as for a processor that others have, comes to its end."""
    with noting() as notes:
        assert survives(lambda: time.sleep(0.6), "a step", seconds=0.3)
    assert notes == []


def test_steps_of_a_kind_are_waited_for_as_long_as_one_in_a_run(monkeypatch):
    monkeypatch.setattr(trials, "SECONDS", 0.2)
    with noting() as notes:
        assert [survives(lambda: time.sleep(60), "a step", seconds=0.1) for _ in range(2)] == [False, False]
        assert not survives(lambda: None, "a step")
        assert survives(lambda: None, "another")
    assert len(notes) == 1
    assert survives(lambda: None, "a step")


def test_what_a_step_changes_stays_in_the_copy():
    changed = []
    assert survives(lambda: changed.append(1), "a step")
    assert changed == []


def test_no_process_is_left():
    survives(lambda: time.sleep(60), "a step", seconds=0.05)
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)


def test_a_step_on_planes_and_cylinders_is_done_without_a_copy(monkeypatch):
    monkeypatch.setattr(trial, "survives", lambda *_, **__: pytest.fail("it is tried"))
    done = []
    plate = cq.Workplane().box(4, 4, 1).faces(">Z").hole(1).val().wrapped
    assert attempted(lambda: done.append(1), "a step", on=[plate])
    assert done == [1]


@pytest.mark.parametrize("on", [None, [cq.Solid.makeSphere(1.0).wrapped]])
def test_any_other_step_is_done_where_its_copy_comes_to_its_end(on):
    done = []
    with noting() as notes:
        assert attempted(lambda: done.append(1), "a step", on=on)
        assert not attempted(os.abort, "another", on=on)
    assert done == [1]
    assert len(notes) == 1


def test_what_divides_unites_and_mends_shapes_is_tried():
    """Modules that have a step of OpenCASCADE which may not come to its end, but for one that is plain by itself."""
    risky = re.compile(r"import .*(BOPAlgo_|BRepAlgoAPI_|ShapeUpgrade_|ShapeFix_(Shape|FixSmallFace)\b)")
    texts = {path.name: path.read_text(encoding="utf-8") for path in CAD.rglob("*.py")}
    bare = {name for name, text in texts.items() if risky.search(text) and "trial import" not in text}
    assert bare == {"port_boxes.py"}  # a rectangle without a cylinder


def test_a_cut_that_ends_the_process_is_one_that_does_not_part(monkeypatch):
    """A half ball is cut through no sphere where OpenCASCADE cannot; the part is refused, or meshed otherwise."""
    ball = cs.load(cq.Workplane().sphere(10).rect(30, 30).extrude(20, combine="cut"))
    tool = cq.Face.makePlane(40, 40, dir=(1, 0, 0)).wrapped
    assert cutting.cut_cell(ball, 0, [tool]) is not None
    monkeypatch.setattr(cutting, "attempted", lambda step, what, **k: attempted(os.abort, what, **k))
    with noting() as notes:
        assert cutting.cut_cell(ball, 0, [tool]) is None
    assert notes == ["parting a cell was given up: OpenCASCADE ended its process (SIGABRT)"]


def test_a_run_goes_on_without_the_step_and_says_so(monkeypatch):
    """A plate whose top is in two halves has a sweep once they are one; without merging it is meshed otherwise."""
    from cadsweep.cad.edit import merging

    halves = cq.Workplane().box(20, 20, 4).val()
    for x in (-5, 5):
        tool = cq.Workplane(origin=(x, 0, 2)).rect(10, 20).extrude(1).val()
        halves = halves.fuse(tool)  # the top is divided, the bottom is not
    monkeypatch.setattr(merging, "attempted", lambda step, what: attempted(os.abort, what))
    mesh = cs.sweep_mesh(halves, size=5.0)
    assert mesh.quality().valid
    assert not any("merged" in note for note in mesh.info["notes"])


def test_an_exception_of_opencascade_is_a_step_given_up_and_any_other_the_callers():
    plain = cq.Workplane().box(1, 1, 1).val().wrapped
    with noting() as notes:
        assert not attempted(lambda: gp_Dir2d(0.0, 0.0), "a step", on=[plain])
        assert not attempted(lambda: gp_Dir2d(0.0, 0.0), "a step")
        with pytest.raises(ZeroDivisionError):
            attempted(lambda: 1 / 0, "another", on=[plain])
    assert len(notes) == 1
    assert "zero norm" in notes[0]
