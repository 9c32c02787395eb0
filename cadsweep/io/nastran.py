"""Nastran bulk data, ``.bdf``: solids, pressure sides and sets, a deck to complete, or lines of another's bulk data.

Place in the flow: a format module of :mod:`cadsweep.io`. A part is a ``PSOLID``, whose number its material has too
(``MAT1`` is the deck's); a boundary is a load set of ``PLOAD4`` of one unit, inwards (``LOAD`` scales it), and a
``SET1`` of its nodes, of the same number; other groups of elements are a ``SET1``. Names stand in
comments before the first card of each, as Femap writes them: ``$ Femap Load Set 3 : inlet``.

Coordinates have 16 characters (``GRID*``): what needs more is rounded to what fits. Elements have fields of eight,
or of sixteen where numbers have more than eight digits.

Not handled: hex27. Reading knows fixed fields, small and large, not commas.

References
----------
MSC Nastran quick reference guide, GRID, CHEXA (corners, then bottom, upright, top edges), PLOAD4 (G1 a corner of the
side, G3 the one across), PSOLID, SET1.
"""

from __future__ import annotations

import re
from typing import BinaryIO

import numpy as np

from ..arrays import IntArray, distinct
from ..cells import HEX_FACES
from ..errors import InputError
from ..mesh import HexMesh
from . import decks
from .compare import Groups
from .labels import LabelledMesh
from .text import write_list, write_rows

POINT_TOLERANCE = 1e-9
MAX_NAME = 60
HEX_ORDER = {8: np.arange(8), 20: np.array([*range(12), 16, 17, 18, 19, 12, 13, 14, 15])}
"""``nastran_nodes = vtk_nodes[:, HEX_ORDER[n]]``."""

_MOST_SMALL = 99_999_999
_TITLE = re.compile(rb"\$ Femap (Property|Load Set|Set) +(\d+) : (\w+)")


