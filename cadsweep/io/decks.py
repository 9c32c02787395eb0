"""What decks have in common: numbers and names to begin from, groups as decks take them, and reading cards.

Place in the flow: for the modules of :mod:`cadsweep.io` that write input of structural codes. A hex has one part in
most of them, so parts are the disjoint blocks of the mesh; names that are no block of their own are sets of elements,
and so is every material. Boundaries keep their names; an interface is a boundary of either part, ``a__b`` and ``b__a``.
"""

from __future__ import annotations

import mmap
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np

from ..arrays import FloatArray, IntArray
from ..contacts import solids_of
from ..errors import InputError
from ..mesh import HexMesh
from .cgns_zones import turned_quads
from .compare import Groups, all_boundaries
from .labels import LabelledMesh
from .sides import find_sides, quads_of_sides
from .text import parse_numbers

HEAD = " cadsweep: "
END = " end of the mesh"
"""What the first and the last line of a file hold, after the mark of a comment."""

_PIECE = 1 << 24


@dataclass(frozen=True, kw_only=True, eq=False)
class Face:
    """A boundary as the elements see it.

    Attributes
    ----------
    quads : (q, 4 | 8 | 9) int64
        Nodes, from 0.
    of, sides : (q,) int64
        Hexes, and their sides (rows of :data:`~cadsweep.cells.HEX_FACES`).
    """

    quads: IntArray
    of: IntArray
    sides: IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class DeckGroups:
    """The groups of a mesh as a deck has them, by the names that are written.

    Attributes
    ----------
    parts : dict of str to (h,) int64
        Disjoint, every hex in one.
    sets : dict of str to (h,) int64
        Other sets of hexes: names of several parts, materials.
    faces : dict of str to Face
    """

    parts: dict[str, IntArray]
    sets: dict[str, IntArray]
    faces: dict[str, Face]

    def materials(self, prefix: str = "") -> dict[str, tuple[int, str]]:
        """For every part the number and the name of its material; its own, without a name, where none is known."""
        found: dict[str, tuple[int, str]] = {}
        first: dict[str, int] = {}
        sets = {n: ids for n, ids in self.sets.items() if n.startswith(f"{prefix}material_")}
        for number, (part, ids) in enumerate(self.parts.items(), 1):
            name = next((n for n, own in sets.items() if np.isin(ids[0], own)), "")
            found[part] = (first.setdefault(name, number) if name else number, name)
        return found


def check_numbering(*, prefix: str = "", most: int = 10**9, **first: int) -> None:
    """Make sure that first numbers and a prefix of names are such.

    Raises
    ------
    InputError
    """
    for what, number in first.items():
        if not 1 <= int(number) <= most:
            raise InputError(f"{what.replace('_', ' ')} is a number from 1 to {most:g}, not {number}")
    if not re.fullmatch(r"[A-Za-z_]\w*|", prefix):
        raise InputError(f"the prefix {prefix!r} is no beginning of a name: a letter or _, then letters, digits and _")


def deck_groups(mesh: LabelledMesh, prefix: str = "") -> DeckGroups:
    """The groups of a mesh as decks have them."""
    blocks = mesh.volumes.exclusive_names()
    parts = {prefix + name: mesh.volumes.cells(j) for j, name in enumerate(blocks)}
    sets = {prefix + name: mesh.volumes.named(name) for name in mesh.volumes.names if name not in blocks}
    sets |= {prefix + name: ids for name, ids in material_sets(mesh).items() if name not in {*blocks, *sets}}
    of, sides = mesh.sides if len(mesh.quads) else (np.empty(0, np.int64), np.empty(0, np.int64))
    faces = {}
    for name in mesh.faces.names:
        ids = mesh.faces.named(name)
        faces[prefix + name] = Face(quads=mesh.quads[ids], of=of[ids], sides=sides[ids])
    for name, quads in other_sides(mesh).items():
        owners, own = find_sides(mesh.hexes, quads, len(mesh.points))
        faces[prefix + name] = Face(quads=quads, of=owners, sides=own)
    return DeckGroups(parts=parts, sets=sets, faces=faces)


def deck_kept(mesh: LabelledMesh, prefix: str = "") -> Groups:
    """What a deck keeps: all boundaries, interfaces from both sides; disjoint parts, and sets."""
    boundaries = {prefix + name: quads for name, quads in {**all_boundaries(mesh), **other_sides(mesh)}.items()}
    blocks = mesh.volumes.exclusive_names()
    parts = {prefix + name: mesh.volumes.cells(j) for j, name in enumerate(blocks)}
    parts |= {prefix + name: mesh.volumes.named(name) for name in mesh.volumes.names if name not in blocks}
    parts |= {prefix + name: ids for name, ids in material_sets(mesh).items() if prefix + name not in parts}
    return boundaries, parts


