"""Ansys Mechanical APDL archive, ``.cdb``: solids, components, and surface elements to load.

Place in the flow: a format module of :mod:`cadsweep.io`. Solids are SOLID185 or SOLID186, or what the option `element`
says. Every part, or other set of hexes, is a component of elements; every boundary a component of nodes, of its name,
and one of SURF154 elements, ``<name>_S154``, which take pressures (``SFE``) and lie on the sides of the solids. The
part's number is material, real constant and section of its hexes.

Names have 27 characters at the most, so that those of faces have 32. Numbers have nine digits, coordinates 17: exact.

Not handled: hex27. Reading knows the block formats that CDWRITE writes.

References
----------
Ansys Mechanical APDL, "CDWRITE", "NBLOCK", "EBLOCK", "CMBLOCK"; Element reference, SOLID186 (corners I to P, middles Q
to B: bottom, top, upright edges, as in VTK) and SURF154.
"""

from __future__ import annotations

import re
from typing import BinaryIO

import numpy as np

from ..arrays import IntArray, distinct
from ..errors import InputError
from ..mesh import HexMesh
from . import decks
from .compare import Groups
from .labels import LabelledMesh
from .text import write_list, write_rows

MAX_NAME = 27
TYPES = {8: 185, 20: 186}
_FITTING = {8: (45, 70, 185, 278), 20: (90, 95, 186, 226, 279)}
"""Element types of so many nodes: structural and thermal solids."""

_SURFACE = 154
_FACES = "_S154"
_MOST = 32
"""Characters of a name."""