def write(
    stream: BinaryIO,
    mesh: LabelledMesh,
    *,
    first_node: int = 1,
    first_element: int = 1,
    first_part: int = 1,
    prefix: str = "",
    include: bool = False,
) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    first_node, first_element, first_part : int
        Numbers of the first node and element, and of the first property and set.
    prefix : str
        Before every name.
    include : bool
        Write bulk data alone, for ``INCLUDE`` in another deck; else with SOL, CEND, BEGIN BULK and ENDDATA around it.
    """
    n, m, size = len(mesh.points), len(mesh.hexes), mesh.hexes.shape[1]
    if size not in HEX_ORDER:
        raise InputError("Nastran has no hex27; make the mesh with order=2, nodes=20")
    decks.check_numbering(prefix=prefix, first_node=first_node, first_element=first_element, first_part=first_part)
    wide = max(n + first_node, m + first_element) > _MOST_SMALL
    groups = decks.deck_groups(mesh, prefix)
    stream.write(f"${decks.HEAD}nodes, elements, sides and sets; the bulk data of a deck\n".encode())
    stream.write(b"" if include else b"SOL 101\nCEND\nBEGIN BULK\n")
    write_rows(
        stream,
        "GRID*   %16d                %16r%16r\n*       %16r\n",
        np.arange(first_node, n + first_node),
        mesh.points,
    )
    for pid, ids in enumerate(groups.parts.values(), first_part):
        row = _card("CHEXA", ["%d", str(pid), *["%d"] * size], wide)
        write_rows(stream, row, ids + first_element, mesh.hexes[ids][:, HEX_ORDER[size]] + first_node)
    for pid, (name, (own, material)) in enumerate(groups.materials(prefix).items(), first_part):
        mid = own + first_part - 1
        said = f"$ Femap Material {mid} : {material}\n" if material else ""
        stream.write(f"{said}$ Femap Property {pid} : {name}\nPSOLID  {pid:8d}{mid:8d}\n".encode())
    for sid, (name, face) in enumerate(groups.faces.items(), first_part):
        stream.write(f"$ Femap Load Set {sid} : {name}\n".encode())
        fields = [str(sid), "%d", "1.0", "", "", "", "%d", "%d"]
        write_rows(stream, _card("PLOAD4", fields, wide), face.of + first_element, face.quads[:, [0, 2]] + first_node)
        _write_set(stream, sid, distinct(face.quads) + first_node, wide)
    for sid, (name, ids) in enumerate(groups.sets.items(), first_part + len(groups.faces)):
        stream.write(f"$ Femap Set {sid} : {name}\n".encode())
        _write_set(stream, sid, ids + first_element, wide)
    stream.write(b"" if include else b"ENDDATA\n")
    stream.write(f"${decks.END}\n".encode())


def _card(name: str, fields: list[str], wide: bool) -> str:
    """The format of a card: eight fields of eight characters a line, or four of sixteen."""
    width, per_line, mark = (16, 4, "*") if wide else (8, 8, "+")
    text = [f"%{width}d" if field == "%d" else field.rjust(width) for field in fields]
    lines = ["".join(text[j : j + per_line]) for j in range(0, len(text), per_line)]
    return f"{name + '*' * wide:8}" + f"\n{mark:8}".join(lines) + "\n"


def _write_set(stream: BinaryIO, sid: int, ids: IntArray, wide: bool) -> None:
    width, per_line, mark = (16, 4, "*") if wide else (8, 8, "+")
    stream.write(f"{'SET1' + '*' * wide:8}{sid:{width}d}".encode())
    write_list(stream, f"%{width}d", ids[: per_line - 1], per_line=per_line)
    write_list(stream, f"%{width}d", ids[per_line - 1 :], per_line=per_line, begin=f"{mark:8}")


def kept_groups(mesh: LabelledMesh, *, prefix: str = "", **_options: object) -> Groups:
    """All boundaries, parts and sets."""
    return decks.deck_kept(mesh, prefix)


_GOES_ON = np.isin(np.arange(256), np.frombuffer(b" +*,", dtype=np.uint8))
"""Whether a line that begins with a character goes on with the card before it."""


def read(stream: BinaryIO) -> HexMesh:
    """Read GRID, CHEXA, PLOAD4 and SET1 cards, and the names that stand in comments."""
    content = decks.deck_content(stream, "$")
    titles: dict[str, dict[int, str]] = {"Property": {}, "Load Set": {}, "Set": {}}
    for kind, number, name in _TITLE.findall(content):
        titles[kind.decode()][int(number)] = name.decode()
    found = decks.DeckParts.empty()
    sets: dict[int, list[IntArray]] = {}
    rows: dict[str, list[np.ndarray]] = {"CHEXA": [], "PLOAD4": []}
    for table in _whole_cards(content):
        starts = np.flatnonzero(~_GOES_ON[table[:, 0]])
        counts = np.diff([*starts.tolist(), len(table)])
        names = np.ascontiguousarray(table[starts, :8]).view("S8").ravel()
        for name in np.unique(names).tolist():
            for count in np.unique(counts[names == name]).tolist():
                at = starts[(names == name) & (counts == count)]
                _take(name.decode("ascii", "replace").strip(), _joined(table, at, count), found, rows, sets)
    if not found.points or not rows["CHEXA"]:
        raise InputError("it has no nodes (GRID) or no hexahedra (CHEXA) in fixed fields")
    elements = np.concatenate(rows["CHEXA"])
    size = elements.shape[1] - 2
    found.hex_tags, found.hexes = [elements[:, 0]], [elements[:, 2:][:, np.argsort(HEX_ORDER[size])]]
    found.parts = {
        titles["Property"].get(pid, f"part_{pid}"): [elements[elements[:, 1] == pid, 0]]
        for pid in distinct(elements[:, 1]).tolist()
    }
    found.parts |= {name: sets[sid] for sid, name in titles["Set"].items() if sid in sets}
    order = np.argsort(elements[:, 0], kind="stable")
    sides = {}
    loads = np.concatenate([*rows["PLOAD4"], np.empty((0, 4), np.int64)])
    for sid in distinct(loads[:, 0]).tolist():
        own = loads[loads[:, 0] == sid]
        corners = found.hexes[0][order[decks.rows_of(elements[order, 0], own[:, 1])], :8]
        sides[titles["Load Set"].get(sid, f"load_{sid}")] = own[:, 1], _sides_across(corners, own[:, 2], own[:, 3])
    return found.mesh(sides=sides)


def _whole_cards(content: decks.mmap.mmap) -> list[np.ndarray]:
    """Lines (n, 72) of cards, none of which is torn."""
    tables, left = [], np.empty((0, 72), dtype=np.uint8)
    for text in decks.cut_at_lines(content, 0, len(content)):
        table = np.vstack([left, decks.line_table(text, 72, b"$")])
        last = len(table) - 1
        while last > 0 and table[last, 0] in b" +*,":
            last -= 1
        tables.append(table[:last])
        left = table[last:]
    return [table for table in (*tables, left) if len(table)]


def _joined(table: np.ndarray, starts: IntArray, count: int) -> np.ndarray:
    """The fields of cards of so many lines (n, 64 * count)."""
    return np.hstack([table[starts + line, 8:72] for line in range(count)])


def _take(
    name: str,
    fields: np.ndarray,
    found: decks.DeckParts,
    rows: dict[str, list[np.ndarray]],
    sets: dict[int, list[IntArray]],
) -> None:
    width = 16 if name.endswith("*") else 8
    kind = name.rstrip("*")
    if kind == "GRID":
        found.node_tags.append(decks.field_numbers(fields, [(0, width)]).ravel())
        try:
            found.points.append(decks.field_numbers(fields, decks.slots(2 * width, width, 3), np.float64))
        except InputError:
            _refuse_bare_exponents(fields, width)
            raise
    elif kind == "CHEXA":
        blank = (fields[:, : 22 * width].reshape(len(fields), -1, width) == 32).all(axis=2)
        sizes = np.unique((~blank).sum(axis=1) - 2).tolist()
        if len(sizes) != 1 or sizes[0] not in HEX_ORDER:
            raise InputError(f"its CHEXA have {sizes} nodes; 8 or 20 are read")
        rows[kind].append(decks.field_numbers(fields, decks.slots(0, width, sizes[0] + 2)))
    elif kind == "PLOAD4" and (fields[:, 6 * width : 8 * width] != 32).any(axis=1).all():
        columns = [(j * width, (j + 1) * width) for j in (0, 1, 6, 7)]
        rows[kind].append(decks.field_numbers(fields, columns))
    elif kind == "SET1":
        for card in fields:
            blanks = np.full((len(card) // width, 1), 32, dtype=np.uint8)
            numbers = decks.parse_numbers(np.hstack([card.reshape(-1, width), blanks]).tobytes(), np.int64)
            sets.setdefault(int(numbers[0]), []).append(numbers[1:])
    elif kind in {"CTETRA", "CPENTA", "CPYRAM", "CPYRA"}:
        raise InputError(f"it has elements of type {kind}; only CHEXA is read")


def _refuse_bare_exponents(fields: np.ndarray, width: int) -> None:
    """Say so where numbers leave out the letter of their exponent."""
    # A number that fills its field stands right before the sign of the next one: fields are looked at one by one.
    blanks = np.full((fields.size // width, 1), 32, dtype=np.uint8)
    if re.search(rb"[\d.][+-]\d", np.hstack([fields.reshape(-1, width), blanks]).tobytes()):
        raise InputError("it has numbers without the letter of their exponent (1.5-3); write them as 1.5E-3")


def _sides_across(corners: IntArray, first: IntArray, third: IntArray) -> IntArray:
    """Sides of hexes (n, 8) on which two nodes lie across."""
    found = np.full(len(corners), -1, dtype=np.int64)
    for side, face in enumerate(HEX_FACES):
        for a, c in ((0, 2), (1, 3), (2, 0), (3, 1)):
            found[(corners[:, face[a]] == first) & (corners[:, face[c]] == third)] = side
    if (found < 0).any():
        raise InputError("a PLOAD4 names two nodes that are not across a side of its element")
    return found
