"""LS-DYNA keyword input, ``.k``: solids, parts, and sets of nodes, segments and solids, to be included in a deck.

Place in the flow: a format module of :mod:`cadsweep.io`. Every boundary is a ``*SET_SEGMENT`` (outward: a positive
pressure of ``*LOAD_SEGMENT_SET`` presses on it) and a ``*SET_NODE_LIST`` of the same number and title; every part a
``*PART``, whose number its material has too (``*MAT_...`` is the deck's), all of one ``*SECTION_SOLID``. Contacts of
solids that share no nodes are ``*CONTACT_TIED_SURFACE_TO_SURFACE_ID``.

Coordinates have 16 characters, in the long format, which is taken on request and where a number has more than eight
digits, 20: what needs more is rounded to what fits.

Not handled: hex27. Reading knows fixed columns, not commas.

References
----------
LS-DYNA keyword user's manual, volume I: *KEYWORD (LONG), *NODE, *ELEMENT_SOLID, *SET_SEGMENT, *CONTACT; of nodes of
*ELEMENT_SOLID_H20 gmsh's writer (``GModelIO_KEY.cpp``): bottom, top, upright edges, as in VTK.
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
from .text import write_list, write_rows
from .ties import find_ties

POINT_TOLERANCE = 1e-9
MAX_NAME = 70
_ELEMENTS = {8: ("*ELEMENT_SOLID", 1), 20: ("*ELEMENT_SOLID_H20", 23)}
"""Keyword, and the formulation (ELFORM) of the section."""

_MOST_SHORT = 99_999_999


def write(
    stream: BinaryIO,
    mesh: LabelledMesh,
    *,
    element: str | None = None,
    first_node: int = 1,
    first_element: int = 1,
    first_part: int = 1,
    prefix: str = "",
    ties: bool = True,
    long: bool | None = None,
) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    element : str, optional
        Formulation of the section, ELFORM: 1 by default, 23 for twenty nodes.
    first_node, first_element, first_part : int
        Numbers of the first node and element, and of the first part, section, set and contact.
    prefix : str
        Before every title.
    ties : bool
        Tie the two sides of every contact between parts that share no nodes.
    long : bool, optional
        Fields of 20 characters; else only where numbers need them.
    """
    n, m, size = len(mesh.points), len(mesh.hexes), mesh.hexes.shape[1]
    if size not in _ELEMENTS:
        raise InputError("hex27 is not written as LS-DYNA's; make the mesh with order=2, nodes=20")
    keyword, formulation = _ELEMENTS[size]
    if element is not None:
        try:
            formulation = int(element)
        except ValueError:
            raise InputError(
                f"an element of LS-DYNA is a number, ELFORM, such as 1, 2 or -1, not {element!r}"
            ) from None
    decks.check_numbering(prefix=prefix, first_node=first_node, first_element=first_element, first_part=first_part)
    wide = long or max(n + first_node, m + first_element) > _MOST_SHORT
    i8, i10, real = ("%20d", "%20d", "%20r") if wide else ("%8d", "%10d", "%16r")
    groups = decks.deck_groups(mesh, prefix)
    stream.write(f"${decks.HEAD}nodes, solids, parts and sets; to be included in a deck\n".encode())
    stream.write(b"*KEYWORD LONG=Y\n*NODE\n" if wide else b"*KEYWORD\n*NODE\n")
    write_rows(stream, i8 + real * 3 + "\n", np.arange(first_node, n + first_node), mesh.points)
    # Ten numbers a line: elements of eight nodes are one line, others begin with a line of their own.
    nodes = i8 * 8 + "\n" if size == 8 else "\n" + i8 * 10 + "\n" + i8 * 10 + "\n"
    for pid, ids in enumerate(groups.parts.values(), first_part):
        stream.write(f"{keyword}\n".encode())
        row = f"{i8}{pid:{20 if wide else 8}d}{nodes}"
        write_rows(stream, row, ids + first_element, mesh.hexes[ids] + first_node)
    stream.write(b"*SECTION_SOLID\n")
    write_rows(stream, i10 + f"{formulation:{20 if wide else 10}d}\n", np.array([first_part]))
    for pid, (name, (mid, material)) in enumerate(groups.materials(prefix).items(), first_part):
        said = f"$ material {mid + first_part - 1}: {material}\n" if material else ""
        stream.write(f"{said}*PART\n{name}\n".encode())
        write_rows(stream, i10 * 3 + "\n", np.array([[pid, first_part, mid + first_part - 1]]))
    for sid, (name, ids) in enumerate(groups.sets.items(), first_part):
        _head(stream, "*SET_SOLID_TITLE", name, sid, i10)
        write_list(stream, i10, ids + first_element, per_line=8)
    numbers = {name: sid for sid, name in enumerate(groups.faces, first_part)}
    for name, face in groups.faces.items():
        _head(stream, "*SET_SEGMENT_TITLE", name, numbers[name], i10)
        write_rows(stream, i10 * 4 + "\n", face.quads[:, :4] + first_node)
        _head(stream, "*SET_NODE_LIST_TITLE", name, numbers[name], i10)
        write_list(stream, i10, distinct(face.quads) + first_node, per_line=8)
    for cid, tie in enumerate(find_ties(mesh) if ties else (), first_part):
        stream.write(b"*CONTACT_TIED_SURFACE_TO_SURFACE_ID\n")
        write_rows(stream, i10 + f"{prefix}{tie.name}\n", np.array([cid]))
        sides = [numbers[prefix + tie.dependent], numbers[prefix + tie.independent]]
        write_rows(stream, i10 * 4 + "\n\n", np.array([[*sides, 0, 0]]))
        # A negative thickness of both is the distance within which a node finds its segment.
        reach = f"{-tie.reach:{20 if wide else 10}.3g}"
        stream.write(f"{'1.0':>{20 if wide else 10}}{'1.0':>{20 if wide else 10}}{reach}{reach}\n".encode())
    stream.write(f"*END\n${decks.END}\n".encode())


