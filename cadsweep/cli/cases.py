"""How a study says how far it is: a bar on a terminal, elsewhere a line a case."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Any

import click

from ..batch import Tally


class CaseProgress:
    """A context manager whose call is the callback of :func:`cadsweep.batch.run_study`.

    Parameters
    ----------
    quiet : bool
        Say nothing.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        self._quiet = quiet
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> CaseProgress:
        return self

    def __call__(self, record: dict[str, Any] | None, tally: Tally) -> None:
        if self._quiet:
            return
        if sys.stderr.isatty():
            self._show(tally)
        elif record is not None:
            click.echo(case_line(record, tally), err=True)

    def _show(self, tally: Tally) -> None:
        done = tally.n_ok + tally.n_failed
        if self._bar is None:
            from rich.console import Console
            from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

            columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
            self._bar = Progress(*columns, console=Console(stderr=True), transient=True)
            self._task = self._bar.add_task("", total=done + tally.n_left, completed=done)
            self._bar.start()
        said = f"{tally.n_ok} ok, {tally.n_failed} failed, {tally.n_left} left"
        self._bar.update(self._task, description=said, completed=done)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()


def case_line(record: dict[str, Any], tally: Tally) -> str:
    """A case in a line: its number, its name, what became of it, seconds."""
    done = tally.n_ok + tally.n_failed
    said = (
        f"ok, {record['n_hexes']} hexahedra, worst scaled Jacobian {record['min_scaled_jacobian']:.3f}"
        if record["status"] == "ok"
        else f"failed, {record['error_type']}: {record['error']}"
    )
    return f"{done}/{done + tally.n_left} {record['case']}: {said}, {record['total_seconds']:.1f} s"