def material_sets(mesh: LabelledMesh) -> dict[str, IntArray]:
    """Hexes of every material by the name of its set."""
    return {f"material_{name}": ids for name, ids in mesh.info.get("materials", {}).items()}


def other_sides(mesh: LabelledMesh) -> dict[str, IntArray]:
    """Quads of interfaces as the second part sees them, by the turned name."""
    found: dict[str, IntArray] = {}
    for name in mesh.faces.names:
        solids = solids_of(name, mesh.volumes.names)
        if solids is not None and (turned := "__".join(solids[::-1])) not in mesh.faces.names:
            found[turned] = turned_quads(mesh.quads[mesh.faces.named(name)])
    return found


def deck_content(stream: BinaryIO, comment: str) -> mmap.mmap:
    """The bytes of a file, without reading them all into memory.

    Raises
    ------
    InputError
        It is empty, or one of ours whose end is missing.
    """
    stream.seek(0)
    try:
        content = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
    except ValueError:
        raise InputError("it is empty") from None
    if content[:100].startswith((comment + HEAD).encode()) and (comment + END).encode() not in content[-100:]:
        raise InputError("it is cut short: the end of the mesh is missing")
    return content


def keyword_blocks(content: mmap.mmap, mark: bytes) -> Iterator[tuple[str, int, int]]:
    """Lines that begin with a mark, and where what follows each of them begins and ends."""
    start = 0 if content[:1] == mark else content.find(b"\n" + mark) + 1
    if content[start : start + 1] != mark:
        return
    while start < len(content):
        after = content.find(b"\n" + mark, start) + 1 or len(content)
        head = content.find(b"\n", start, after)
        body = after if head < 0 else head + 1
        yield content[start:body].decode("utf-8", "replace").strip(), body, after
        start = after


def lines_of(content: mmap.mmap, start: int, end: int, comment: bytes) -> list[str]:
    """The lines of a short block, without comments."""
    lines = content[start:end].decode("utf-8", "replace").splitlines()
    return [line for line in lines if line.strip() and not line.startswith(comment.decode())]


def cut_at_lines(content: mmap.mmap, start: int, end: int) -> Iterator[bytes]:
    """Whole lines, some megabytes at a time."""
    while start < end:
        stop = min(end, start + _PIECE)
        if stop < end:
            stop = content.find(b"\n", stop, end) + 1 or end
        yield content[start:stop]
        start = stop


def line_table(text: bytes, width: int, comment: bytes = b"") -> np.ndarray:
    """Characters (n, width) of lines, blanks where a line ends; without empty lines and comments."""
    letters = np.frombuffer(text if text.endswith(b"\n") else text + b"\n", dtype=np.uint8)
    ends = np.flatnonzero(letters == 10)
    starts = np.concatenate([[0], ends[:-1] + 1])
    if len(ends) == 0:
        return np.empty((0, width), dtype=np.uint8)
    ends = ends - ((letters[np.maximum(ends - 1, 0)] == 13) & (ends > starts))
    kept = ends > starts
    if comment:
        kept &= letters[starts] != comment[0]
    if not kept.all():
        starts, ends = starts[kept], ends[kept]
    lengths = np.minimum(ends - starts, width)
    table = np.full((len(starts), width), 32, dtype=np.uint8)
    for length in np.unique(lengths).tolist():
        rows = np.flatnonzero(lengths == length)
        # Every line as a window of the text: no table of indices of each character.
        windows = np.lib.stride_tricks.sliding_window_view(letters, max(length, 1))
        table[rows, :length] = windows[starts[rows], :length]
    return table


def field_numbers(table: np.ndarray, columns: Sequence[tuple[int, int]], dtype: Any = np.int64) -> np.ndarray:
    """Numbers (n, k) of a table's columns.

    Raises
    ------
    InputError
        A field is empty, or no number.
    """
    # A blank after every field: fields of one width that follow each other are copied at once.
    runs: list[list[int]] = []  # begin, width, number of fields
    for a, b in columns:
        if runs and b - a == runs[-1][1] and a == runs[-1][0] + runs[-1][1] * runs[-1][2]:
            runs[-1][2] += 1
        else:
            runs.append([a, b - a, 1])
    spaced = np.full((len(table), sum((width + 1) * count for _, width, count in runs)), 32, dtype=np.uint8)
    at = 0
    for a, width, count in runs:
        own = spaced[:, at : at + (width + 1) * count].reshape(len(table), count, width + 1)
        own[..., :width] = table[:, a : a + width * count].reshape(len(table), count, width)
        at += (width + 1) * count
    values = parse_numbers(spaced.reshape(-1), dtype)
    if len(values) != len(table) * len(columns):
        raise InputError("a line has not as many numbers as it should have, or the file is cut short")
    return values.reshape(len(table), len(columns))


