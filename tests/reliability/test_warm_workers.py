"""A worker is kept from task to task, meets each as if it were the first, and is replaced where it cannot."""

import os
import sys

import psutil
import pytest

from cadsweep.errors import NotSweepableError, WorkerError
from cadsweep.isolation import Worker

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="sessions and limits are POSIX")


@pytest.fixture
def worker():
    with Worker() as own:
        yield own


def pid_of(worker):
    return worker.run("tests.reliability.worker_tasks:where")[0]


def test_tasks_share_a_process_also_after_an_error_on_purpose(worker):
    first = pid_of(worker)
    with pytest.raises(NotSweepableError):
        worker.run("tests.reliability.worker_tasks:refuse")
    with pytest.raises(WorkerError, match="KeyError"):
        worker.run("tests.reliability.worker_tasks:fail")
    assert pid_of(worker) == first != os.getpid()
    assert worker.n_done == 4
    worker.end()
    assert not psutil.pid_exists(first)


def test_a_caller_with_more_arguments_than_a_command_may_have_gets_a_worker(worker, monkeypatch):
    monkeypatch.setattr(sys, "argv", ["cadsweep", *(f"part_{k:06d}.step" for k in range(20_000))])
    assert worker.run("tests.reliability.worker_tasks:n_arguments") == 20_001


def test_a_task_finds_the_process_as_the_first_one_found_it(worker, tmp_path):
    (tmp_path / "beside.py").write_text("VALUE = 1\n")
    before = worker.run("tests.reliability.worker_tasks:look_around")
    pid, child, value = worker.run("tests.reliability.worker_tasks:leave_traces", (str(tmp_path),))
    assert (pid, value) == (before["pid"], 1)
    assert worker.run("tests.reliability.worker_tasks:look_around") == before
    assert not psutil.pid_exists(child)
    (tmp_path / "beside.py").write_text("VALUE = 2222\n")  # of another length, since a byte code's time is in seconds
    assert worker.run("tests.reliability.worker_tasks:leave_traces", (str(tmp_path),))[2] == 2222


@pytest.mark.parametrize(
    ("task", "args", "limits", "words"),
    [
        ("crash", (), {}, "SIGSEGV"),
        ("hang", (), {"timeout": 0.5}, "time-out"),
        ("grow", (), {"max_memory": 0.5}, "out of memory"),
        ("grow_at_once", (), {"max_memory": 0.5}, "out of memory"),
    ],
)
def test_a_task_that_ends_its_process_costs_the_next_one_a_start_alone(worker, task, args, limits, words):
    first = pid_of(worker)
    with pytest.raises(WorkerError, match=words):
        worker.run(f"tests.reliability.worker_tasks:{task}", args, **limits)
    assert worker.n_done == 0
    assert not psutil.pid_exists(first)
    assert pid_of(worker) != first


def test_a_process_that_keeps_a_thread_or_much_memory_is_not_used_again(worker):
    first = worker.run("tests.reliability.worker_tasks:leave_a_thread")
    second = worker.run("tests.reliability.worker_tasks:hold", (6 * 10**8,), max_memory=1.0)
    assert pid_of(worker) not in (first, second)
    assert first != second


def test_a_process_that_was_killed_while_idle_is_replaced(worker):
    pid = pid_of(worker)
    psutil.Process(pid).kill()
    psutil.wait_procs([psutil.Process(pid)] if psutil.pid_exists(pid) else [], timeout=5)
    assert pid_of(worker) != pid


def test_a_limit_is_of_a_task_and_not_of_the_process(worker):
    with pytest.raises(WorkerError, match="out of memory"):
        worker.run("tests.reliability.worker_tasks:grow_at_once", max_memory=0.4)
    first = worker.run("tests.reliability.worker_tasks:hold", (10**6,), max_memory=0.4)
    assert worker.run("tests.reliability.worker_tasks:hold", (12 * 10**8,)) == first
