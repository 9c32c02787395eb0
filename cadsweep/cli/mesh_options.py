"""The options of commands that mesh: which there are, and what they mean to ``sweep_mesh``."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import click

from ..choices import FUNCTIONALS, STRATEGIES
from ..errors import InputError
from ..options import INTERFACES, SweepOptions
from .types import (
    Assignment,
    Bias,
    Grading,
    Layers,
    Names,
    Numbers,
    Place,
    Positive,
    Size,
    is_script,
    parse_cap,
    parse_parameter,
)

BIAS_HELP = (
    "Grading along the sweep: thickness of the last layer over the first's, or 'SOURCE,TARGET', "
    "the middle's over each end's."
)


PART = click.option("--part", metavar="NAME|NUMBER", help="Which solid of an assembly: its name, or its number from 0.")
TOUCH = click.option(
    "--touch", type=Positive(), help="Distance up to which solids of an assembly are taken to touch, model units."
)
CUT_OVERLAPS = click.option(
    "--cut-overlaps", is_flag=True, help="Cut the larger of two solids of an assembly where they overlap."
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


SUPPRESS = click.option(
    "--suppress",
    multiple=True,
    metavar="FEATURES",
    help="Remove features first: 'fillets r<0.5', 'holes d<2', 'face 12', a face's name; of one solid of an assembly: "
    "'pin: holes d<2'; repeatable.",
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
        click.option(
            "--bridge",
            type=click.FloatRange(min=0.0),
            metavar="L",
            help="Distance up to which the mesh may leave the CAD at tips of faces and at low embossing; 0: nowhere.",
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
        CUT_OVERLAPS,
        click.option(
            "--interfaces",
            type=click.Choice(INTERFACES),
            default="auto",
            show_default=True,
            help="Whether solids that touch share nodes (auto: where that can be had), or get contacts named in pairs.",
        ),
        ONLY,
        SKIP,
        click.option("--skip-unmeshable", is_flag=True, help="Leave out solids of an assembly that cannot be meshed."),
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
            "--name",
            "names",
            type=Assignment(),
            multiple=True,
            metavar="NAME=FACE",
            help="Name a face or an edge, by id or CadQuery selector: 'inlet=face 7'; repeatable, also for one name.",
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
            "--order", type=click.IntRange(1, 8), default=1, show_default=True, help="Order of the hexahedra."
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
            help="Seconds after which no more cuts are looked for (20): the best found until then are taken.",
        ),
        SUPPRESS,
        click.option(
            "--decompose/--no-decompose",
            default=True,
            show_default=True,
            help="Cut a solid that no sweep fits into cells.",
        ),
        click.option(
            "--without",
            multiple=True,
            metavar="ROW",
            help="Switch a rule off by its name, as 'cap: fan'; may be repeated.",
        ),
        click.option(
            "--fitted/--no-fitted",
            default=None,
            help="Fill the solid by a fitted grid, or never; without it, where nothing else makes a mesh.",
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
    named: dict[str, list[str]] = {}
    for name, chosen in given["names"]:
        named.setdefault(name, []).append(chosen)
    given["names"] = named or None
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
