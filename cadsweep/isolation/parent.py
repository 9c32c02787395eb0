"""Run a function in a worker process and turn every end of it into a value or a ``CadSweepError``."""

from __future__ import annotations

import contextlib
import logging
import os
import pickle
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import wait as wait_for_futures
from multiprocessing.connection import Connection, wait
from typing import Any

from ..errors import InputError, WorkerError
from .context import WorkerContext
from .place import Workplace
from .transfer import unpack

log = logging.getLogger(__name__)

Progress = Callable[[str, float | None], None]

LOOK_EVERY = 0.05
"""Seconds between two looks at the worker's memory."""

HEARTBEAT = 0.5
"""Seconds after which the caller hears again of a stage that says nothing."""

GIGABYTE = 10**9

_ADVICE = {
    "cad": "the model is probably damaged: repair or export it again in the CAD program",
    "recognition": "the model is probably damaged: repair or export it again in the CAD program",
    "surface": "try another size, or repair the model",
}


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
    from pebble.concurrent import process

    from . import worker

    context = WorkerContext()
    watch = _Watch(max_memory, on_progress)
    with Workplace(remove) as place:
        progress, progress_end = context.Pipe(duplex=False)
        chatter, chatter_end = context.Pipe(duplex=False)
        task = worker.Task(
            function=function,
            args=tuple(args),
            kwargs=dict(kwargs or {}),
            caller=os.getpid(),
            pid_file=str(place.pid_file),
            folders=tuple(str(folder) for folder in place.results),
            max_bytes=None if max_memory is None else int(max_memory * GIGABYTE),
        )
        future = None
        try:
            try:
                future = process(timeout=timeout, daemon=False, context=context)(worker.run)(
                    task, progress_end, chatter_end
                )
            except (pickle.PicklingError, TypeError, AttributeError) as error:
                raise InputError(
                    f"this cannot be handed to a worker process ({error}): give a file, or call without isolated=True"
                ) from error
            except OSError as error:
                raise WorkerError(f"a worker process cannot be started: {error}", stage="start") from error
            finally:
                progress_end.close()
                chatter_end.close()
            watch.until_done(future, progress, chatter, place)
            return _answer(future, watch, timeout)
        finally:
            _end(future, context)
            progress.close()
            chatter.close()


def _end(future: Any, context: WorkerContext) -> None:
    """Kill what is left of the worker and of its session, and wait until it is gone."""
    pid = context.worker.pid if context.worker is not None else None
    if pid is None:
        return
    for kill in (os.killpg, os.kill) if future is not None and not future.done() else (os.killpg,):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            kill(pid, signal.SIGKILL)
    if future is not None:
        # pebble reaps the worker from its own thread. Cancelling the future instead would race with that.
        wait_for_futures([future], timeout=10.0)


class _Watch:
    """What is known of a worker from outside: its stage, its last words, its memory."""

    def __init__(self, max_memory: float | None, on_progress: Progress | None) -> None:
        self.stage = "start"
        self.peak = 0
        self.too_large = False
        self.max_memory = max_memory
        self._last_words: deque[bytes] = deque(maxlen=8)
        self._report = on_progress
        self._fraction: float | None = None
        self._reported = time.monotonic()

    def until_done(self, future: Any, progress: Connection, chatter: Connection, place: Workplace) -> None:
        """Hand on progress and look at the memory until the worker has ended."""
        open_ends = [progress, chatter]
        while not future.done():
            if not open_ends:
                time.sleep(LOOK_EVERY)
            ready = set(wait(open_ends, timeout=LOOK_EVERY))
            for end in [end for end in (progress, chatter) if end in ready]:
                if not self._take(end, progress):
                    open_ends.remove(end)
            if time.monotonic() - self._reported > HEARTBEAT:
                self._tell()
            if self.max_memory is not None and not self.too_large:
                self._weigh(place.worker_pid())
        while progress in open_ends and progress.poll():
            if not self._take(progress, progress):
                break

    def _take(self, end: Any, progress: Connection) -> bool:
        """Read one message; False at the end."""
        try:
            if end is not progress:
                data = os.read(end.fileno(), 65536)
                self._last_words.append(data[-4096:])
                return bool(data)
            self.stage, self._fraction = end.recv()
        except (EOFError, OSError):
            return False
        self._tell()
        return True

    def _tell(self) -> None:
        self._reported = time.monotonic()
        if self._report is not None:
            self._report(self.stage, self._fraction)

    def last_words(self) -> str:
        """What the worker and its libraries wrote last."""
        return b"".join(self._last_words).decode("utf-8", "replace").strip()

    def _weigh(self, pid: int | None) -> None:
        import psutil

        if pid is None:
            return
        try:
            self.peak = max(self.peak, psutil.Process(pid).memory_info().rss)
        except psutil.NoSuchProcess:
            return
        assert self.max_memory is not None
        if self.peak > self.max_memory * GIGABYTE:
            self.too_large = True
            try:
                os.killpg(pid, signal.SIGKILL)
            except ProcessLookupError:
                return


def _answer(future: Any, watch: _Watch, timeout: float | None) -> Any:
    """The value, or the error that says how the worker ended."""
    from pebble import ProcessExpired

    stage, where = watch.stage, f"in stage '{watch.stage}'"
    words = watch.last_words()
    if words:
        log.debug("the worker's last words: %s", words)
    advice = _ADVICE.get(stage, "please report this with the input")
    try:
        answer = future.result()
    except TimeoutError:
        raise WorkerError(
            f"time-out {where}: not done within {timeout:g} s; allow more time, or ask for a coarser mesh", stage=stage
        ) from None
    except ProcessExpired as error:
        if watch.too_large:
            raise _out_of_memory(watch) from None
        code = error.exitcode or 0
        how = f"was ended by {signal.Signals(-code).name}" if code < 0 else f"ended with code {code}"
        raise WorkerError(f"the worker {how} {where}: {advice}", stage=stage) from None
    if answer.error is not None:
        log.debug("%s", answer.trace)
        raise answer.error
    if answer.out_of_memory:
        raise _out_of_memory(watch)
    if answer.failure is not None:
        defect = WorkerError(f"unexpected failure {where}: {answer.failure}; {advice}", stage=stage)
        defect.add_note(answer.trace)
        raise defect
    return unpack(answer.value)


def _out_of_memory(watch: _Watch) -> WorkerError:
    limit = "the machine's memory" if watch.max_memory is None else f"the limit of {watch.max_memory:g} GB"
    return WorkerError(
        f"out of memory in stage '{watch.stage}': it needs more than {limit}; allow more, or ask for a coarser mesh",
        stage=watch.stage,
    )
