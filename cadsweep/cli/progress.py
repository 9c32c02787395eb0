"""A progress bar for steps over a second, on a terminal; nothing in a pipe."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any

PATIENCE = 1.0
"""Seconds that a step may take unseen."""


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
        self._since = time.monotonic()

    def __enter__(self) -> ProgressBar:
        return self

    def __call__(self, stage: str, fraction: float | None = None) -> None:
        if not self._show:
            return
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._since = stage, now
        if self._bar is None and now - self._since < PATIENCE:
            return
        if self._bar is None:
            self._start()
        self._bar.update(
            self._task,
            description=stage,
            total=None if fraction is None or fraction == 0.0 else 1.0,
            completed=fraction or 0.0,
        )

    def _start(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

        self._bar = Progress(
            TextColumn("{task.description:<12}"),
            BarColumn(),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
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
