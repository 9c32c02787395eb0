"""Commands that make files of meshes: ``mesh``, ``expand``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..errors import InputError
from .mesh_options import FAMILY, checked_options, sweep_options
from .parallel import is_rank, mesh_over_ranks
from .show import announce
from .worker import QUIET, VERBOSE, limits, run
from .writing import take_writing_options, writing_options


@click.command(short_help="Mesh a part.")
@click.argument("input_file", metavar="INPUT")
@click.option("-o", "--output", required=True, metavar="OUT", help="The mesh file; its suffix names the format.")
@sweep_options
@writing_options
@click.option(
    "--like",
    metavar="BASE.sweep.npz",
    help="Make the same mesh as that of a part whose faces and edges correspond, from the file of its factors.",
)
@FAMILY
@click.option("--stream", is_flag=True, help="Make and write slab by slab, for meshes larger than memory (.vtkhdf).")
@limits
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@QUIET
@VERBOSE
def mesh(
    *,
    input_file: str,
    output: str,
    like: str | None,
    family: int | None,
    stream: bool,
    timeout: float,
    max_memory: float | None,
    as_json: bool,
    quiet: bool,
    verbose: bool,
    **given: Any,
) -> None:
    """Mesh the part INPUT (.step .stp .brep .iges .igs .FCStd, or a CadQuery script .py, which is executed)."""
    check_suffix(output)
    writing = take_writing_options(output, given)
    options = checked_options(input_file, given)
    options["max_memory"] = max_memory
    if writing and (stream or is_rank() or output.endswith(".sweep.npz")):
        raise click.UsageError("--scale and --units go with files that are written whole")
    if stream and (Path(output).suffix.lower() != ".vtkhdf" or options["order"] != 1):
        raise click.UsageError("--stream writes meshes of order 1 to .vtkhdf files")
    if like is not None:
        if stream or output.endswith(".sweep.npz") or is_rank():
            raise click.UsageError("--like goes with a mesh in memory, of one process")
        options["like"] = like
    if family is not None and (stream or output.endswith(".sweep.npz") or is_rank()):
        raise click.UsageError("--family goes with meshes in memory, of one process")
    if is_rank():
        summary = mesh_over_ranks(input_file, output, options)
        if summary is None:
            return
        announce(summary, output, as_json=as_json, quiet=quiet, verbose=verbose)
        return
    summary = run(
        "mesh_file",
        input_file,
        output,
        stream=stream,
        options=options,
        family=family,
        writing=writing,
        output=output,
        timeout=timeout,
        max_memory=max_memory,
        quiet=quiet,
    )
    announce(summary, output, as_json=as_json, quiet=quiet, verbose=verbose)


@click.command(short_help="Make a mesh from its factors.")
@click.argument("factors", metavar="PART.sweep.npz")
@click.option("-o", "--output", required=True, metavar="OUT", help="The mesh file; its suffix names the format.")
@writing_options
@limits
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@QUIET
def expand(
    *,
    factors: str,
    output: str,
    timeout: float,
    max_memory: float | None,
    as_json: bool,
    quiet: bool,
    **given: Any,
) -> None:
    """Multiply the factors of a sweep out to a mesh file: the same mesh, bit for bit."""
    check_suffix(output)
    writing = take_writing_options(output, given)
    summary = run(
        "expand_file",
        factors,
        output,
        writing=writing,
        output=output,
        timeout=timeout,
        max_memory=max_memory,
        quiet=quiet,
    )
    announce(summary, output, as_json=as_json, quiet=quiet)


def check_suffix(output: str) -> None:
    """A name that no writer goes with is wrong usage."""
    from ..io import FORMATS, check_destination

    if Path(output).suffix.lower() in FORMATS or output.endswith(".sweep.npz"):
        return  # whether the folder is there and writable is no question of usage
    try:
        check_destination(output)
    except InputError as error:
        raise click.UsageError(str(error)) from error
