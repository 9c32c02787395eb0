"""Worker processes, and how every end of what they do becomes a value or a ``CadSweepError``."""

from __future__ import annotations

import contextlib
import logging
import os
import pickle
import select
import signal
import sys
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from types import TracebackType
from typing import Any

from ..errors import InputError, WorkerError
from ..machine import resident_memory
from ..progress import Progress
from . import worker
from .channel import Channel
from .place import Workplace
from .process import WorkerProcess
from .transfer import unpack

log = logging.getLogger(__name__)


LOOK_EVERY = 0.05
"""Seconds between two looks at the worker's memory."""

HEARTBEAT = 0.5
"""Seconds after which the caller hears again of a stage that says nothing."""

GIGABYTE = 10**9

FULL = 0.5
"""Part of a task's memory that a worker may hold after it; one that holds more is not used again, so that no task
runs out of memory that others have taken."""

_REPORT = "please report this with the input"
_ADVICE = {
    "cad": "the model may be damaged: repair or export it again in the CAD program",
    "surface": "try another size, or report this with the input",
}
"""What to try where a stage ends its process; what was read is sound, and a later stage's end is no fault of it."""


def run_isolated(
    function: str,
    args: Sequence[Any] = (),
    kwargs: Mapping[str, Any] | None = None,
    *,
    timeout: float | None = None,
    max_memory: float | None = None,
    on_progress: Progress | None = None,
    remove: Iterable[str] = (),
) -> Any:
    """Call a function in a process of its own.

    The worker has its own session, temporary folder and silence: nothing of it reaches the caller's
    terminal, an interrupt of the caller ends it, and it never outlives the caller, even a killed one.

    Parameters
    ----------
    function : str
        ``"module:qualified_name"``. It is called with `args`, `kwargs` and ``on_progress``, a callback
        ``(stage, fraction)``.
    args, kwargs
        Must be picklable.
    timeout : float or None
        Wall time, seconds, the worker's start included.
    max_memory : float or None
        Resident memory of the worker, GB (1e9 bytes). It is looked at every 50 ms; allocations beyond
        it by more than half a GB are refused by the kernel at once.
    on_progress : callable or None
        Called in the caller's thread, with the same values again while nothing changes.
    remove : iterable of str
        Files and folders to remove unless the function returns, even if this process is killed: glob
        patterns in which ``{pid}`` stands for the worker's process id.

    Returns
    -------
    Whatever the function returns; arrays of any size come back without a copy.

    Raises
    ------
    CadSweepError
        As the function raised it.
    WorkerError
        The worker crashed, ran out of time or memory, or failed in a way that nobody meant; ``.stage``
        names the stage that was under way.
    InputError
        The arguments cannot be handed to another process.
    """
    with Worker() as own:
        return own.run(
            function, args, kwargs, timeout=timeout, max_memory=max_memory, on_progress=on_progress, remove=remove
        )


class Worker:
    """A process that does one task after another, and is replaced where a task has ended or spoilt it.

    A context manager: the process starts with the first task, and ends with the block. Used by one thread at a time.

    Parameters
    ----------
    environment : mapping or None
        Variables for the process, where they are not set.

    Attributes
    ----------
    n_done : int
        Tasks that the process at work now has answered.
    """

    def __init__(self, environment: Mapping[str, str] | None = None) -> None:
        self.n_done = 0
        self._environment = dict(environment or {})
        self._process: WorkerProcess | None = None
        self._place: Workplace | None = None

    def __enter__(self) -> Worker:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()

    def run(
        self,
        function: str,
        args: Sequence[Any] = (),
        kwargs: Mapping[str, Any] | None = None,
        *,
        timeout: float | None = None,
        max_memory: float | None = None,
        on_progress: Progress | None = None,
        remove: Iterable[str] = (),
    ) -> Any:
        """Call a function, as :func:`run_isolated` does, in a process that may have served before."""
        task = worker.Task(
            function=function,
            args=tuple(args),
            kwargs=dict(kwargs or {}),
            max_bytes=None if max_memory is None else int(max_memory * GIGABYTE),
        )
        try:
            request = pickle.dumps(task)
        except (pickle.PicklingError, TypeError, AttributeError) as error:
            raise InputError(
                f"this cannot be handed to a worker process ({error}): give a file, or call without isolated=True"
            ) from error
        remove = tuple(remove)
        deadline = None if timeout is None else time.monotonic() + timeout
        watch = _Watch(max_memory, on_progress)
        answer: worker.Answer | None = None
        done = False
        try:
            process, place = self._start()
            place.watch(remove)
            with contextlib.suppress(BrokenPipeError):  # a process that died at its start is seen at once
                process.channel.send_bytes(request)
            answer = watch.until_done(process, deadline)
            self.n_done += 1
            value = _value(answer, watch, process, timeout)
            done = True
            return value
        finally:
            failed = () if done else remove
            if answer is None or answer.spent or answer.out_of_memory or watch.holds_much:
                self.end(failed)
            elif self._place is not None:
                self._place.clear(failed)

    def end(self, remove: Iterable[str] = ()) -> None:
        """Kill the process and all of its session, and remove what it leaves; the next task starts another."""
        process, self._process = self._process, None
        if process is not None:
            for kill in (os.killpg, os.kill):
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    kill(process.pid, signal.SIGKILL)
            process.wait(10.0)
            process.close()
        place, self._place = self._place, None
        self.n_done = 0
        if place is not None:
            place.clear(remove)
            place.close()

    def _start(self) -> tuple[WorkerProcess, Workplace]:
        """The process and its folders; a new one where there is none."""
        if self._process is not None and self._process.exit_code is not None:
            self.end()  # something else has ended it while it had nothing to do
        if self._process is None:
            self._place = Workplace()
            station = worker.Station(
                caller=os.getpid(),
                pid_file=str(self._place.pid_file),
                folders=tuple(str(folder) for folder in self._place.results),
                arguments=tuple(sys.argv),
                environment=self._environment,
            )
            try:
                self._process = WorkerProcess()
            except OSError as error:
                raise WorkerError(f"a worker process cannot be started: {error}", stage="start") from error
            with contextlib.suppress(BrokenPipeError):
                self._process.channel.send(station)
        assert self._place is not None
        return self._process, self._place


