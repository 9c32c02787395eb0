"""The command ``batch``: many cases of one script."""

from __future__ import annotations

import json
from pathlib import Path

import click

from ..errors import CadSweepError
from .types import Shard
from .worker import QUIET


@click.command(short_help="Run a parameter study.")
@click.argument("study", metavar="STUDY.toml")
@click.option("-o", "--output", metavar="FOLDER", help="Where the results go; by default beside the study.")
@click.option("--jobs", type=click.IntRange(min=1), default=1, show_default=True, help="Cases at a time.")
@click.option("--again", is_flag=True, help="Do all cases, whatever results are there.")
@click.option("--strict", is_flag=True, help="Exit code 1 if any case has failed.")
@click.option("--retry-failed", is_flag=True, help="Do failed cases again.")
@click.option("--shard", type=Shard(), metavar="I/N", help="Do every N-th case from the I-th on, beside other shards.")
@click.option("--dask", metavar="ADDRESS", help="Have the cases done by a dask cluster: tcp://scheduler:8786.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@QUIET
def batch(
    *,
    study: str,
    output: str | None,
    jobs: int,
    again: bool,
    strict: bool,
    retry_failed: bool,
    shard: tuple[int, int] | None,
    dask: str | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Mesh every case of a study: a script, and a grid or a list of its parameters.

    \b
    script = "elbow.py"
    format = "vtu"
    [options]
    layers = 20
    [grid]
    bend_radius = [30, 40, 50]
    options.size = [1.0, 2.0]
    [[cases]]
    name = "thin wall"
    wall = 0.5

    A study that was broken off goes on where it was. Failed cases stand in the table with their errors; exit
    code 1 if there is no mesh at all, or, with --strict, if any case has failed.
    """
    from ..batch import read_study, run_study
    from .cases import CaseProgress

    plan = read_study(Path(study))
    folder = None if output is None else Path(output)
    with CaseProgress(quiet=quiet) as progress:
        result = run_study(
            plan,
            folder,
            jobs=jobs,
            again=again,
            retry_failed=retry_failed,
            shard=shard,
            dask=dask,
            on_case=progress,
        )
    if as_json:
        click.echo(json.dumps(result.summary()))
    elif not quiet:
        click.echo(result.line())
    if (result.n_cases and result.n_failed == result.n_cases) or (strict and result.n_failed):
        raise CadSweepError(f"{result.n_failed} of {result.n_cases} cases failed; see {result.table}")
