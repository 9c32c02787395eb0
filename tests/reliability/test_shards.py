"""A study on several machines: shards at once, and a dask cluster that loses a worker; the same records either way."""

import csv
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from cadsweep.batch import read_study, run_study
from cadsweep.errors import CadSweepError, InputError

pytest.importorskip("cadquery")
pytest.importorskip("gmsh")
pytestmark = [
    pytest.mark.cad,
    pytest.mark.timeout(600),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="locks of Linux"),
]

SCRIPT = """
import cadquery as cq
import os, time
width = 2.0
with open(os.environ["CADSWEEP_TEST_LOG"], "a") as log:
    log.write(f"{width}\\n")
time.sleep(0.3)
show_object(cq.Workplane().box(width, 1, 1))
"""
WIDTHS = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


@pytest.fixture
def study(tmp_path, monkeypatch):
    (tmp_path / "part.py").write_text(SCRIPT)
    monkeypatch.setenv("CADSWEEP_TEST_LOG", str(tmp_path / "log"))
    path = tmp_path / "study.toml"
    path.write_text(
        f'script = "part.py"\nmax_memory = 4\n[options]\nlayers = 1\nsize = 1.0\n[grid]\nwidth = {WIDTHS}\n'
    )
    return path


def begun(study):
    return sorted(float(line) for line in (study.parent / "log").read_text().split())


def widths(study):
    with open(study.parent / "study_results" / "results.csv", encoding="utf-8", newline="") as file:
        return [float(row["volume"]) for row in csv.DictReader(file) if row["status"] == "ok"]


def test_three_shards_at_once_do_every_case_once(study):
    commands = [
        [sys.executable, "-m", "cadsweep", "batch", str(study), "--quiet", "--shard", f"{i}/3"] for i in (1, 2, 3)
    ]
    # The last shard twice: whoever comes second takes the records of the first.
    running = [subprocess.Popen(command) for command in [*commands, commands[-1]]]
    assert [one.wait(400) for one in running] == [0, 0, 0, 0]
    assert begun(study) == WIDTHS
    assert widths(study) == pytest.approx(WIDTHS)
    # However it is continued, it is done.
    assert run_study(read_study(study)).n_resumed == len(WIDTHS)
    assert run_study(read_study(study), shard=(2, 4)).n_cases == 2


def test_a_whole_run_and_a_shard_do_not_mix(study):
    import fcntl

    (study.parent / "study_results").mkdir()
    with open(study.parent / "study_results" / ".lock", "a") as lock:
        fcntl.flock(lock, fcntl.LOCK_SH)
        with pytest.raises(InputError, match="another run"):
            run_study(read_study(study))
    for shard in ((0, 2), (3, 2)):
        with pytest.raises(InputError, match="no shard"):
            run_study(read_study(study), shard=shard)


@pytest.mark.parametrize("shard", ["0/2", "3/2", "2", "a/b", "1/2/3"])
def test_a_shard_that_is_none_is_wrong_usage(study, shard):
    command = [sys.executable, "-m", "cadsweep", "batch", str(study), "--shard", shard]
    assert subprocess.run(command, capture_output=True, check=False, timeout=60).returncode == 2


def test_a_cluster_that_loses_a_worker_does_its_case_again(study):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as cluster:

        def kill_one():
            log = study.parent / "log"
            while not (log.exists() and len(log.read_text().split()) >= 2):
                time.sleep(0.02)
            os.kill(cluster.workers[0].pid, signal.SIGKILL)

        killer = threading.Thread(target=kill_one, daemon=True)
        killer.start()
        result = run_study(read_study(study), dask=cluster.scheduler_address)
        killer.join()
    assert (result.n_cases, result.n_failed) == (len(WIDTHS), 0)
    assert widths(study) == pytest.approx(WIDTHS)
    # The lost case alone is begun twice.
    assert len(begun(study)) <= len(WIDTHS) + 1
    assert run_study(read_study(study)).n_resumed == len(WIDTHS)


def test_a_scheduler_that_is_not_there_is_said(study, monkeypatch):
    pytest.importorskip("distributed")
    from cadsweep.batch import remote

    monkeypatch.setattr(remote, "PATIENCE", 0.5)
    with pytest.raises(CadSweepError, match="no dask scheduler answers"):
        run_study(read_study(study), dask="tcp://127.0.0.1:9")
