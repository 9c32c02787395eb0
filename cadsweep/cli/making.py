"""Commands that make files of meshes: ``mesh``, ``expand``, ``batch``."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from ..choices import FUNCTIONALS, STRATEGIES
from ..errors import CadSweepError, InputError
from ..options import INTERFACES, SweepOptions
from .parallel import is_rank, mesh_over_ranks
from .show import mesh_lines
from .types import (
    Assignment,
    Bias,
    Grading,
    Layers,
    Names,
    Numbers,
    Place,
    Positive,
    Shard,
    Size,
    is_script,
    parse_cap,
    parse_parameter,
)
from .worker import QUIET, VERBOSE, limits, run
from .writing import take_writing_options, writing_options

BIAS_HELP = (
    "Grading along the sweep: thickness of the last layer over the first's, or 'SOURCE,TARGET', "
    "the middle's over each end's."
)


PART = click.option("--part", metavar="NAME|NUMBER", help="Which solid of an assembly: its name, or its number from 0.")
TOUCH = click.option(
    "--touch", type=Positive(), help="Distance up to which solids of an assembly are taken to touch, model units."
)


ONLY = click.option("--only", type=Names(), metavar="A,B", help="Solids of an assembly to be taken, by name.")
SKIP = click.option("--skip", type=Names(), metavar="A,B", help="Solids of an assembly to be left out, by name.")

CUT = click.option(
    "--cut",
    "cuts",
    multiple=True,
    metavar="PLANE|FACE|FILE",
    help="Cut the part first: 'plane z=3', 'plane 1,1,0,2.5', 'face 12' extended, or the faces of a file; repeatable.",
)


FAMILY = click.option(
    "--family",
    type=click.IntRange(3, 7),
    metavar="N",
    help="Refine the mesh into a family of N nested ones, and show how volume and areas converge.",
)


def sweep_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say how to mesh."""
    options = [
        click.option(
            "--size",
            type=Size(),
            multiple=True,
            metavar="S|SOLID=S",
            help="Edge length of the quads, model units; of one solid of an assembly: gasket=0.5; may be repeated.",
        ),
        click.option(
            "--tolerance",
            type=Positive(),
            metavar="T",
            help="Greatest distance of the mesh's boundary from the CAD faces, model units.",
        ),
        click.option("--layers", type=click.IntRange(min=1, max=10**8), help="Layers of hexahedra along the sweep."),
        click.option("--bias", type=Bias(), metavar="B[,B]", help=BIAS_HELP),
        click.option("--fractions", type=Numbers(), help="Places of the layers, rising from 0 to 1: 0,0.1,0.4,1."),
        click.option(
            "--functional",
            type=click.Choice(FUNCTIONALS, case_sensitive=False),
            default="H",
            show_default=True,
            help="Functional of the affine fit.",
        ),
        click.option(
            "--strategy",
            type=click.Choice(STRATEGIES),
            default="both",
            show_default=True,
            help="Where inner layers are placed from.",
        ),
        click.option(
            "--residual/--no-residual",
            default=True,
            show_default=True,
            help="Carry what the affine fit leaves of the boundary into the inside.",
        ),
        click.option(
            "--smoothing/--no-smoothing", default=True, show_default=True, help="Mend what the checks find wrong."
        ),
        PART,
        TOUCH,
        click.option(
            "--interfaces",
            type=click.Choice(INTERFACES),
            default="shared",
            show_default=True,
            help="Whether solids that touch share nodes, or get contacts named in pairs.",
        ),
        ONLY,
        SKIP,
        click.option("--source", metavar="NAME|ID", help="Source cap: name, id or CadQuery selector."),
        click.option("--target", metavar="NAME|ID", help="Target cap."),
        click.option(
            "--face-size",
            "sizes",
            type=Assignment(Positive(), prefix="faces:"),
            multiple=True,
            metavar="FACE=SIZE",
            help="Edge length on the edges of a face, by name, id or CadQuery selector; may be repeated.",
        ),
        click.option(
            "--edge-size",
            "edge_sizes",
            type=Assignment(Positive(), prefix="edges:"),
            multiple=True,
            metavar="EDGE=SIZE",
            help="Edge length on an edge, by name, id (see 'cadsweep info --edges') or selector; may be repeated.",
        ),
        click.option(
            "--edge-count",
            "counts",
            type=Assignment(click.IntRange(min=1)),
            multiple=True,
            metavar="EDGE=N",
            help="Segments that an edge must get; may be repeated.",
        ),
        click.option(
            "--rail-layers",
            type=Assignment(click.IntRange(min=1)),
            multiple=True,
            metavar="EDGE=N",
            help="Layers along an edge that runs along the sweep, or in a span: 'span 2=8'; may be repeated.",
        ),
        click.option(
            "--local-size",
            "local_sizes",
            type=Place(),
            multiple=True,
            metavar="SIZE@PLACE:RADIUS",
            help="Edge length around a point x,y,z, a face, an edge or 'vertices:>X': '0.5@10,0,5:3'; repeatable.",
        ),
        click.option(
            "--edge-bias",
            "biases",
            type=Assignment(Grading()),
            multiple=True,
            metavar="EDGE=RATIO@TOWARDS",
            help="Grade an edge towards a face, a vertex, a point x,y,z, 'both' ends or the 'middle': "
            "'edges:|X=5@clamp', the longest segment over the shortest, or 'edges:|X=first:0.1@clamp'; repeatable.",
        ),
        click.option(
            "--wall-layers",
            type=Assignment(Layers()),
            multiple=True,
            metavar="FACE=FIRST:GROWTH:N",
            help="Layers along a face: height of the first, growth, number: 'wall=0.05:1.2:8'; repeatable.",
        ),
        click.option(
            "--periodic",
            type=Assignment(),
            multiple=True,
            metavar="FACE=FACE",
            help="Faces whose meshes answer each other node by node: left=right; repeatable.",
        ),
        click.option(
            "--param",
            "params",
            type=Assignment(),
            multiple=True,
            metavar="NAME=VALUE",
            help="Parameter of a CadQuery script; may be repeated.",
        ),
        click.option(
            "--order", type=click.IntRange(1, 2), default=1, show_default=True, help="Order of the hexahedra."
        ),
        click.option(
            "--nodes",
            type=click.Choice([20, 27]),
            default=20,
            show_default=True,
            help="Nodes of a hexahedron of order 2.",
        ),
        click.option(
            "--refine",
            type=click.IntRange(0, 8),
            default=0,
            metavar="K",
            help="Make every hexahedron of the finished mesh into eight, K times; new nodes lie on the CAD model.",
        ),
        CUT,
        click.option(
            "--decompose-time",
            type=Positive(),
            metavar="S",
            help="Seconds after which no more cuts are looked for: the best found until then are taken.",
        ),
        click.option(
            "--suppress",
            multiple=True,
            metavar="FEATURES",
            help="Remove features first: 'fillets r<0.5', 'holes d<2', 'face 12', a face's name; repeatable.",
        ),
        click.option(
            "--decompose/--no-decompose",
            default=True,
            show_default=True,
            help="Cut a solid that no sweep fits into cells.",
        ),
        click.option("--allow-inverted", is_flag=True, help="Write a mesh that is not valid, marked as such."),
        click.option(
            "--allow-coarse", is_flag=True, help="Write a mesh whose volume or area is more than 5 % off the CAD's."
        ),
        click.option(
            "--max-hexes",
            type=click.IntRange(min=1),
            help="Refuse a larger mesh before work starts; without it, one of more than 5 million in memory.",
        ),
        click.option("--yes", is_flag=True, help="Make the mesh, however large it is."),
    ]
    for option in reversed(options):
        command = option(command)
    return command


