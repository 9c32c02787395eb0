"""What may crash, hang or take all memory in OpenCASCADE, first done where its end harms nobody.

Place in the flow: ``heal``, ``imprinting``, ``edit`` and ``geometry`` do every step of OpenCASCADE here that unites,
divides, intersects, fills or mends shapes: in these, valid models have ended the process, or taken hours.

Method: a copy of the process (``fork``) does the step and says whether it came to its end. OpenCASCADE does the same
again with the same shapes, so where the copy came through, the step is done here, and its result is what it would have
been without a trial: nothing has to be brought over. What the copy costs is the step itself, and 10 to 30 ms. Planes
and cylinders divide each other in closed form, and nothing has been seen to end there: such steps go without a copy.

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
from collections.abc import Callable, Iterator, Sequence
from contextvars import ContextVar
from pathlib import Path
from typing import Any

log = logging.getLogger(__name__)

SECONDS = 20.0
"""How long a step may take: what takes longer has not been seen to end."""
_LEFT = 0.75
"""Share of the machine's free memory that a step may take."""

_given_up: ContextVar[list[str] | None] = ContextVar("given_up", default=None)


def attempted(
    step: Callable[[], object], what: str, *, on: Sequence[Any] | None = None, seconds: float = SECONDS
) -> bool:
    """Do a step of OpenCASCADE; whether it was done: not where a copy of this process does not come to its end.

    Parameters
    ----------
    step : callable
        As for :func:`survives`; an exception of its own is the caller's.
    what : str
    on : sequence of TopoDS_Shape or None
        What it works on, where it is harmless on planes and cylinders; None: it is tried whatever it works on.
    seconds : float
    """
    if on is not None:
        from .shapes import is_plain  # knows OpenCASCADE, which who collects notes need not load

        on = [] if all(map(is_plain, on)) else on
    done = on == [] or survives(step, what, seconds=seconds)
    if done:
        step()
    return done


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
