"""What a worker does: settle once, then task after task, each with limits and an answer.

A worker may be asked for one thing or for thousands. After each it puts back what a task may have changed in the
process: folder, environment, paths, modules beside the script, files and processes it left. Where something
stays that cannot be put back (a thread), the answer says that the worker is spent.
"""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import importlib
import logging
import os
import pickle
import resource
import shutil
import signal
import sys
import sysconfig
import tempfile
import threading
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..collector import collector_resting
from ..errors import CadSweepError
from .channel import Channel
from .transfer import Packed, pack

REPORTS_PER_SECOND = 20
"""As often as an eye can follow."""

_COLLECT = (20_000, 20, 20)
"""New objects after which the collector looks among the young, and how often among the older ones: by default it goes
through the hundred thousands of OpenCASCADE again and again while libraries are imported."""

SLACK = 512 * 2**20
"""Bytes of writable memory beyond the limit at which the kernel itself refuses more.

Resident memory decides, and the caller watches it; this stops what grows faster than he looks. Address
space (RLIMIT_AS) says nothing here: OpenCASCADE, VTK and numba map gigabytes that they never touch."""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """How the task ended: a value, an error raised on purpose, or a failure that nobody meant.

    Attributes
    ----------
    spent : bool
        The task left something in the process that the next one must not meet: it needs another worker.
    """

    value: Packed | None = None
    error: CadSweepError | None = None
    failure: str | None = None
    out_of_memory: bool = False
    trace: str = ""
    spent: bool = False


@dataclass(frozen=True, kw_only=True)
class Station:
    """What a worker is told at its start.

    Attributes
    ----------
    caller : int
        Process id of the caller; a worker without a caller ends.
    pid_file : str
    folders : tuple of str
        Where large results go, best first; the last is the temporary folder.
    arguments : tuple of str
        The caller's ``sys.argv``, which may be longer than what a command may be given.
    environment : dict
        Variables that it sets where they are not set.
    """

    caller: int
    pid_file: str
    folders: tuple[str, ...]
    arguments: tuple[str, ...]
    environment: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Task:
    """What the worker is asked for.

    Attributes
    ----------
    function : str
        ``"module:qualified_name"``, called with `args`, `kwargs` and ``on_progress``.
    max_bytes : int or None
    """

    function: str
    args: Sequence[Any]
    kwargs: Mapping[str, Any]
    max_bytes: int | None


class Reporter:
    """Sends progress to the caller, not more often than anyone can read."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._stage: str | None = None
        self._time = 0.0

    def __call__(self, stage: str, fraction: float | None = None) -> None:
        now = time.monotonic()
        if stage == self._stage and now - self._time < 1 / REPORTS_PER_SECOND and fraction != 1.0:
            return
        self._stage, self._time = stage, now
        _send(self._channel, (stage, fraction))


class Waiting(logging.Handler):
    """Tells the caller that somebody waits for the compiler: what ``compiled`` says as a note is progress here."""

    def __init__(self, report: Reporter) -> None:
        super().__init__(logging.INFO)
        self._report = report

    def emit(self, record: logging.LogRecord) -> None:
        self._report(record.getMessage())


def main(incoming: int, outgoing: int) -> None:
    """Be a worker, which is told through these pipes where and what."""
    os.set_inheritable(incoming, False)
    os.set_inheritable(outgoing, False)
    channel = Channel(incoming, outgoing)
    try:
        station: Station = channel.receive()
    except EOFError:  # the caller is gone
        os._exit(1)
    serve(channel, station)


def serve(channel: Channel, station: Station) -> None:
    """Do what comes through the channel until it is closed; every end of a task but a crash is an `Answer`."""
    _settle(station)
    gc.set_threshold(*_COLLECT)
    home = _Home(Path(station.folders[-1]), Path(station.pid_file))
    data_limits = resource.getrlimit(resource.RLIMIT_DATA)
    while True:
        try:
            request = channel.receive_bytes()
        except (EOFError, OSError):  # the caller is gone, or needs no more
            os._exit(0)
        answer = _answer(request, Reporter(channel), [Path(folder) for folder in station.folders], data_limits)
        kept = {answer.value.path} if answer.value is not None else set()
        _send(channel, replace(answer, spent=not home.put_back(kept)))


def _send(channel: Channel, message: Any) -> None:
    try:
        channel.send(message)
    except OSError:  # the caller is gone, and nobody wants the answer
        os._exit(1)


def _answer(request: bytes, report: Reporter, folders: Sequence[Path], data_limits: tuple[int, int]) -> Answer:
    compiling, waiting = logging.getLogger("cadsweep.compiled"), Waiting(report)
    compiling.setLevel(logging.INFO)
    compiling.addHandler(waiting)
    try:
        task: Task = pickle.loads(request)
        _limit(task.max_bytes, *data_limits)
        module, _, name = task.function.partition(":")
        with collector_resting():
            function: Any = importlib.import_module(module)
        for part in name.split("."):
            function = getattr(function, part)
        value = function(*task.args, on_progress=report, **task.kwargs)
        return Answer(value=pack(value, folders))
    except CadSweepError as error:
        # What cannot be pickled (a cause from a compiled library) stays here.
        error.__cause__ = error.__context__ = None
        return Answer(error=error.with_traceback(None), trace=traceback.format_exc())
    except MemoryError:
        return Answer(failure="out of memory", out_of_memory=True, trace=traceback.format_exc())
    except BaseException as error:
        reason = " ".join(str(error).split())[:500]
        return Answer(failure=f"{type(error).__name__}: {reason}".rstrip(": "), trace=traceback.format_exc())
    finally:
        compiling.removeHandler(waiting)


def _settle(station: Station) -> None:
    """Own temporary folder, and an end where the caller has ended; own session and silence it was born with."""
    with open(station.pid_file + ".new", "w", encoding="ascii") as file:
        file.write(str(os.getpid()))
    os.replace(station.pid_file + ".new", station.pid_file)
    if os.getppid() != station.caller:
        os._exit(1)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    sys.argv[:] = station.arguments
    if "OMP_NUM_THREADS" not in os.environ:
        # Systems here are small: the threads of numpy's BLAS win nothing, and on a busy machine wait for each other.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    for name, value in station.environment.items():
        os.environ.setdefault(name, value)
    os.environ["TMPDIR"] = tempfile.tempdir = station.folders[-1]


def _limit(max_bytes: int | None, soft: int, hard: int) -> None:
    """Set the memory beyond which the kernel refuses: a task's, within what the process was given (-1: all)."""
    wanted = soft if max_bytes is None else max_bytes + SLACK
    resource.setrlimit(resource.RLIMIT_DATA, (wanted if soft < 0 else min(wanted, soft), hard))


