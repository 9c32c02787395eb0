"""The clock and the voice of one run: seconds by stage, progress for whoever asked."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from ..progress import Progress


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """Seconds by stage, the progress callback, and how long cuts may be looked for."""

    on_progress: Progress
    decompose_time: float = math.inf
    seconds: dict[str, float] = field(default_factory=dict)
    _since: list[float] = field(default_factory=list)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        self.on_progress(name, 0.0)
        start = time.perf_counter()
        if name == "decomposition":
            self._since.append(start)
        try:
            yield
        finally:
            if name == "decomposition":
                self._since.pop()
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start
        self.on_progress(name, 1.0)

    def is_late(self) -> bool:
        """Whether cuts have been looked for as long as the user allows."""
        spent = self.seconds.get("decomposition", 0.0)
        return spent + sum(time.perf_counter() - start for start in self._since) > self.decompose_time


def make_run(on_progress: Progress | None, decompose_time: float | None) -> Run:
    """A run for what a user asks."""
    return Run(on_progress=on_progress or silent, decompose_time=math.inf if decompose_time is None else decompose_time)


def silent(stage: str, fraction: float | None) -> None:
    """Progress for those who did not ask."""
