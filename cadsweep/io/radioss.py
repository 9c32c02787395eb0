"""Radioss starter input, ``.rad``: solids, parts, groups and surfaces, to be included in a starter deck.

Place in the flow: a format module of :mod:`cadsweep.io`. Every boundary is a ``/SURF/SEG`` (outward) and a
``/GRNOD/NODE`` of the same number and title; every part a ``/PART``, whose number its property and material have
(``/PROP/TYPE14`` and ``/MAT`` are the deck's); other sets of hexes are ``/GRBRIC/BRIC``. Contacts of solids that share
no nodes are ``/INTER/TYPE2`` (tied).

Coordinates have 20 characters: what needs more is rounded to what fits, 13 digits at the least.

Not handled: hex27.

References
----------
Radioss starter input reference guide: /NODE, /BRICK, /BRIC20 (8, 8 and 4 nodes a line: bottom, upright, top edges; as
gmsh's writer has them), /PART, /SURF/SEG, /GRNOD, /GRBRIC, /INTER/TYPE2.
"""

from __future__ import annotations

from typing import BinaryIO

import numpy as np

from ..arrays import IntArray, distinct
from ..errors import InputError
from ..mesh import HexMesh
from . import decks
from .compare import Groups
from .labels import LabelledMesh
from .lsdyna import with_middles
from .nastran import HEX_ORDER
from .text import write_list, write_rows
from .ties import find_ties

POINT_TOLERANCE = 1e-12


def write(
    stream: BinaryIO,
    mesh: LabelledMesh,
    *,
    first_node: int = 1,
    first_element: int = 1,
    first_part: int = 1,
    prefix: str = "",
    ties: bool = True,
) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    first_node, first_element, first_part : int
        Numbers of the first node and element, and of the first part, group, surface and interface.
    prefix : str
        Before every title.
    ties : bool
        Tie the two sides of every contact between parts that share no nodes.
    """
    n, size = len(mesh.points), mesh.hexes.shape[1]
    if size not in HEX_ORDER:
        raise InputError("Radioss has no hex27; make the mesh with order=2, nodes=20")
    decks.check_numbering(prefix=prefix, first_node=first_node, first_element=first_element, first_part=first_part)
    groups = decks.deck_groups(mesh, prefix)
    stream.write(f"#{decks.HEAD}nodes, solids, parts and groups; to be included in a starter deck\n/NODE\n".encode())
    write_rows(stream, "%10d%20r%20r%20r\n", np.arange(first_node, n + first_node), mesh.points)
    keyword, lines = ("/BRICK", (8,)) if size == 8 else ("/BRIC20", (0, 8, 8, 4))
    row = "%10d" + "\n".join("%10d" * count for count in lines) + "\n"
    for pid, ids in enumerate(groups.parts.values(), first_part):
        stream.write(f"{keyword}/{pid}\n".encode())
        write_rows(stream, row, ids + first_element, mesh.hexes[ids][:, HEX_ORDER[size]] + first_node)
    for pid, (name, (mid, material)) in enumerate(groups.materials(prefix).items(), first_part):
        said = f"# material {mid + first_part - 1}: {material}\n" if material else ""
        stream.write(f"{said}/PART/{pid}\n{name}\n{pid:10d}{mid + first_part - 1:10d}{0:10d}\n".encode())
    for sid, (name, ids) in enumerate(groups.sets.items(), first_part):
        stream.write(f"/GRBRIC/BRIC/{sid}\n{name}\n".encode())
        write_list(stream, "%10d", ids + first_element, per_line=10)
    numbers = {name: sid for sid, name in enumerate(groups.faces, first_part)}
    for name, face in groups.faces.items():
        stream.write(f"/SURF/SEG/{numbers[name]}\n{name}\n".encode())
        write_rows(stream, "%10d" * 5 + "\n", np.arange(1, 1 + len(face.quads)), face.quads[:, :4] + first_node)
        stream.write(f"/GRNOD/NODE/{numbers[name]}\n{name}\n".encode())
        write_list(stream, "%10d", distinct(face.quads) + first_node, per_line=10)
    for number, tie in enumerate(find_ties(mesh) if ties else (), first_part):
        nodes, surface = numbers[prefix + tie.dependent], numbers[prefix + tie.independent]
        fields = "".join(f"{value:10d}" for value in (nodes, surface, 0, 5, 0, 0, 0, 0))
        stream.write(f"/INTER/TYPE2/{number}\n{prefix}{tie.name}\n{fields}{tie.reach:20.6g}\n".encode())
    stream.write(f"#{decks.END}\n".encode())


def kept_groups(mesh: LabelledMesh, *, prefix: str = "", **_options: object) -> Groups:
    """All boundaries, parts and sets."""
    return decks.deck_kept(mesh, prefix)


def read(stream: BinaryIO) -> HexMesh:
    """Read nodes, bricks, parts, groups of bricks and surfaces of segments."""
    content = decks.deck_content(stream, "#")
    found = decks.DeckParts.empty()
    titles: dict[int, str] = {}
    own: dict[int, list[IntArray]] = {}
    sets: dict[str, list[IntArray]] = {}
    quads: dict[str, IntArray] = {}
    for head, start, end in decks.keyword_blocks(content, b"/"):
        words = head.upper().split("/")[1:]
        if words[0] == "NODE":
            for table in decks.card_tables(content, start, end, width=70, comment=b"#"):
                found.node_tags.append(decks.field_numbers(table, [(0, 10)]).ravel())
                found.points.append(decks.field_numbers(table, decks.slots(10, 20, 3), np.float64))
        elif words[0] in {"BRICK", "BRIC20"}:
            size, lines, width = (8, 1, 90) if words[0] == "BRICK" else (20, 4, 80)
            first = 10 if lines == 1 else width
            for table in decks.card_tables(content, start, end, width=width, lines=lines, comment=b"#"):
                rows = decks.field_numbers(table, [(0, 10), *decks.slots(first, 10, size)])
                own.setdefault(int(words[1]), []).append(rows[:, 0])
                found.hex_tags.append(rows[:, 0])
                found.hexes.append(rows[:, 1:][:, np.argsort(HEX_ORDER[size])])
        elif words[0] in {"TETRA4", "TETRA10", "PENTA6", "SHEL16"}:
            raise InputError(f"it has /{words[0]}; /BRICK and /BRIC20 are read")
        elif words[0] in {"PART", "GRBRIC", "SURF"}:
            stop = content.find(b"\n", start, end) + 1 or end
            name = content[start:stop].decode("utf-8", "replace").strip()
            if words[0] == "PART":
                titles[int(words[1])] = name
            elif words[:2] == ["GRBRIC", "BRIC"]:
                numbers = decks.parse_numbers(content[stop:end].partition(b"#")[0], np.int64)
                sets[name] = [numbers]
            elif words[:2] == ["SURF", "SEG"]:
                tables = decks.card_tables(content, stop, end, width=50, comment=b"#")
                quads[name] = np.vstack([decks.field_numbers(table, decks.slots(10, 10, 4)) for table in tables])
    found.parts = {titles.get(pid, f"part_{pid}"): ids for pid, ids in own.items()} | sets
    return with_middles(found.mesh(quads=quads))