def card_tables(
    content: mmap.mmap, start: int, end: int, *, width: int, lines: int = 1, comment: bytes = b""
) -> Iterator[np.ndarray]:
    """Characters (n, lines * width) of cards of so many lines each, some megabytes at a time."""
    left = np.empty((0, width), dtype=np.uint8)
    for text in cut_at_lines(content, start, end):
        table = np.vstack([left, line_table(text, width, comment)]) if len(left) else line_table(text, width, comment)
        whole = len(table) // lines * lines
        left = table[whole:]
        yield table[:whole].reshape(-1, lines * width)
    if len(left):
        raise InputError("a card has fewer lines than it should have: the file is cut short")


def slots(first: int, width: int, count: int) -> list[tuple[int, int]]:
    """Where fields of one width begin and end."""
    return [(first + j * width, first + (j + 1) * width) for j in range(count)]


@dataclass(kw_only=True, eq=False)
class DeckParts:
    """What a reader found, by the file's own numbers; `mesh` makes a mesh of it."""

    node_tags: list[IntArray]
    points: list[FloatArray]
    hex_tags: list[IntArray]
    hexes: list[IntArray]
    parts: dict[str, list[IntArray]]

    @classmethod
    def empty(cls) -> DeckParts:
        """Nothing yet."""
        return cls(node_tags=[], points=[], hex_tags=[], hexes=[], parts={})

    def mesh(
        self,
        *,
        quads: Mapping[str, IntArray] | None = None,
        sides: Mapping[str, tuple[IntArray, IntArray]] | None = None,
    ) -> HexMesh:
        """A mesh in the order of the file's numbers.

        Parameters
        ----------
        quads : mapping of str to (q, k) int64
            Boundaries by the numbers of their nodes.
        sides : mapping of str to ((q,), (q,)) int64
            Boundaries by the numbers of their elements, and rows of ``HEX_FACES``.

        Raises
        ------
        InputError
            There are no hexahedra, those of several orders, or numbers that nothing has.
        """
        if not self.points or not self.hexes:
            raise InputError("it has no nodes or no hexahedra")
        if len({rows.shape[1] for rows in self.hexes}) > 1:
            raise InputError("it has hexes of several orders")
        tags = np.concatenate(self.node_tags)
        order = np.argsort(tags, kind="stable")
        elements, rows = np.concatenate(self.hex_tags), np.concatenate(self.hexes)
        ranks = np.argsort(elements, kind="stable")
        tags, elements = tags[order], elements[ranks]
        if len(tags) == 0 or len(elements) == 0:
            raise InputError("it has no nodes or no hexahedra")
        if (np.diff(tags) == 0).any() or (np.diff(elements) == 0).any():
            raise InputError("two nodes, or two elements, have one number")
        hexes = rows_of(tags, rows[ranks])
        boundaries = {name: rows_of(tags, own) for name, own in (quads or {}).items()}
        for name, (of, own) in (sides or {}).items():
            boundaries[name] = quads_of_sides(hexes, rows_of(elements, of), own)
        parts = {name: np.sort(rows_of(elements, np.concatenate(ids))) for name, ids in self.parts.items()}
        points = np.concatenate(self.points)[order]
        return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts=parts)


def rows_of(tags: IntArray, wanted: IntArray) -> IntArray:
    """Places of numbers in an ascending list of them.

    Raises
    ------
    InputError
        One is not there.
    """
    if wanted.size == 0:
        return wanted.astype(np.int64)
    if tags[-1] - tags[0] == len(tags) - 1:  # one after the other
        place = wanted - tags[0]
        if int(place.min()) < 0 or int(place.max()) >= len(tags):
            raise InputError("it names a node or an element that is not there")
        return place
    place = np.minimum(np.searchsorted(tags, wanted), len(tags) - 1)
    if (tags[place] != wanted).any():
        raise InputError("it names a node or an element that is not there")
    return place
