"""What the worker does before its task and after it."""

from __future__ import annotations

import faulthandler
import importlib
import os
import resource
import signal
import tempfile
import time
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from ..errors import CadSweepError
from .transfer import Packed, pack

REPORTS_PER_SECOND = 20

SLACK = 512 * 2**20
"""Bytes of writable memory beyond the limit at which the kernel itself refuses more.

Resident memory decides, and the caller watches it; this stops what grows faster than he looks. Address
space (RLIMIT_AS) says nothing here: OpenCASCADE, VTK and numba map gigabytes that they never touch."""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """How the task ended: a value, an error raised on purpose, or a failure that nobody meant."""

    value: Packed | None = None
    error: CadSweepError | None = None
    failure: str | None = None
    out_of_memory: bool = False
    trace: str = ""


@dataclass(frozen=True, kw_only=True)
class Task:
    """What the worker is told.

    Attributes
    ----------
    function : str
        ``"module:qualified_name"``, called with `args`, `kwargs` and ``on_progress``.
    caller : int
        Process id of the caller; a worker without a caller ends.
    pid_file : str
    folders : tuple of str
        Where large results go, best first; the last is the temporary folder.
    max_bytes : int or None
    """

    function: str
    args: Sequence[Any]
    kwargs: Mapping[str, Any]
    caller: int
    pid_file: str
    folders: tuple[str, ...]
    max_bytes: int | None


class Reporter:
    """Sends progress to the caller, not more often than anyone can read."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self._stage: str | None = None
        self._time = 0.0

    def __call__(self, stage: str, fraction: float | None = None) -> None:
        now = time.monotonic()
        if stage == self._stage and now - self._time < 1 / REPORTS_PER_SECOND and fraction != 1.0:
            return
        self._stage, self._time = stage, now
        try:
            self._pipe.send((stage, fraction))
        except OSError:  # the caller is gone, and nobody wants the answer
            os._exit(1)


def run(task: Task, progress: Connection, chatter: Connection) -> Answer:
    """Do a task in this process, which does nothing else; every end but a crash is an `Answer`."""
    _settle(task, chatter)
    report = Reporter(progress)
    try:
        module, _, name = task.function.partition(":")
        function: Any = importlib.import_module(module)
        for part in name.split("."):
            function = getattr(function, part)
        value = function(*task.args, on_progress=report, **task.kwargs)
        return Answer(value=pack(value, [Path(folder) for folder in task.folders]))
    except CadSweepError as error:
        # What cannot be pickled (a cause from a compiled library) stays here.
        error.__cause__ = error.__context__ = None
        return Answer(error=error, trace=traceback.format_exc())
    except MemoryError:
        return Answer(failure="out of memory", out_of_memory=True, trace=traceback.format_exc())
    except BaseException as error:
        reason = " ".join(str(error).split())[:500]
        return Answer(failure=f"{type(error).__name__}: {reason}".rstrip(": "), trace=traceback.format_exc())


def _settle(task: Task, chatter: Connection) -> None:
    """Own session, own temporary folder, limits, and no way to the caller's terminal."""
    os.setsid()
    with open(task.pid_file + ".new", "w", encoding="ascii") as file:
        file.write(str(os.getpid()))
    os.replace(task.pid_file + ".new", task.pid_file)
    if os.getppid() != task.caller:
        os._exit(1)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    silence = os.open(os.devnull, os.O_RDONLY)
    os.dup2(silence, 0)
    os.close(silence)
    os.dup2(chatter.fileno(), 1)
    os.dup2(chatter.fileno(), 2)
    chatter.close()
    faulthandler.enable()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if task.max_bytes is not None:
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        limit = task.max_bytes + SLACK
        resource.setrlimit(resource.RLIMIT_DATA, (limit if hard < 0 else min(limit, hard), hard))
    os.environ["TMPDIR"] = tempfile.tempdir = task.folders[-1]
