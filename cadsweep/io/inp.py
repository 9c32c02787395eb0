"""Abaqus and CalculiX input, ``.inp``: a mesh made to be included in a deck.

Place in the flow: a format module of :mod:`cadsweep.io`. The file holds nodes, one ``*ELEMENT`` block a part, and every
boundary both as ``*NSET`` and as ``*SURFACE`` of element faces; no material, section or step::

    *INCLUDE, INPUT=part.inp
    *SOLID SECTION, ELSET=part, MATERIAL=steel

Elements are C3D8 or C3D20, or what the option `element` says: C3D8I, C3D8R, C3D20R, ... have the same nodes. Several
files go into one deck where numbers and names are apart: `first_node`, `first_element`, `prefix`. An interface is a
surface on either side, ``a__b`` and ``b__a``, as ``*CONTACT PAIR`` wants them. Solids that were meshed separately are
held together by a ``*TIE`` a contact, unless `ties` is false. A material, where the CAD model names one, is an element
set ``material_<name>``. CalculiX reads 20 characters of a number, so a coordinate of more is rounded to what fits, 13
digits at the least.

Not handled: hex27 (CalculiX has no such element). Reading knows ``*NODE``, ``*ELEMENT``, ``*ELSET``, ``*NSET`` and
``*SURFACE``; other keywords are passed over, ``*INCLUDE`` is not followed.

References
----------
CalculiX CrunchiX user's manual, "Eight-node brick element (C3D8)", "Twenty-node brick element (C3D20)", "*SURFACE": the
order of the nodes, and faces S1 to S6 = 1-2-3-4, 5-8-7-6, 1-5-6-2, 2-6-7-3, 3-7-8-4, 4-8-5-1, as in ``HEX_FACES``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import BinaryIO

import numpy as np

from ..arrays import IntArray, distinct
from ..errors import InputError
from ..mesh import HexMesh
from .compare import Groups, all_boundaries, all_parts
from .decks import check_numbering, material_sets, other_sides, rows_of
from .labels import LabelledMesh
from .sides import find_sides, quads_of_sides
from .text import parse_numbers, write_list, write_rows
from .ties import Tie, find_ties

_FITTING = {8: "C3D8, C3D8I, C3D8R", 20: "C3D20, C3D20R"}

TYPES = {8: "C3D8", 20: "C3D20"}
"""The nodes of C3D20 stand in VTK's order: corners, bottom edges, top edges, upright edges."""

POINT_TOLERANCE = 1e-12
_MAX_NUMBER = 20
_PER_LINE = 16
_HEAD = b"** cadsweep"
_END = b"** end of the mesh"


