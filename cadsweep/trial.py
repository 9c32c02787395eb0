"""What may crash, hang or take all memory in a foreign library, first done where its end harms nobody.

Place in the flow: ``cad`` asks before every step of OpenCASCADE that unites, divides, intersects, fills or mends shapes
(:mod:`cadsweep.cad.trial`), ``surface`` before gmsh meets an outline on which it has ended: valid models have ended the
process there, or taken hours.

Method: a copy of the process (``fork``) does the step and says whether it came to its end. The library does the same
again with the same input, so where the copy came through, the step is done here, and its result is what it would have
been without a trial: nothing has to be brought over. What the copy costs is the step itself, and 10 to 30 ms.

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
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

log = logging.getLogger(__name__)

SECONDS = 20.0
"""How long a step may take: what takes longer has not been seen to end."""
_PATIENCE = 4.0
"""Seconds of the clock that a copy has for each of the processor's."""
_LEFT = 0.75
"""Share of the machine's free memory that a step may take."""


@dataclass(frozen=True, eq=False)
class _GivenUp:
    """What did not come to its end: a note each, and the seconds that were waited for steps of one kind."""

    notes: list[str] = field(default_factory=list)
    waited: dict[str, float] = field(default_factory=lambda: defaultdict(float))


_given_up: ContextVar[_GivenUp | None] = ContextVar("given_up", default=None)


def survives(step: Callable[[], object], what: str, *, library: str = "OpenCASCADE", seconds: float = SECONDS) -> bool:
    """Whether a step comes to its end, with a result or an exception of its own, in a copy of this process.

    Parameters
    ----------
    step : callable
        Must do the same every time, and change nothing that is to stay.
    what : str
        What the step does, for the note where it does not come to its end: ``unifying faces``. Steps of one kind that
        together were waited for in vain for `SECONDS` are not tried any more in a run.
    library : str
        Whose step it is.
    seconds : float
        Of the processor that it may take, so that a busy machine gives the same mesh; of the clock `_PATIENCE` times
        as many, for what waits and does nothing.
    """
    told = _given_up.get() or _GivenUp()
    if told.waited[what] >= SECONDS:
        return False
    if not hasattr(os, "fork"):
        return True
    ours, theirs = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of other threads; the copy runs the step alone
        child = os.fork()
    if child == 0:
        _do(step, theirs, seconds)
    os.close(theirs)
    try:
        ready, _, _ = select.select([ours], [], [], _PATIENCE * seconds)
        done = bool(ready) and os.read(ours, 1) == b"1"
    finally:
        os.close(ours)
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
    if not done:
        late = not ready or (os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGPROF)
        how = f"took more than {seconds:g} s" if late else f"ended its process ({_ending(status)})"
        told.waited[what] += seconds if late else 0.0
        give_up(what, f"{library} {how}")
    return done


def give_up(what: str, why: str) -> None:
    """Note that a step was given up, once."""
    said = f"{what} was given up: {why}"
    log.info("%s", said)
    told = _given_up.get() or _GivenUp()
    if said not in told.notes:
        told.notes.append(said)


@contextlib.contextmanager
def noting() -> Iterator[list[str]]:
    """Collect a note for every step that did not come to its end."""
    told = _GivenUp()
    token = _given_up.set(told)
    try:
        yield told.notes
    finally:
        _given_up.reset(token)


def _do(step: Callable[[], object], pipe: int, seconds: float) -> None:
    """The copy's life: quiet, bounded in time and memory, without a core file, and without what exits run."""
    try:
        import resource  # not everywhere where there is no fork

        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        faulthandler.disable()
        signal.signal(signal.SIGPROF, signal.SIG_DFL)
        signal.setitimer(signal.ITIMER_PROF, seconds)  # of the processor's time: it ends the copy
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        with contextlib.suppress(ValueError, OSError):  # a lower limit is set already
            free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
            own = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * os.sysconf("SC_PAGE_SIZE")
            resource.setrlimit(resource.RLIMIT_AS, (own + int(_LEFT * free), resource.RLIM_INFINITY))
        with contextlib.suppress(Exception):  # an exception is an end, too
            step()
        os.write(pipe, b"1")
    finally:
        os._exit(0)


def _ending(status: int) -> str:
    return signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else "out of memory"
