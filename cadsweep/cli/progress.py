"""A progress bar for steps over a second, on a terminal; nothing in a pipe."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

PATIENCE = 1.0
"""Seconds that a step may take unseen."""

SHARES = {
    "cad": 0.3,
    "recognition": 0.05,
    "intervals": 0.02,
    "surface": 0.25,
    "projection": 0.1,
    "assembly": 0.03,
    "quality": 0.15,
    "write": 0.1,
}
"""Typical shares of the stages in the time of a mesh: most of them call libraries that do not say how far they are, so
what is left of the run is estimated from the stages that are behind it."""


class ProgressBar:
    """A context manager whose call is the callback ``(stage, fraction)``.

    Parameters
    ----------
    quiet : bool
        Never show anything.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        self._show = not quiet and sys.stderr.isatty()
        self._bar: Any = None
        self._task: Any = None
        self._stage = ""
        self._begin = self._since = time.monotonic()
        self._reached = 0.0
        self._seen = (0.0, self._begin)

    def __enter__(self) -> ProgressBar:
        return self

    def __call__(self, stage: str, fraction: float | None = None) -> None:
        if not self._show:
            return
        now = time.monotonic()
        if stage.partition(",")[0] != self._stage:  # after a comma, how far it is in words
            self._stage, self._since = stage.partition(",")[0], now
        if self._bar is None and now - self._since < PATIENCE:
            return
        if self._bar is None:
            self._start()
        done = self._done(stage, fraction)
        if done > self._seen[0]:
            self._seen = (done, now)
        self._bar.update(self._task, description=stage, total=None if done == 0.0 else 1.0, completed=done)

    def _done(self, stage: str, fraction: float | None) -> float:
        """How much of the run is done where the stage is one of a mesh, else how much of the stage; 0 if unknown."""
        if stage in SHARES:
            stages = list(SHARES)
            before = sum(SHARES[one] for one in stages[: stages.index(stage)])
            # A second candidate begins again, and the bar waits for it.
            self._reached = max(self._reached, before + SHARES[stage] * (fraction or 0.0))
        return self._reached or fraction or 0.0

    def left(self, now: float) -> str:
        """The estimate: what is done took so long, so what is left takes in proportion."""
        done, at = self._seen
        if not done:
            return "-:--"
        begin = self._begin if self._reached else self._since
        seconds = max(0.0, (at - begin) / done - (now - begin))
        return f"{int(seconds // 60)}:{int(seconds % 60):02}"

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn, TimeElapsedColumn
        from rich.text import Text

        bar = self

        class Left(ProgressColumn):
            def render(self, task: Task) -> Text:
                return Text(bar.left(time.monotonic()), style="progress.remaining")

        self._bar = Progress(
            TextColumn("{task.description:<12}"),
            BarColumn(),
            TimeElapsedColumn(),
            Left(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task = self._bar.add_task(self._stage, total=None)
        self._bar.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()
