"""The processes that work for a page: one that keeps the part, one that makes a mesh and can be ended at once.

Place in the flow: the server's event loop awaits them; each is called from a thread of its own, and what crashes,
hangs or eats the memory is a child of this process and not this process.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

from ..errors import CadSweepError
from ..isolation import Worker, run_isolated
from ..machine import free_memory

READING_TIME = 600.0
"""Seconds after which reading a part is taken for hung."""


class StoppedError(CadSweepError):
    """The user ended the work."""


@dataclass(kw_only=True, eq=False)
class Stage:
    """A stage of the work under way: its name, when it began, and when it ended."""

    name: str
    began: float
    ended: float | None = None
    fraction: float | None = None

    @property
    def seconds(self) -> float:
        """How long it has taken so far."""
        return (time.monotonic() if self.ended is None else self.ended) - self.began


@dataclass(kw_only=True, eq=False)
class Job:
    """One piece of work in a process of its own, which can be ended.

    Attributes
    ----------
    stages : list of Stage
        Those so far, in the order in which they were entered; one that comes again goes on.
    """

    stages: list[Stage] = field(default_factory=list)
    began: float = field(default_factory=time.monotonic)
    _stop: threading.Event = field(default_factory=threading.Event)

    def end(self) -> None:
        """End it; its process is killed within a blink."""
        self._stop.set()

    @property
    def ending(self) -> bool:
        """Whether it was asked to end."""
        return self._stop.is_set()

    @property
    def seconds(self) -> float:
        """Since it began."""
        return time.monotonic() - self.began

    def run(self, function: str, args: Sequence[Any], kwargs: dict[str, Any], *, remove: Sequence[str] = ()) -> Any:
        """Call a function in a child; blocks the thread that it is called in.

        Raises
        ------
        StoppedError
            :meth:`end` was called.
        CadSweepError
            As the function raised it, or the child crashed.
        """
        return run_isolated(function, args, kwargs, max_memory=free_memory(), on_progress=self._note, remove=remove)

    def _note(self, stage: str, fraction: float | None) -> None:
        if self._stop.is_set():
            raise StoppedError("ended by the user")
        now = time.monotonic()
        if self.stages and self.stages[-1].name == stage:
            self.stages[-1].fraction = fraction
            return
        if self.stages:
            self.stages[-1].ended = now
        self.stages.append(Stage(name=stage, began=now, fraction=fraction))


class Jobs:
    """The processes of one server: all of them end with it."""

    def __init__(self) -> None:
        self._reader = Worker()
        self._reading = ThreadPoolExecutor(1, "cadsweep-reader")
        self._working = ThreadPoolExecutor(4, "cadsweep-job")
        self._under_way: set[Job] = set()
        self._closing = threading.Event()

    async def read(self, function: str, *args: Any, remove: Sequence[str] = (), **kwargs: Any) -> Any:
        """Call a function of :mod:`.work` in the process that keeps the part, one call after the other."""

        def look(stage: str, fraction: float | None) -> None:
            if self._closing.is_set():
                raise StoppedError("the server ends")

        def call() -> Any:
            return self._reader.run(
                f"cadsweep.app.work:{function}", args, kwargs, timeout=READING_TIME, on_progress=look,
                max_memory=free_memory(), remove=remove,
            )  # fmt: skip

        return await asyncio.get_running_loop().run_in_executor(self._reading, call)

    async def work(self, job: Job, function: str, *args: Any, remove: Sequence[str] = (), **kwargs: Any) -> Any:
        """Call a function of :mod:`.work` in a process that lives as long as the call."""
        self._under_way.add(job)
        try:
            return await asyncio.get_running_loop().run_in_executor(
                self._working, lambda: job.run(f"cadsweep.app.work:{function}", args, kwargs, remove=remove)
            )
        finally:
            self._under_way.discard(job)

    async def compute(self, function: Callable[[], Any]) -> Any:
        """Call a function of this process in a thread, so that the page is answered meanwhile."""
        return await asyncio.get_running_loop().run_in_executor(self._working, function)

    def close(self) -> None:
        """End everything, and wait until it has ended."""
        self._closing.set()
        for job in list(self._under_way):
            job.end()
        self._reading.shutdown(wait=True, cancel_futures=True)
        self._working.shutdown(wait=True, cancel_futures=True)
        self._reader.end()
