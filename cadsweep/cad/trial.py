"""What may crash, hang or take all memory in OpenCASCADE, first done where its end harms nobody.

Place in the flow: called by ``edit`` and ``imprinting`` before a step in which valid models may end the process.

Method: a copy of the process (``fork``) does the step and says whether it came to its end. OpenCASCADE does the same
again with the same shapes, so where the copy came through, the step is done here, and its result is what it would have
been without a trial: nothing has to be brought over. What the copy costs is the step itself, and some milliseconds.

Not handled: systems without ``fork`` (Windows), where the step is done at once, as before.
"""

from __future__ import annotations

import contextlib
import faulthandler
import logging
import os
import select
import signal
import warnings
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from pathlib import Path

log = logging.getLogger(__name__)

SECONDS = 20.0
"""How long a step may take: what takes longer has not been seen to end."""
_LEFT = 0.75
"""Share of the machine's free memory that a step may take."""

_given_up: ContextVar[list[str] | None] = ContextVar("given_up", default=None)


def survives(step: Callable[[], object], what: str, *, seconds: float = SECONDS) -> bool:
    """Whether a step comes to its end, with a result or an exception of its own, in a copy of this process.

    Parameters
    ----------
    step : callable
        Must do the same every time, and change nothing that is to stay.
    what : str
        What the step does, for the note where it does not come to its end: ``unifying faces``.
    seconds : float
        Wall time that it may take.
    """
    if not hasattr(os, "fork"):
        return True
    ours, theirs = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of other threads; the copy runs the step alone
        child = os.fork()
    if child == 0:
        _do(step, theirs)
    os.close(theirs)
    try:
        ready, _, _ = select.select([ours], [], [], seconds)
        done = bool(ready) and os.read(ours, 1) == b"1"
    finally:
        os.close(ours)
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    if not done:
        how = f"took more than {seconds:g} s" if not ready else f"ended its process ({_ending(status)})"
        said = f"{what} was given up: OpenCASCADE {how}"
        log.info("%s", said)
        told = _given_up.get()
        if told is not None and said not in told:
            told.append(said)
    return done


@contextlib.contextmanager
def noting() -> Iterator[list[str]]:
    """Collect a note for every step that did not come to its end."""
    notes: list[str] = []
    token = _given_up.set(notes)
    try:
        yield notes
    finally:
        _given_up.reset(token)


def _do(step: Callable[[], object], pipe: int) -> None:
    """The copy's life: quiet, bounded in memory, without a core file, and without what exits run."""
    try:
        import resource  # not everywhere where there is no fork

        from .quiet import quiet_opencascade  # knows OpenCASCADE, which who collects notes need not load

        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        faulthandler.disable()
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with contextlib.suppress(ValueError, OSError):  # a lower limit is set already
            free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
            own = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * os.sysconf("SC_PAGE_SIZE")
            resource.setrlimit(resource.RLIMIT_AS, (own + int(_LEFT * free), resource.RLIM_INFINITY))
        with quiet_opencascade(), contextlib.suppress(Exception):  # an exception is an end, too
            step()
        os.write(pipe, b"1")
    finally:
        os._exit(0)


def _ending(status: int) -> str:
    return signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else "out of memory"
