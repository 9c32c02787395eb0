"""The command ``cut``: the cells of a part as solids of a STEP file."""

from __future__ import annotations

import json
from typing import Any

import click

from .mesh_options import CUT, PART, SUPPRESS, TOUCH
from .types import Assignment, is_script, parse_parameter
from .worker import QUIET, limits, run


@click.command(short_help="Cut a part into cells that sweep.")
@click.argument("input_file", metavar="INPUT")
@click.option("-o", "--output", required=True, metavar="PIECES.step", help="Where the cells go, as touching solids.")
@CUT
@click.option(
    "--param",
    "params",
    type=Assignment(),
    multiple=True,
    metavar="NAME=VALUE",
    help="Parameter of a CadQuery script; may be repeated.",
)
@PART
@TOUCH
@SUPPRESS
@limits
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object: cells, and each cut with its reason.")
@QUIET
def cut(
    *,
    input_file: str,
    output: str,
    cuts: tuple[str, ...],
    params: tuple[tuple[str, str], ...],
    part: str | None,
    touch: float | None,
    suppress: tuple[str, ...],
    timeout: float,
    max_memory: float | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Cut a part into cells that all sweep, as 'cadsweep mesh' does unasked, and write them as solids."""
    if params and not is_script(input_file):
        raise click.UsageError(f"--param goes with a CadQuery script (.py), and {input_file} is none")
    data: dict[str, Any] = run(
        "cut_file",
        input_file,
        output,
        cuts=list(cuts),
        params={name: parse_parameter(text) for name, text in params} or None,
        part=part,
        touch=touch,
        suppress=list(suppress),
        output=output,
        timeout=timeout,
        max_memory=max_memory,
        quiet=quiet,
    )
    if as_json:
        click.echo(json.dumps(data))
    elif not quiet:
        for reason in dict.fromkeys(cut["reason"] for cut in data["cuts"]):
            click.echo(f"cut along {reason}")
        for note in data["notes"]:
            if not note.startswith("cut along"):
                click.echo(f"note: {note}")
        click.echo(f"{output}: {len(data['cells'])} cells")