def _head(stream: BinaryIO, keyword: str, name: str, sid: int, field: str) -> None:
    stream.write(f"{keyword}\n{name}\n".encode())
    write_rows(stream, field + "\n", np.array([sid]))


def kept_groups(mesh: LabelledMesh, *, prefix: str = "", **_options: object) -> Groups:
    """All boundaries, parts and sets."""
    return decks.deck_kept(mesh, prefix)


def read(stream: BinaryIO) -> HexMesh:
    """Read nodes, solids, parts and sets with titles."""
    content = decks.deck_content(stream, "$")
    found = decks.DeckParts.empty()
    titles: dict[int, str] = {}
    quads: dict[str, IntArray] = {}
    of_part: list[IntArray] = []
    w8, w10, real = 8, 10, 16
    for head, start, end in decks.keyword_blocks(content, b"*"):
        keyword = head.split()[0].upper()
        if keyword == "*KEYWORD" and "LONG=Y" in head.upper().replace(" ", ""):
            w8 = w10 = real = 20
        elif keyword == "*NODE":
            for table in decks.card_tables(content, start, end, width=w8 + 3 * real, comment=b"$"):
                found.node_tags.append(decks.field_numbers(table, [(0, w8)]).ravel())
                found.points.append(decks.field_numbers(table, decks.slots(w8, real, 3), np.float64))
        elif keyword in {"*ELEMENT_SOLID", "*ELEMENT_SOLID_H20"}:
            size, lines = (8, 1) if keyword == "*ELEMENT_SOLID" else (20, 3)
            first = 2 * w8 if lines == 1 else 10 * w8
            for table in decks.card_tables(content, start, end, width=10 * w8, lines=lines, comment=b"$"):
                rows = decks.field_numbers(table, [(0, w8), (w8, 2 * w8), *decks.slots(first, w8, size)])
                found.hex_tags.append(rows[:, 0])
                of_part.append(rows[:, 1])
                found.hexes.append(rows[:, 2:])
        elif keyword.startswith("*ELEMENT_SOLID"):
            raise InputError(f"it has {keyword}; *ELEMENT_SOLID and *ELEMENT_SOLID_H20 are read")
        elif keyword == "*PART":
            lines_here = decks.lines_of(content, start, end, b"$")
            titles |= {
                int(card[:w10]): name.strip() for name, card in zip(lines_here[::2], lines_here[1::2], strict=True)
            }
        elif keyword in {"*SET_SEGMENT_TITLE", "*SET_SOLID_TITLE"}:
            body = content.find(b"\n", content.find(b"\n", start) + 1) + 1
            name = content[start : content.find(b"\n", start)].decode().strip()
            if keyword == "*SET_SEGMENT_TITLE":
                tables = decks.card_tables(content, body, end, width=4 * w10, comment=b"$")
                quads[name] = np.vstack([decks.field_numbers(table, decks.slots(0, w10, 4)) for table in tables])
            else:
                numbers = decks.parse_numbers(content[body:end], np.int64)
                found.parts[name] = [numbers[numbers > 0]]
    belongs = np.concatenate([*of_part, np.empty(0, np.int64)])
    tags = np.concatenate([*found.hex_tags, np.empty(0, np.int64)])
    own = {titles.get(int(pid), f"part_{pid}"): [tags[belongs == pid]] for pid in distinct(belongs)}
    found.parts = {**own, **found.parts}
    return with_middles(found.mesh(quads=quads))


def with_middles(mesh: HexMesh) -> HexMesh:
    """The same mesh, its boundaries, of corners alone, with the middles of their edges."""
    if mesh.hexes.shape[1] == 8 or not mesh.boundaries:
        return mesh
    boundaries = {}
    for name, quads in mesh.boundaries.items():
        boundaries[name] = decks.quads_of_sides(mesh.hexes, *decks.find_sides(mesh.hexes, quads, mesh.n_nodes))
    return HexMesh(points=mesh.points, hexes=mesh.hexes, boundaries=boundaries, parts=dict(mesh.parts))
