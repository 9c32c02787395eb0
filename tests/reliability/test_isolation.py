"""Every end of a worker process is a value or a named error, and nothing of it stays."""

import glob
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

from cadsweep.errors import CadSweepError, InputError, NotSweepableError, WorkerError
from cadsweep.isolation import place, run_isolated
from cadsweep.isolation.place import leftovers
from cadsweep.isolation.transfer import pack, unpack

from . import worker_tasks

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="sessions and limits are POSIX")


def run(name, *args, **limits):
    return run_isolated(f"tests.reliability.worker_tasks:{name}", args, **limits)


def gone(pid):
    """Whether a process has ended; a zombie has."""
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def wait_until(condition, seconds=15.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


@pytest.fixture(autouse=True)
def no_folder_stays(tmp_path_factory, monkeypatch):
    """Temporary folders of this test's runs alone, which must be empty in the end."""
    folders = [tmp_path_factory.mktemp(name) for name in ("disk", "memory")]
    monkeypatch.setattr(tempfile, "tempdir", str(folders[0]))
    monkeypatch.setattr(place, "MEMORY_FOLDER", folders[1])
    yield
    assert not [path for folder in folders for path in folder.iterdir()]


def test_arrays_come_back_whole_and_writable():
    result = run("arrays", 200_000)
    expected = worker_tasks.arrays(200_000, lambda stage, fraction: None)
    assert np.array_equal(result["points"], expected["points"])
    assert result["none"].shape == (0, 3)
    assert result["name"] == "box"
    result["points"][0] = -1.0
    assert result["points"][0, 0] == -1.0


def test_a_result_finds_another_place_where_the_first_is_missing(tmp_path):
    value = np.arange(1000.0)
    taken = tmp_path / "taken"
    taken.mkdir()
    (taken / "result").touch()
    packed = pack({"a": value}, [taken, tmp_path])
    assert Path(packed.path).parent == tmp_path
    assert np.array_equal(unpack(packed)["a"], value)
    assert not (tmp_path / "result").exists()


def test_progress_comes_in_the_order_of_the_stages():
    heard = []
    run("stages", on_progress=lambda stage, fraction: heard.append((stage, fraction)))
    assert [h for h in dict.fromkeys(heard) if h[0] != "start"] == [
        ("cad", 0.0), ("cad", 1.0), ("surface", 0.0), ("surface", 1.0)
    ]  # fmt: skip


def test_an_error_raised_on_purpose_comes_back_as_itself():
    with pytest.raises(NotSweepableError) as caught:
        run("refuse")
    assert caught.value.reasons == ("face 1: no", "face 2: neither")


@pytest.mark.parametrize(
    ("task", "stage", "words"),
    [
        ("crash", "cad", "SIGSEGV"),
        ("die", "surface", "SIGKILL"),
        ("fail", "intervals", "KeyError"),
        ("leave", "start", "SystemExit"),
    ],
)
def test_an_end_that_nobody_meant_names_its_stage(task, stage, words):
    with pytest.raises(WorkerError, match=words) as caught:
        run(task)
    assert caught.value.stage == stage
    assert f"'{stage}'" in str(caught.value)


@pytest.mark.parametrize("task", ["hang", "hang_in_native_code"])
def test_a_hang_ends_with_its_time(task):
    start = time.monotonic()
    with pytest.raises(WorkerError, match="time-out") as caught:
        run(task, timeout=1.5)
    assert caught.value.stage in ("surface", "cad", "start")
    assert time.monotonic() - start < 10.0


@pytest.mark.parametrize("task", ["grow", "grow_at_once"])
def test_memory_ends_at_its_limit(task):
    with pytest.raises(WorkerError, match="out of memory") as caught:
        run(task, max_memory=0.6)
    assert caught.value.stage == "projection"


def test_nothing_of_the_worker_reaches_the_caller(capfd):
    run("chatter")
    assert capfd.readouterr() == ("", "")


def test_the_worker_has_its_own_session_and_temporary_folder():
    pid, folder, session, text = run("where")
    assert pid == session
    assert pid != os.getpid()
    assert not Path(folder).exists()
    assert text == ""


def test_processes_of_the_worker_end_with_it(tmp_path):
    run("start_a_child", str(tmp_path / "pid"))
    child = int((tmp_path / "pid").read_text())
    wait_until(lambda: gone(child))


def test_what_cannot_be_handed_over_is_said():
    with pytest.raises(InputError, match="cannot be handed to a worker"):
        run("arrays", lambda: None)


def test_workers_run_side_by_side_in_threads():
    ends = []

    def work(task):
        try:
            run(task)
            ends.append("done")
        except CadSweepError as error:
            ends.append(type(error).__name__)

    threads = [threading.Thread(target=work, args=(t,)) for t in ("stages", "crash", "refuse", "stages")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(ends) == ["NotSweepableError", "WorkerError", "done", "done"]


CALLER = """
import sys
sys.path.insert(0, {here!r})
from cadsweep.isolation import place, run_isolated
from cadsweep.isolation.place import leftovers
run_isolated("tests.reliability.worker_tasks:litter_and_hang", ({folder!r},), remove=leftovers({folder!r} + "/out.vtu"))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_killed_caller_leaves_neither_worker_nor_file(tmp_path, number):
    code = CALLER.format(here=str(Path(__file__).parents[2]), folder=str(tmp_path))
    # A script without a guard for its main module: it must not be run a second time in the worker.
    script = tmp_path / "script.py"
    script.write_text(code)
    caller = subprocess.Popen([sys.executable, str(script)], stderr=subprocess.DEVNULL, start_new_session=True)
    wait_until((tmp_path / "ready").exists, 30.0)
    wait_until((tmp_path / "ready").read_text)
    pid, folder = (tmp_path / "ready").read_text().split()
    caller.send_signal(number)
    caller.wait(20)
    wait_until(lambda: gone(int(pid)))
    wait_until(lambda: sorted(p.name for p in tmp_path.iterdir()) == ["ready", "script.py"])
    wait_until(lambda: not Path(folder).exists())


def test_leftovers_are_those_of_one_worker_and_one_file(tmp_path):
    odd = tmp_path / "a[1]"
    odd.mkdir()
    (pattern,) = leftovers(odd / "out.vtu")
    mine, other = odd / ".out.vtu.12-ab.tmp", odd / ".out.vtu.13-ab.tmp"
    mine.touch()
    other.touch()
    assert glob.glob(pattern.replace("{pid}", "12")) == [str(mine)]


def test_a_worker_that_cannot_be_prepared_is_said(monkeypatch):
    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tempfile, "mkdtemp", full)
    with pytest.raises(WorkerError, match=r"(?s)No space left.*TMPDIR"):
        run("stages")


def daemonic(name):
    return run(name)


def test_a_worker_of_a_pool_may_isolate_too():
    import multiprocessing

    with multiprocessing.get_context("spawn").Pool(1) as pool, pytest.raises(WorkerError):
        pool.apply(daemonic, ("crash",))


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="threads are counted in /proc")
def test_a_worker_has_one_thread_of_blas_unless_its_caller_asks_for_more(monkeypatch):
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    alone = run("threads_of_blas")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    if (os.cpu_count() or 1) > 1:
        assert run("threads_of_blas") == alone + 1