def write(
    stream: BinaryIO,
    mesh: LabelledMesh,
    *,
    element: str | None = None,
    first_node: int = 1,
    first_element: int = 1,
    prefix: str = "",
    ties: bool = True,
) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    element : str, optional
        Element type with the nodes that the mesh has: ``C3D8I``, ``C3D8R``, ``C3D20R``, ``DC3D8``, ...
    first_node, first_element : int
        Numbers of the first node and the first element.
    prefix : str
        Before every name of a set or a surface.
    ties : bool
        Tie the two sides of every contact between parts that share no nodes.
    """
    size = mesh.hexes.shape[1]
    if size not in TYPES:
        raise InputError("CalculiX and Abaqus/Standard read no hex27; make the mesh with order=2, nodes=20")
    kind = TYPES[size] if element is None else element.upper()
    if _size_of(kind) != size:
        raise InputError(f"an element of type {element} has not the {size} nodes of this mesh; {_FITTING[size]} have")
    check_numbering(prefix=prefix, first_node=first_node, first_element=first_element)
    n = len(mesh.points)
    stream.write(_HEAD + b": nodes, elements, node sets and surfaces; to be included in a deck\n*NODE\n")
    real = f"%.{_MAX_NUMBER}r"
    write_rows(stream, f"%d, {real}, {real}, {real}\n", np.arange(first_node, n + first_node), mesh.points)
    # 16 entries a line at the most: C3D20 goes over two.
    row = "%d" + ", %d" * min(size, _PER_LINE - 1) + (",\n%d" + ", %d" * (size - _PER_LINE) if size > 15 else "") + "\n"
    for block, names in enumerate(mesh.volumes.members):
        ids = mesh.volumes.cells(block)
        stream.write(f"*ELEMENT, TYPE={kind}, ELSET={prefix}{names[0]}\n".encode())
        write_rows(stream, row, ids + first_element, mesh.hexes[ids] + first_node)
    for block, names in enumerate(mesh.volumes.members):
        for name in names[1:]:
            _write_list(stream, f"*ELSET, ELSET={prefix}{name}", mesh.volumes.cells(block) + first_element)
    for name, ids in material_sets(mesh).items():
        _write_list(stream, f"*ELSET, ELSET={prefix}{name}", ids + first_element)
    of, sides = mesh.sides if len(mesh.quads) else (np.empty(0, int), np.empty(0, int))
    for name in mesh.faces.names:
        ids = mesh.faces.named(name)
        _write_list(stream, f"*NSET, NSET={prefix}{name}", distinct(mesh.quads[ids]) + first_node)
        stream.write(f"*SURFACE, NAME={prefix}{name}, TYPE=ELEMENT\n".encode())
        write_rows(stream, "%d, S%d\n", of[ids] + first_element, sides[ids] + 1)
    for name, quads in other_sides(mesh).items():
        owners, own = find_sides(mesh.hexes, quads, n)
        stream.write(f"*SURFACE, NAME={prefix}{name}, TYPE=ELEMENT\n".encode())
        write_rows(stream, "%d, S%d\n", owners + first_element, own + 1)
    if ties:
        _write_ties(stream, find_ties(mesh), prefix)
    stream.write(_END + b"\n")


def _write_ties(stream: BinaryIO, ties: Sequence[Tie], prefix: str) -> None:
    """Nodes of the first surface follow the second; ``ADJUST=NO`` leaves them where they are."""
    for tie in ties:
        head = f"*TIE, NAME={prefix}{tie.name}, POSITION TOLERANCE={tie.reach:.6g}, ADJUST=NO\n"
        stream.write(f"{head}{prefix}{tie.dependent}, {prefix}{tie.independent}\n".encode())


def kept_groups(
    mesh: LabelledMesh,
    *,
    element: str | None = None,
    first_node: int = 1,
    first_element: int = 1,
    prefix: str = "",
    ties: bool = True,
) -> Groups:
    """All groups, interfaces from both sides, materials; with their prefix."""
    del element, first_node, first_element, ties
    boundaries = {**all_boundaries(mesh), **other_sides(mesh)}
    parts = {**all_parts(mesh), **material_sets(mesh)}
    return {prefix + k: v for k, v in boundaries.items()}, {prefix + k: v for k, v in parts.items()}


def _write_list(stream: BinaryIO, head: str, ids: IntArray) -> None:
    stream.write(f"{head}\n".encode())
    whole = (len(ids) - 1) // _PER_LINE * _PER_LINE
    # A comma at the end of a line says that the list goes on in some dialects; none reads a missing one wrong.
    write_list(stream, "%d", ids[:whole], per_line=_PER_LINE, between=", ", end=",\n")
    write_list(stream, "%d", ids[whole:], per_line=_PER_LINE, between=", ")


def read(stream: BinaryIO) -> HexMesh:
    """Read nodes, hexes, sets and surfaces of a deck."""
    stream.seek(0)
    content = stream.read()
    if content.startswith(_HEAD) and _END not in content[-100:]:
        raise InputError("it is cut short: the end of the mesh is missing")
    deck = _Deck()
    for keyword, options, body in _blocks(content):
        deck.take(keyword, options, body)
    return deck.mesh()


def _blocks(content: bytes) -> Iterator[tuple[str, dict[str, str], bytes]]:
    """Keywords with their options, and the lines that follow each, without comments."""
    starts = [match.start() for match in re.finditer(rb"^\*(?=[A-Za-z])", content, re.MULTILINE)]
    for start, end in zip(starts, [*starts[1:], len(content)], strict=True):
        head, _, body = content[start + 1 : end].partition(b"\n")
        if b"**" in body:
            body = re.sub(rb"^\*\*.*$", b"", body, flags=re.MULTILINE)
        words = [word.strip() for word in head.decode("utf-8", "replace").split(",")]
        options = {}
        for word in words[1:]:
            key, _, value = word.partition("=")
            options[key.strip().upper()] = value.strip()
        yield words[0].upper(), options, body


class _Deck:
    """Collects what the keyword blocks of a deck say."""

    def __init__(self) -> None:
        self.node_tags: list[IntArray] = []
        self.points: list[np.ndarray] = []
        self.elements: list[tuple[str, IntArray]] = []
        self.elsets: dict[str, list[IntArray]] = {}
        self.nsets: dict[str, IntArray] = {}
        self.surfaces: dict[str, list[tuple[IntArray | str, IntArray]]] = {}
        """By name: numbers of elements or the name of a set of them, and their sides."""

    def take(self, keyword: str, options: dict[str, str], body: bytes) -> None:
        if keyword == "NODE":
            rows = parse_numbers(body)
            if rows.size % 4:
                raise InputError("a node has not three coordinates, or the file is cut short")
            rows = rows.reshape(-1, 4)
            self.node_tags.append(rows[:, 0].astype(np.int64))
            self.points.append(rows[:, 1:])
        elif keyword == "ELEMENT":
            kind = options.get("TYPE", "").upper()
            size = _size_of(kind)
            if size == 0:
                return
            rows = parse_numbers(body, np.int64)
            if rows.size % (size + 1):
                raise InputError(f"an element of type {kind} has not {size} nodes, or the file is cut short")
            rows = rows.reshape(-1, size + 1)
            self.elements.append((kind, rows))
            if options.get("ELSET"):
                self.elsets.setdefault(options["ELSET"], []).append(rows[:, 0])
        elif keyword == "ELSET" and options.get("ELSET"):
            self.elsets.setdefault(options["ELSET"], []).append(self._list(body, options, self.elsets))
        elif keyword == "SURFACE" and options.get("NAME") and options.get("TYPE", "ELEMENT").upper() == "ELEMENT":
            self.surfaces[options["NAME"]] = list(_sides(body))

    def _list(self, body: bytes, options: dict[str, str], known: dict[str, list[IntArray]]) -> IntArray:
        if "GENERATE" in options:
            rows = parse_numbers(body, np.int64).reshape(-1, 3)
            return np.concatenate([np.arange(a, b + 1, c) for a, b, c in rows.tolist()])
        if re.fullmatch(rb"[\d,\s]+", body):
            return parse_numbers(body, np.int64)
        found = []
        for word in re.split(r"[,\s]+", body.decode("utf-8", "replace").strip(", \n\t\r")):
            found.append(np.concatenate(known[word]) if word in known else np.array([int(word)]))
        return np.concatenate(found)

    def mesh(self) -> HexMesh:
        if not self.points or not self.elements:
            raise InputError("it has no nodes or no hexahedra (C3D8, C3D20)")
        sizes = sorted({rows.shape[1] - 1 for _, rows in self.elements})
        if len(sizes) > 1:
            raise InputError("it has hexes of several orders, or other solid elements too")
        tags = np.concatenate(self.node_tags)
        order = np.argsort(tags, kind="stable")
        elements = np.concatenate([rows for _, rows in self.elements])
        elements = elements[np.argsort(elements[:, 0], kind="stable")]
        points = np.concatenate(self.points)[order]
        hexes = rows_of(tags[order], elements[:, 1:])
        parts = {n: np.sort(rows_of(elements[:, 0], np.concatenate(ids))) for n, ids in self.elsets.items()}
        boundaries = {}
        for name, pairs in self.surfaces.items():
            of = [parts[own] if isinstance(own, str) else rows_of(elements[:, 0], own) for own, _ in pairs]
            sides = [np.broadcast_to(own, len(ids)) for (_, own), ids in zip(pairs, of, strict=True)]
            boundaries[name] = quads_of_sides(hexes, np.concatenate(of), np.concatenate(sides) - 1)
        return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts=parts)


def _size_of(kind: str) -> int:
    """Nodes of a hex type; 0 for elements of fewer dimensions."""
    if re.fullmatch(r"(C3D8|DC3D8|F3D8)[A-Z]*", kind):
        return 8
    if re.fullmatch(r"(C3D20|DC3D20)[A-Z]*", kind):
        return 20
    if re.match(r"D?C3D(4|5|6|10|15|27)", kind):
        raise InputError(f"it has elements of type {kind}; only C3D8 and C3D20 are read")
    return 0


def _sides(lines: bytes) -> Iterator[tuple[IntArray | str, IntArray]]:
    """Elements and sides of a surface: of lines ``12, S3`` all at once, of names of sets one by one."""
    body = lines.upper()
    if re.fullmatch(rb"[\d,S\s]*", body) and body.count(b"S") == body.count(b","):  # none is a set named S1
        rows = parse_numbers(body.replace(b"S", b" "), np.int64).reshape(-1, 2)
        yield rows[:, 0], rows[:, 1]
        return
    for line in lines.decode("utf-8", "replace").splitlines():
        if line.strip():
            words = [word.strip() for word in line.split(",")]
            side = np.array([int(words[1].upper().lstrip("S"))])
            yield (np.array([int(words[0])]) if words[0].isdigit() else words[0]), side
