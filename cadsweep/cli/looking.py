"""Commands that look at a part or a mesh: ``info``, ``check``, ``view``, ``report``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from ..errors import CadSweepError
from .failure import describe_failure
from .mesh_options import CUT_OVERLAPS, FAMILY, ONLY, PART, SKIP, SUPPRESS, TOUCH, checked_options, sweep_options
from .show import announce, print_info
from .types import Assignment, Positive, is_script, parse_cap, parse_parameter
from .worker import DEFAULT_TIMEOUT, QUIET, VERBOSE, limits, run


@click.command(short_help="Show faces and sweeps of a part.")
@click.argument("input_file", metavar="INPUT")
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
@CUT_OVERLAPS
@ONLY
@SKIP
@SUPPRESS
@click.option("--edges", is_flag=True, help="List the edges, too: what --edge-size, --edge-count, --rail-layers name.")
@click.option("--source", metavar="NAME|ID", help="Only sweeps with this source cap, as for 'cadsweep mesh'.")
@click.option("--target", metavar="NAME|ID", help="Only sweeps with this target cap.")
@limits
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@QUIET
@VERBOSE
def info(
    *,
    input_file: str,
    params: tuple[tuple[str, str], ...],
    part: str | None,
    touch: float | None,
    cut_overlaps: bool,
    only: tuple[str, ...] | None,
    skip: tuple[str, ...] | None,
    suppress: tuple[str, ...],
    edges: bool,
    source: str | None,
    target: str | None,
    timeout: float,
    max_memory: float | None,
    as_json: bool,
    quiet: bool,
    verbose: bool,
) -> None:
    """List the faces of a part, the sweeps found, and why the other candidates are none."""
    if params and not is_script(input_file):
        raise click.UsageError(f"--param goes with a CadQuery script (.py), and {input_file} is none")
    values = {name: parse_parameter(text) for name, text in params} or None
    data = run(
        "describe_part",
        input_file,
        params=values,
        part=part,
        touch=touch,
        cut_overlaps=cut_overlaps,
        only=only,
        skip=skip,
        suppress=list(suppress),
        caps=(parse_cap(source), parse_cap(target)),
        timeout=timeout,
        max_memory=max_memory,
        quiet=quiet,
    )
    if as_json:
        click.echo(json.dumps(data))
    else:
        print_info(data, edges=edges, verbose=verbose)


@click.command(short_help="Check a mesh file.")
@click.argument("mesh_files", metavar="MESH...", nargs=-1, required=True)
@click.option("--strict", is_flag=True, help="One line a file, and only of what is wrong: for hooks and CI.")
@click.option("--min-scaled-jacobian", type=float, metavar="X", help="A mesh whose worst hexahedron is below fails.")
@click.option("--max-aspect", type=Positive(), metavar="X", help="A mesh with a more stretched hexahedron fails.")
@limits
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object a file.")
@QUIET
def check(
    *,
    mesh_files: tuple[str, ...],
    strict: bool,
    min_scaled_jacobian: float | None,
    max_aspect: float | None,
    timeout: float,
    max_memory: float | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Show every quality and validity figure of mesh files; exit code 0 if all are valid and within limits, else 1."""
    all_well = True
    for mesh_file in mesh_files:
        try:
            data = run("check_file", mesh_file, timeout=timeout, max_memory=max_memory, quiet=quiet or strict)
        except CadSweepError as error:  # the others are checked all the same
            all_well = False
            failure = describe_failure(error)
            if as_json:
                click.echo(json.dumps({"file": mesh_file, "passed": False, "error": failure}))
            elif strict and not quiet:
                click.echo(f"{mesh_file}: {failure['message']}")
            else:
                click.echo(f"cadsweep: {failure['message']}", err=True)
            continue
        text = data.pop("text")
        wrong = list(data["problems"])
        worst, aspect = data["min_scaled_jacobian"], data["metrics"]["aspect"]["max"]
        if min_scaled_jacobian is not None and not (worst is not None and worst >= min_scaled_jacobian):
            wrong.append(f"the worst scaled Jacobian is {worst}, below {min_scaled_jacobian}")
        if max_aspect is not None and not (aspect is not None and aspect <= max_aspect):
            wrong.append(f"the largest aspect ratio is {aspect}, above {max_aspect}")
        all_well &= not wrong
        if as_json:
            click.echo(json.dumps({"file": mesh_file, **data, "passed": not wrong, "failures": wrong}))
        elif strict and not quiet:
            for problem in wrong:
                click.echo(f"{mesh_file}: {problem}")
        elif not quiet:
            click.echo("\n".join([text, *(f"limit: {problem}" for problem in wrong[len(data["problems"]) :])]))
    return 0 if all_well else 1


@click.command(short_help="Show a mesh.")
@click.argument("mesh_file", metavar="MESH")
@click.option("--screenshot", metavar="FILE.png", help="Write a picture instead of opening a window.")
@click.option(
    "--clip",
    type=click.Choice(["x", "y", "z", "-x", "-y", "-z"]),
    help="Take away the half on this side, and look inside.",
)
@click.option("--crinkle", is_flag=True, help="With --clip: keep whole hexahedra instead of cutting them smoothly.")
@click.option(
    "--color",
    type=click.Choice(["quality", "boundary", "part", "cad"]),
    default="quality",
    show_default=True,
    help="By scaled Jacobian, boundary or part, or as the CAD model is coloured (.vtu, .vtkhdf).",
)
@click.option(
    "--explode", type=click.FloatRange(min=0.0), default=0.0, help="Draw the parts of an assembly apart: 0.5, 1."
)
@QUIET
def view(
    *,
    mesh_file: str,
    screenshot: str | None,
    clip: str | None,
    crinkle: bool,
    color: str,
    explode: float,
    quiet: bool,
) -> None:
    """Show a mesh file in a window, coloured by scaled Jacobian, with its boundaries by name and CAD colour."""
    timeout = float("inf") if screenshot is None else DEFAULT_TIMEOUT
    if crinkle and clip is None:
        raise click.UsageError("--crinkle goes with --clip")
    scalars = "scaled_jacobian" if color == "quality" else color
    options = {"clip": clip, "crinkle": crinkle, "scalars": scalars, "explode": explode}
    run("view_file", mesh_file, screenshot=screenshot, options=options, output=screenshot, timeout=timeout, quiet=quiet)


@click.command(short_help="Mesh a part and write a page about it.")
@click.argument("input_file", metavar="INPUT")
@click.option("-o", "--output", required=True, metavar="PAGE.html", help="The page, one file.")
@sweep_options
@FAMILY
@limits
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object: the figures of the mesh, and the page.")
@QUIET
@VERBOSE
def report(
    *,
    input_file: str,
    output: str,
    family: int | None,
    timeout: float,
    max_memory: float | None,
    as_json: bool,
    quiet: bool,
    verbose: bool,
    **given: Any,
) -> None:
    """Mesh a part and write one interactive page: the mesh, the sweep, its quality, the time it took."""
    options = checked_options(input_file, given)
    if Path(output).suffix.lower() not in (".html", ".htm"):
        raise click.UsageError(f"the page is an .html file, not '{output}'")
    options["max_memory"] = max_memory
    summary = run(
        "report_file",
        input_file,
        output,
        options=options,
        family=family,
        command=_command_line(),
        output=output,
        timeout=timeout,
        max_memory=max_memory,
        quiet=quiet,
    )
    announce(summary, output, as_json=as_json, quiet=quiet, verbose=verbose)


def _command_line() -> str:
    """The command as it was given, ready to be pasted."""
    import shlex
    import sys

    return shlex.join(["cadsweep", *sys.argv[1:]])