def checked_options(source: str, given: dict[str, Any]) -> dict[str, Any]:
    """Options of ``sweep_mesh`` from those of the command; a value out of its range is wrong usage."""
    pairs = given.pop("params")
    if pairs and not is_script(source):
        raise click.UsageError(f"--param goes with a CadQuery script (.py), and {source} is none")
    given["params"] = {name: parse_parameter(text) for name, text in pairs} or None
    plain = [size for name, size in given["size"] if name is None]
    by_solid = tuple((name, size) for name, size in given["size"] if name is not None)
    given["size"] = plain[-1] if plain else None
    given["sizes"] = dict(by_solid + given["sizes"] + given.pop("edge_sizes")) or None
    given["counts"], given["rail_layers"] = dict(given["counts"]) or None, dict(given["rail_layers"]) or None
    given["biases"] = dict(given["biases"]) or None
    given["local_sizes"] = list(given["local_sizes"]) or None
    given["periodic"] = dict(given["periodic"]) or None
    given["wall_layers"] = dict(given["wall_layers"]) or None
    if given.pop("yes"):
        if given["max_hexes"] is not None:
            raise click.UsageError("--yes allows any number of hexahedra, --max-hexes a certain one: give one of them")
        given["max_hexes"] = math.inf
    given["cuts"] = list(given["cuts"]) or None
    given["suppress"] = list(given["suppress"]) or None
    given["source"], given["target"] = parse_cap(given["source"]), parse_cap(given["target"])
    try:
        SweepOptions(**given)
    except InputError as error:
        raise click.UsageError(str(error)) from error
    return given


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
        _announce(summary, output, as_json=as_json, quiet=quiet, verbose=verbose)
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
    _announce(summary, output, as_json=as_json, quiet=quiet, verbose=verbose)


def _announce(summary: dict[str, Any], output: str, *, as_json: bool, quiet: bool, verbose: bool = False) -> None:
    if as_json:
        click.echo(json.dumps({**{k: v for k, v in summary.items() if k != "convergence_lines"}, "file": output}))
    elif not quiet:
        click.echo("\n".join(mesh_lines(summary, output, verbose=verbose)))


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
    _announce(summary, output, as_json=as_json, quiet=quiet)


def check_suffix(output: str) -> None:
    """A name that no writer goes with is wrong usage."""
    from ..io import FORMATS, check_destination

    if Path(output).suffix.lower() in FORMATS or output.endswith(".sweep.npz"):
        return  # whether the folder is there and writable is no question of usage
    try:
        check_destination(output)
    except InputError as error:
        raise click.UsageError(str(error)) from error


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
