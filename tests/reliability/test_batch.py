"""A study runs to its end whatever its cases do, and goes on after a kill where it was."""

import csv
import json
import signal
import subprocess
import sys
import time

import psutil
import pytest

import cadsweep
from cadsweep.batch import read_study, run_study
from cadsweep.errors import InputError

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [
    pytest.mark.cad,
    pytest.mark.timeout(900),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="locks and signals of Linux"),
]

SCRIPT = """
import cadquery as cq
import os
width = 2.0
mode = "box"
with open(os.environ["CADSWEEP_TEST_LOG"], "a") as log:
    log.write(f"{width} {mode}\\n")
with open(os.environ["CADSWEEP_TEST_LOG"] + ".pids", "a") as log:
    log.write(f"{os.getpid()}\\n")
if mode == "crash":
    os.kill(os.getpid(), 11)
if mode == "sphere":
    show_object(cq.Workplane().sphere(width))
else:
    show_object(cq.Workplane().box(width, 1, 1))
"""


@pytest.fixture
def study(tmp_path, monkeypatch):
    """Writes a study of the script above; ``runs()`` lists the cases that were begun."""
    (tmp_path / "part.py").write_text(SCRIPT)
    log = tmp_path / "log"
    monkeypatch.setenv("CADSWEEP_TEST_LOG", str(log))

    class Writer:
        path = tmp_path / "study.toml"
        results = tmp_path / "study_results"

        def write(self, text):
            self.path.write_text('script = "part.py"\n[options]\nlayers = 2\ndecompose = false\n' + text)
            return self.path

        def runs(self):
            return log.read_text().splitlines() if log.exists() else []

        def workers(self):
            return set(log.with_name("log.pids").read_text().splitlines())

    return Writer()


def command(study, *args):
    return [sys.executable, "-m", "cadsweep", "batch", str(study.path), *args]


def table(study):
    with open(study.results / "results.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_every_case_has_its_line_with_figures_or_an_error(study):
    study.write('[grid]\nwidth = [1.0, 3.0]\n[[cases]]\nmode = "sphere"\n[[cases]]\nname = "crash"\nmode = "crash"\n')
    done = subprocess.run(command(study, "--json"), capture_output=True, text=True, check=False, timeout=800)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert (summary["n_cases"], summary["n_failed"], summary["n_resumed"]) == (4, 2, 0)
    rows = table(study)
    assert [row["status"] for row in rows] == ["ok", "ok", "failed", "failed"]
    assert [row["error_type"] for row in rows] == ["", "", "NotSweepableError", "WorkerError"]
    assert "SIGSEGV" in rows[3]["error"]
    # One worker for all, and another for the crash, which is seen twice: it might have been the first one's fault.
    assert len(study.workers()) == 2
    assert [line.split()[1] for line in study.runs()] == ["box", "box", "sphere", "crash", "crash"]
    lines = done.stderr.splitlines()
    assert [line.split(":")[0] for line in lines] == ["1/4 width-1.0", "2/4 width-3.0", "3/4 mode-sphere", "4/4 crash"]
    assert "ok, " in lines[0]
    assert "failed, NotSweepableError" in lines[2]
    folders = sorted(path.name.rpartition("_")[0] for path in (study.results / "cases").iterdir())
    assert folders == ["crash", "mode-sphere", "width-1.0", "width-3.0"]
    assert [float(row["volume"]) for row in rows[:2]] == pytest.approx([1.0, 3.0], rel=1e-9)
    assert all(float(row["min_scaled_jacobian"]) > 0.9 and row["n_inverted"] == "0" for row in rows[:2])
    assert json.loads((study.results / "results.json").read_text()) == summary["cases"]
    for row in rows:
        assert bool(row["mesh"]) == (row["status"] == "ok")
        if row["mesh"]:
            assert cadsweep.read(study.results / row["mesh"]).n_hexes == int(row["n_hexes"])

    # Nothing is done twice, a new case is done, and failed ones are done again on request alone.
    study.write('[grid]\nwidth = [1.0, 3.0, 4.0]\n[[cases]]\nmode = "sphere"\n')
    before = study.runs()
    result = run_study(read_study(study.path))
    assert (result.n_cases, result.n_failed, result.n_resumed) == (4, 1, 3)
    assert study.runs()[len(before) :] == ["4.0 box"]
    assert run_study(read_study(study.path), retry_failed=True).n_resumed == 3
    assert study.runs()[len(before) :] == ["4.0 box", "2.0 sphere"]


def test_a_killed_study_loses_no_case_and_does_none_again(study):
    study.write("[grid]\nwidth = [1.0, 2.0, 3.0]\n")
    first = subprocess.Popen(command(study, "--quiet"), start_new_session=True)
    end = time.monotonic() + 400
    while len(list((study.results / "cases").glob("*/record.json"))) < 2:
        assert time.monotonic() < end
        time.sleep(0.02)
    first.send_signal(signal.SIGKILL)
    first.wait()
    finished = list((study.results / "cases").glob("*/record.json"))
    begun = study.runs()
    done = subprocess.run(command(study, "--json"), capture_output=True, text=True, check=False, timeout=800)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert (summary["n_cases"], summary["n_failed"], summary["n_resumed"]) == (3, 0, len(finished))
    assert len(study.runs()) - len(begun) == 3 - len(finished)
    assert [float(row["volume"]) for row in table(study)] == pytest.approx([1.0, 2.0, 3.0])
    assert {path.name for path in (study.results / "cases").glob("*/.*")} <= {".lock"}


def test_an_interrupt_ends_the_workers_and_keeps_what_is_done(study):
    study.write("[grid]\nwidth = [1.0, 2.0, 3.0]\n")
    run = subprocess.Popen(command(study, "--jobs", "2"), stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    end = time.monotonic() + 400
    while len(study.runs()) < 1:
        assert time.monotonic() < end
        time.sleep(0.02)
    children = psutil.Process(run.pid).children(recursive=True)
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=30)
    assert (run.returncode, out, err.strip()) == (130, "", "cadsweep: interrupted")
    assert not psutil.wait_procs(children, timeout=15)[1]
    result = run_study(read_study(study.path), jobs=2)
    assert (result.n_cases, result.n_failed) == (3, 0)


def test_a_damaged_record_is_done_again(study):
    study.write("[grid]\nwidth = [1.0]\n")
    result = run_study(read_study(study.path))
    (record,) = (study.results / "cases").glob("*/record.json")
    record.write_text('{"status": "o')
    assert run_study(read_study(study.path)).n_resumed == 0
    assert len(study.runs()) == 2
    (study.results / result.records[0]["mesh"]).unlink()
    assert run_study(read_study(study.path)).n_resumed == 0
    assert run_study(read_study(study.path)).n_resumed == 1


def test_two_runs_of_one_study_do_not_mix(study):
    import fcntl

    study.write("[grid]\nwidth = [1.0]\n")
    study.results.mkdir()
    with open(study.results / ".lock", "a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(InputError, match="another run"):
            run_study(read_study(study.path))
    assert not study.runs()


def test_a_study_without_a_single_mesh_fails(study):
    study.write('[grid]\nmode = ["sphere"]\n')
    done = subprocess.run(command(study, "--quiet"), capture_output=True, text=True, check=False, timeout=800)
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1