class _Home:
    """What the process was before a task, and is to be again before the next."""

    def __init__(self, temporary: Path, pid_file: Path) -> None:
        self._temporary, self._pid_file = temporary, pid_file
        self._folder = os.getcwd()
        self._environment = dict(os.environ)
        self._modules = set(sys.modules)
        self._path, self._argv = list(sys.path), list(sys.argv)
        # The caller's folder is where a script lies, not where packages are.
        places = [place for place in sys.path if place and os.path.realpath(place) != os.path.realpath(self._folder)]
        places += [*sysconfig.get_paths().values(), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
        self._installed = tuple({os.path.join(os.path.realpath(place), "") for place in places if place})
        self._package = os.path.join(Path(__file__).resolve().parents[1], "")

    def put_back(self, kept: set[str | None]) -> bool:
        """Undo what a task has changed; False where a thread of it still runs."""
        _end_children()
        os.chdir(self._folder)
        if dict(os.environ) != self._environment:
            os.environ.clear()
            os.environ.update(self._environment)
        sys.path[:], sys.argv[:] = self._path, self._argv
        new = [name for name in sys.modules if name not in self._modules]  # after the first task, hardly any
        for name in [name for name in new if self._is_beside(sys.modules[name])]:
            del sys.modules[name]
            importlib.invalidate_caches()  # the next one may have been written a moment ago
        self._modules.update(name for name in new if name in sys.modules)
        for path in self._temporary.iterdir():
            if path != self._pid_file and str(path) not in kept:
                if path.is_dir() and not path.is_symlink():
                    shutil.rmtree(path, ignore_errors=True)
                else:
                    path.unlink(missing_ok=True)
        return all(t.daemon or t is threading.current_thread() for t in threading.enumerate())

    def _is_beside(self, module: Any) -> bool:
        """Whether a module is of the script's own folder, and may be another one for the next task."""
        place = getattr(module, "__file__", None)
        if not isinstance(place, str) or not place.endswith((".py", ".pyc")) or module.__name__ == "__main__":
            return False
        return not os.path.realpath(place).startswith((*self._installed, self._package))


def _end_children() -> None:
    """Kill the processes that a task has left behind, and wait for them."""
    try:
        os.waitpid(-1, os.WNOHANG)
    except ChildProcessError:  # there are none, and no table of processes need be read
        return
    import psutil

    for child in psutil.Process().children(recursive=True):
        with contextlib.suppress(psutil.NoSuchProcess):
            child.kill()
    with contextlib.suppress(ChildProcessError):
        while True:
            os.waitpid(-1, 0)