def write(
    stream: BinaryIO,
    mesh: LabelledMesh,
    *,
    element: str | None = None,
    first_node: int = 1,
    first_element: int = 1,
    first_part: int = 1,
    prefix: str = "",
    surfaces: bool = True,
) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    element : str, optional
        ``SOLID185``, ``SOLID70``, ... with the nodes that the mesh has.
    first_node, first_element, first_part : int
        Numbers of the first node and element, and of the first material, real constant and section.
    prefix : str
        Before every name of a component.
    surfaces : bool
        Write the surface elements of boundaries.
    """
    n, m, size = len(mesh.points), len(mesh.hexes), mesh.hexes.shape[1]
    if size not in TYPES:
        raise InputError("Ansys has no hex27; make the mesh with order=2, nodes=20")
    number = re.fullmatch(r"(?:SOLID)?(\d+)", (element or f"SOLID{TYPES[size]}").upper())
    if number is None or int(number[1]) not in _FITTING[size]:
        fitting = ", ".join(f"SOLID{kind}" for kind in _FITTING[size])
        raise InputError(f"an element of type {element} has not the {size} nodes of this mesh; {fitting} have")
    decks.check_numbering(prefix=prefix, first_node=first_node, first_element=first_element, first_part=first_part)
    if len(prefix) + len(_FACES) + max(map(len, (*mesh.faces.names, *mesh.volumes.names))) > _MOST:
        raise InputError(f"with the prefix {prefix!r} names have more than {_MOST} characters; take a shorter one")
    groups = decks.deck_groups(mesh, prefix)
    last = n + first_node - 1
    stream.write(f"!{decks.HEAD}nodes, elements and components, for CDREAD,DB\n/PREP7\n".encode())
    stream.write(f"ET,1,{number[1]}\nET,2,{_SURFACE}\n{'KEYOPT,2,4,1' if size == 8 else ''}\n".encode())
    stream.write(f"NBLOCK,6,SOLID,{last:10d},{n:10d}\n(3i9,6e24.16e2)\n".encode())
    row = "%9d        0        0" + "%24.16E" * 3 + "\n"
    write_rows(stream, row, np.arange(first_node, n + first_node), mesh.points)
    stream.write(b"N,R5.3,LOC,       -1,\n")
    quads = [face.quads for face in groups.faces.values()] if surfaces else []
    total = m + sum(map(len, quads))
    stream.write(f"EBLOCK,19,SOLID,{total + first_element - 1:10d},{total:10d}\n(19i9)\n".encode())
    nodes = "%9d" * 8 + ("\n" + "%9d" * 12 if size == 20 else "") + "\n"
    for pid, ids in enumerate(groups.parts.values(), first_part):
        row = _attributes(pid, 1, size) + nodes
        write_rows(stream, row, ids + first_element, mesh.hexes[ids] + first_node)
    starts = np.cumsum([m + first_element, *map(len, quads)]).tolist()
    for own, start in zip(quads, starts, strict=False):
        row = _attributes(first_part, 2, own.shape[1]) + "%9d" * own.shape[1] + "\n"
        write_rows(stream, row, np.arange(start, start + len(own)), own + first_node)
    stream.write(b"       -1\n")
    taken = {name.lower() for name in (*groups.parts, *groups.sets)}
    for name, ids in {**groups.parts, **groups.sets}.items():
        _component(stream, name, "ELEM", ids + first_element)
    for name, face in groups.faces.items():
        _component(stream, _free(name, "_N", taken), "NODE", distinct(face.quads) + first_node)
    for name, start, stop in zip(groups.faces if surfaces else (), starts[:-1], starts[1:], strict=True):
        if (name + _FACES).lower() in taken:
            raise InputError(f"Ansys wants {name + _FACES!r} for the faces of {name!r}; rename one, or surfaces=False")
        _component(stream, name + _FACES, "ELEM", np.arange(start, stop))
    stream.write(f"/GOPR\nFINISH\n!{decks.END}\n".encode())


def _attributes(part: int, kind: int, size: int) -> str:
    """What an element has before its nodes: material, type, real constant, section, ..., nodes, its number."""
    return "".join(f"{value:9d}" for value in (part, kind, part, part, 0, 0, 0, 0, size, 0)) + "%9d"


def _free(name: str, ending: str, taken: set[str]) -> str:
    """The name, ended otherwise where another component has it: all kinds share theirs, whatever their case."""
    while name.lower() in taken:
        name += ending
    taken.add(name.lower())
    return name


def _component(stream: BinaryIO, name: str, kind: str, ids: IntArray) -> None:
    stream.write(f"CMBLOCK,{name},{kind},{len(ids):8d}\n(8i10)\n".encode())
    write_list(stream, "%10d", ids, per_line=8)


def kept_groups(mesh: LabelledMesh, *, prefix: str = "", surfaces: bool = True, **_options: object) -> Groups:
    """All parts and sets; boundaries where their elements are written."""
    boundaries, parts = decks.deck_kept(mesh, prefix)
    return boundaries if surfaces else {}, parts


def read(stream: BinaryIO) -> HexMesh:
    """Read solids, and components of elements: of solids a part, of surface elements a boundary."""
    content = decks.deck_content(stream, "!")
    # Types stand before the elements that have them.
    head = re.compile(rb"\nEBLOCK", re.I).search(content)
    types = content[: head.start() if head else len(content)]
    kinds = {int(number): int(kind) for number, kind in re.findall(rb"\nET *, *(\d+) *, *(\d+)", types, re.I)}
    found = decks.DeckParts.empty()
    components: dict[str, IntArray] = {}
    faces: list[tuple[IntArray, IntArray]] = []
    place = 0
    while (match := _BLOCK.search(content, place)) is not None:
        place = match.end()
        words = [word.strip() for word in match[2].decode("ascii", "replace").split(",")[1:]]
        layout = match[3].decode("ascii", "replace").lower()
        keyword, start = match[1].upper(), match.end()
        if keyword == b"CMBLOCK":
            if words[1].upper().startswith("ELEM"):
                components[words[0].strip()] = _numbers(content, start, layout, int(words[2].split("!")[0]))
            continue
        whole = int(re.findall(r"i(\d+)", layout)[0])
        end = place = _end_of_block(content, start)
        if keyword == b"NBLOCK":
            real = int(re.findall(r"e(\d+)", layout)[0])
            first = whole * int(layout.partition("i")[0] or 1)
            for table in decks.card_tables(content, start, end, width=first + 3 * real):
                found.node_tags.append(decks.field_numbers(table, [(0, whole)]).ravel())
                found.points.append(decks.field_numbers(table, decks.slots(first, real, 3), np.float64))
        else:
            faces += _read_elements(content, (start, end), whole, kinds, found)
    quads = {}
    tags = np.concatenate([own for own, _ in faces]) if faces else np.empty(0, np.int64)
    hexes = np.concatenate([*found.hex_tags, np.empty(0, np.int64)])
    for name, ids in components.items():
        if len(tags) and np.isin(ids, tags).all() and name.upper().endswith(_FACES):
            nodes = np.vstack([rows[np.isin(own, ids)] for own, rows in faces if np.isin(own, ids).any()])
            quads[name[: -len(_FACES)]] = nodes
        elif np.isin(ids, hexes).all():
            found.parts[name] = [ids]
    return found.mesh(quads=quads)


def _read_elements(
    content: decks.mmap.mmap, place: tuple[int, int], whole: int, kinds: dict[int, int], found: decks.DeckParts
) -> list[tuple[IntArray, IntArray]]:
    """Solids of one block go to `found`, numbers and nodes of surface elements are returned.

    Those of more than eight nodes have two lines.
    """
    faces = []
    start, end = place
    lines = np.concatenate(
        list(decks.card_tables(content, start, end, width=19 * whole)) or [np.empty((0, 19 * whole), np.uint8)]
    )
    row = 0
    while row < len(lines):
        size = int(bytes(lines[row, 8 * whole : 9 * whole]))
        n_lines = 1 if size <= 8 else 2
        # Runs of elements of one size and type are read at once.
        heads = lines[row::n_lines, : 9 * whole]
        same = (heads[:, 8 * whole :] == heads[0, 8 * whole :]).all(axis=1)
        same &= (heads[:, whole : 2 * whole] == heads[0, whole : 2 * whole]).all(axis=1)
        count = len(same) if same.all() else int(np.argmin(same))
        own = lines[row : row + count * n_lines].reshape(count, -1)
        row += count * n_lines
        columns = decks.slots(11 * whole, whole, min(size, 8)) + decks.slots(19 * whole, whole, max(0, size - 8))
        if kinds.get(int(bytes(heads[0, whole : 2 * whole]))) == _SURFACE:
            rows = decks.field_numbers(own, [(10 * whole, 11 * whole), *columns])
            faces.append((rows[:, 0], rows[:, 1:]))
        elif size in TYPES:
            rows = decks.field_numbers(own, [(10 * whole, 11 * whole), *columns])
            found.hex_tags.append(rows[:, 0])
            found.hexes.append(rows[:, 1:])
        else:
            raise InputError(f"it has solids of {size} nodes; 8 and 20 are read")
    return faces


_BLOCK = re.compile(rb"^(NBLOCK|EBLOCK|CMBLOCK)([^\n]*)\n\(([^\n]*)\)[^\n]*\n", re.M | re.I)


def _end_of_block(content: decks.mmap.mmap, start: int) -> int:
    """Where the line begins that ends a block: one of -1, or the next command."""
    match = re.compile(rb"\n(?: *-1|[A-Za-z!/])").search(content, start - 1)
    if match is None:
        raise InputError("a block has no end: it is cut short")
    return match.start() + 1


def _numbers(content: decks.mmap.mmap, start: int, layout: str, count: int) -> IntArray:
    """Numbers of a component; a negative one stands for all from the one before it."""
    per_line, width = (int(word) for word in re.findall(r"(\d+)i(\d+)", layout)[0])
    end = start
    for _ in range(-(-count // per_line)):
        end = content.find(b"\n", end) + 1 or len(content)
    table = decks.line_table(content[start:end], per_line * width).reshape(-1, width)
    values = decks.field_numbers(table[:count], [(0, width)]).ravel()
    if len(values) != count:
        raise InputError("a component is cut short")
    if (values > 0).all():
        return values
    rows: list[IntArray] = []
    for value in values.tolist():
        rows.append(np.array([value]) if value > 0 else np.arange(rows[-1][-1] + 1, 1 - value))
    return np.concatenate(rows)