class _Watch:
    """What is known of a task from outside: its stage, its last words, its memory, its time."""

    def __init__(self, max_memory: float | None, on_progress: Progress | None) -> None:
        self.stage = "start"
        self.memory = 0
        self.too_large = False
        self.too_late = False
        self.max_memory = max_memory
        self._last_words: deque[bytes] = deque(maxlen=8)
        self._report = on_progress
        self._fraction: float | None = None
        self._reported = time.monotonic()
        self._weighed = 0.0

    def until_done(self, process: WorkerProcess, deadline: float | None) -> worker.Answer | None:
        """Hand on progress and look at memory and time until there is an answer; None where the process has ended."""
        answers = process.channel.incoming
        ends = [answers, process.chatter]
        while True:
            has_ended = process.exit_code is not None  # asked first: what it said before is read
            ready = _readable(ends, 0.0 if has_ended else LOOK_EVERY)
            if process.chatter in ready and not self._hear(process.chatter):
                ends.remove(process.chatter)
            if answers in ready:
                message = _receive(process.channel)
                if isinstance(message, worker.Answer):
                    self._weigh(process.pid)
                    return message
                if message is None:
                    ends.remove(answers)
                else:
                    self.stage, self._fraction = message
                    self._tell()
            elif has_ended:
                return None
            if deadline is not None and time.monotonic() > deadline:
                self.too_late = True
                return None
            now = time.monotonic()
            if now - self._reported > HEARTBEAT:
                self._tell()
            if now - self._weighed > LOOK_EVERY:
                self._weighed = now
                self._weigh(process.pid)
            if self.holds_too_much:
                self.too_large = True
                return None

    def _hear(self, chatter: int) -> bool:
        """Keep what the worker writes to where a terminal would be; False at its end."""
        data = os.read(chatter, 65536)
        self._last_words.append(data[-4096:])
        return bool(data)

    def _tell(self) -> None:
        self._reported = time.monotonic()
        if self._report is not None:
            self._report(self.stage, self._fraction)

    def last_words(self) -> str:
        """What the worker and its libraries wrote last."""
        return b"".join(self._last_words).decode("utf-8", "replace").strip()

    @property
    def holds_too_much(self) -> bool:
        """Whether the worker holds more than its task may."""
        return self.max_memory is not None and self.memory > self.max_memory * GIGABYTE

    @property
    def holds_much(self) -> bool:
        """Whether the worker holds so much that another task might not find enough."""
        return self.max_memory is not None and self.memory > FULL * self.max_memory * GIGABYTE

    def _weigh(self, pid: int) -> None:
        if self.max_memory is None:
            return
        memory = resident_memory(pid)
        if memory is not None:
            self.memory = memory


def _readable(ends: list[int], seconds: float) -> set[int]:
    """Those of the descriptors from which something can be read, or their end."""
    poll = select.poll()  # select.select knows no descriptors from 1024 on
    for end in ends:
        poll.register(end, select.POLLIN)
    return {end for end, _ in poll.poll(1000 * seconds)}


def _receive(channel: Channel) -> Any:
    """A message; None where the other end is closed."""
    try:
        return channel.receive()
    except (EOFError, OSError):
        return None


def _value(answer: worker.Answer | None, watch: _Watch, process: WorkerProcess, timeout: float | None) -> Any:
    """The value, or the error that says how the task ended."""
    stage, where = watch.stage, f"in stage '{watch.stage}'"
    words = watch.last_words()
    if words:
        log.debug("the worker's last words: %s", words)
    advice = _ADVICE.get(stage, _REPORT)
    if watch.too_late:
        raise WorkerError(
            f"time-out {where}: not done within {timeout:g} s; allow more time, or ask for a coarser mesh", stage=stage
        )
    if watch.too_large:
        raise _out_of_memory(watch)
    if answer is None:
        process.wait(10.0)
        code = process.exit_code or 0
        how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
        raise WorkerError(f"the worker {how} {where}: {advice}", stage=stage)
    if answer.error is not None:
        log.debug("%s", answer.trace)
        raise answer.error
    if answer.out_of_memory:
        raise _out_of_memory(watch)
    if answer.failure is not None:
        defect = WorkerError(f"unexpected failure {where}: {answer.failure}; {_REPORT}", stage=stage)
        defect.add_note(answer.trace)
        raise defect
    assert answer.value is not None
    return unpack(answer.value)


def _out_of_memory(watch: _Watch) -> WorkerError:
    limit = "the machine's memory" if watch.max_memory is None else f"the limit of {watch.max_memory:g} GB"
    return WorkerError(
        f"out of memory in stage '{watch.stage}': it needs more than {limit}; allow more, or ask for a coarser mesh",
        stage=watch.stage,
    )
