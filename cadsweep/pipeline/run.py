"""The clock and the voice of one run: seconds by stage, progress for whoever asked."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from ..progress import Progress


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """Seconds by stage, and the progress callback."""

    on_progress: Progress
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        self.on_progress(name, 0.0)
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start
        self.on_progress(name, 1.0)


def silent(stage: str, fraction: float | None) -> None:
    """Progress for those who did not ask."""
