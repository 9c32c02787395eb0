"""How a command has its work done: in a worker process, with limits, a progress bar, and nothing left behind."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

import click

from ..errors import WorkerError
from .progress import ProgressBar
from .types import Positive

DEFAULT_TIMEOUT = 3600.0
"""Seconds after which a run is taken for hung: a script may loop for ever, and nobody watches a study at night."""

QUIET = click.option("-q", "--quiet", is_flag=True, help="No progress, and no summary.")
VERBOSE = click.option("-v", "--verbose", is_flag=True, help="Every note, not one line a kind.")


def limits(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that bound a run."""
    command = click.option(
        "--max-memory",
        type=Positive(),
        metavar="GB",
        help="Memory for the run; by default nine tenths of what is free.",
    )(command)
    return click.option(
        "--timeout",
        type=Positive(infinite=True),
        metavar="S",
        default=DEFAULT_TIMEOUT,
        show_default=True,
        help="Wall time for the run, seconds; 'inf' for no limit.",
    )(command)


def run(
    task: str,
    source: str,
    *args: Any,
    output: str | None = None,
    timeout: float = DEFAULT_TIMEOUT,
    max_memory: float | None = None,
    quiet: bool = False,
    **kwargs: Any,
) -> Any:
    """Run a function of :mod:`cadsweep.cli.work` in a worker.

    Parameters
    ----------
    task : str
        Name of the function.
    source : str
        The file it is about, its first argument.
    output : str or None
        The file that is written, so that what a killed writer leaves beside it goes too.
    timeout : float
        Seconds.
    max_memory : float or None
        GB; None: what the machine has.
    """
    from ..isolation import leftovers, run_isolated
    from ..machine import free_memory

    logging.getLogger("cadsweep").addHandler(logging.NullHandler())
    with ProgressBar(quiet=quiet) as bar:
        try:
            return run_isolated(
                f"cadsweep.cli.work:{task}",
                (source, *args),
                kwargs,
                timeout=timeout,
                max_memory=free_memory() if max_memory is None else max_memory,
                on_progress=bar,
                remove=[] if output is None else leftovers(output),
            )
        except WorkerError as error:  # it cannot know what it was at work on
            raise WorkerError(f"{source}: {error.message}", stage=error.stage) from error
