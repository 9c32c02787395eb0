"""How a mesh file is written: the options of the commands that write one, and what they mean for its format."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from ..errors import InputError
from .types import Assignment, Positive

UNITS = {"mm": 1.0, "cm": 0.1, "m": 1e-3, "in": 1 / 25.4, "ft": 1 / 304.8}
"""What a length in millimetres, the unit of CAD files and scripts, is multiplied by."""


def writing_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say how the file is written; most belong to one format."""
    options = [
        click.option("--scale", type=Positive(), help="Write coordinates times this."),
        click.option(
            "--units", type=click.Choice(list(UNITS)), help="Write coordinates in this unit; the model's is mm."
        ),
        click.option(
            "--msh-version",
            "version",
            type=click.Choice(["4.1", "2.2", "fluent"]),
            help="Of .msh files; 4.1 unless said.",
        ),
        click.option(
            "--element-type",
            "element",
            metavar="TYPE",
            help="Of .inp files: C3D8I, C3D8R, C3D20R, DC3D8, ...; of .k and .cdb files a number.",
        ),
        click.option("--first-node", type=click.IntRange(1, 10**9), help="Number of the first node, of a deck."),
        click.option("--first-element", type=click.IntRange(1, 10**9), help="Number of the first element, of a deck."),
        click.option("--prefix", metavar="TEXT", help="Before the names of sets and surfaces, of a deck."),
        click.option(
            "--ties/--no-ties",
            default=None,
            help="Tie contacts of solids that share no nodes, in decks that can; they are, unless said.",
        ),
        click.option(
            "--patch-type",
            "patch_types",
            type=Assignment(click.Choice(["patch", "wall", "symmetry", "symmetryPlane", "empty", "wedge"])),
            multiple=True,
            metavar="NAME=TYPE",
            help="Type of an OpenFOAM patch; 'wall' and '..._wall' are walls by name; may be repeated.",
        ),
        click.option(
            "--structured", is_flag=True, default=None, help="Structured zones in a .cgns file, a mapped block each."
        ),
        click.option(
            "--max-blocks",
            type=click.IntRange(1),
            help="Structured blocks of a part at the most, in .xyz and .cgns files.",
        ),
        click.option(
            "--letter",
            "letters",
            type=Assignment(),
            multiple=True,
            metavar="NAME=LETTER",
            help="Nek's letter of a boundary in a .re2 file: W, v, O, SYM, ...; MSH unless said; may be repeated.",
        ),
    ]
    for option in reversed(options):
        command = option(command)
    return command


def take_writing_options(output: str, given: dict[str, Any]) -> dict[str, Any]:
    """Options of ``HexMesh.write`` from those of the command; one that the format lacks is wrong usage."""
    names = ("version", "element", "first_node", "first_element", "prefix", "ties", "structured", "max_blocks")
    chosen = {name: value for name in names if (value := given.pop(name)) is not None}
    for name in ("patch_types", "letters"):
        if assigned := dict(given.pop(name)):
            chosen[name] = assigned
    scale, units = given.pop("scale"), given.pop("units")
    if scale is not None and units is not None:
        raise click.UsageError("--scale and --units say the same; give one of them")
    scale = UNITS[units] if units is not None else scale
    if chosen and not output.endswith(".sweep.npz"):
        from ..io import check_options

        try:
            check_options(output, chosen)
        except InputError as error:
            raise click.UsageError(str(error)) from error
    if chosen and output.endswith(".sweep.npz"):
        raise click.UsageError("a file of factors has no options of a mesh format; give them to 'cadsweep expand'")
    return chosen if scale is None or scale == 1.0 else {**chosen, "scale": scale}
