"""I-deas universal file, ``.unv``: nodes, elements, and groups with names.

Place in the flow: a format module of :mod:`cadsweep.io`. Datasets 2411 (nodes), 2412 (elements), 2477 (groups): hexes
are solid bricks, boundary quads thin shells, every boundary and part a group of elements; a boundary's nodes are in its
group too. Groups may overlap. Names have 40 characters at the most.

Not handled: hex27, which the format lacks.

References
----------
SDRC I-deas universal file formats, datasets 2411, 2412 (elements 94, 95, 115, 116) and 2477 (sdrl.uc.edu). A parabolic
element lists corners and middles in turn, ring by ring.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import BinaryIO

import numpy as np

from ..arrays import IntArray, distinct
from ..errors import InputError
from ..mesh import HexMesh
from .labels import LabelledMesh
from .text import parse_numbers, write_list, write_rows

MAX_NAME = 40
HEX_TYPES = {8: 115, 20: 116}
QUAD_TYPES = {4: 94, 8: 95}
HEX_ORDER = {
    8: np.arange(8),
    20: np.array([0, 8, 1, 9, 2, 10, 3, 11, 16, 17, 18, 19, 4, 12, 5, 13, 6, 14, 7, 15]),
}
"""``unv_nodes = vtk_nodes[:, HEX_ORDER[n]]``."""
QUAD_ORDER = {4: np.arange(4), 8: np.array([0, 4, 1, 5, 2, 6, 3, 7])}

_SIZES = {115: 8, 116: 20, 94: 4, 95: 8, 44: 4, 45: 8, 41: 3, 42: 6, 91: 3, 92: 6, 111: 4, 112: 6, 113: 15, 118: 10}
_BEAMS = {11, 21, 22, 23, 24}
_MARK = b"    -1\n"


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    size, width = mesh.hexes.shape[1], mesh.quads.shape[1]
    if size not in HEX_TYPES:
        raise InputError("UNV has no hex27; make the mesh with order=2, nodes=20, or write .msh or .med")
    n, m, q = len(mesh.points), len(mesh.hexes), len(mesh.quads)
    stream.write(_MARK + b"  2411\n")
    write_rows(stream, "%10d         1         1        11\n%25.16E%25.16E%25.16E\n", np.arange(1, n + 1), mesh.points)
    stream.write(_MARK + _MARK + b"  2412\n")
    _write_elements(stream, 1, HEX_TYPES[size], mesh.hexes[:, HEX_ORDER[size]] + 1)
    if q:
        _write_elements(stream, m + 1, QUAD_TYPES[width], mesh.quads[:, QUAD_ORDER[width]] + 1)
    stream.write(_MARK + _MARK + b"  2477\n")
    number = 0
    for name in mesh.faces.names:
        number += 1
        ids = mesh.faces.named(name)
        _write_group(stream, number, name, {8: ids + m + 1, 7: distinct(mesh.quads[ids]) + 1})
    for name in mesh.volumes.names:
        number += 1
        _write_group(stream, number, name, {8: mesh.volumes.named(name) + 1})
    stream.write(_MARK)


def _write_elements(stream: BinaryIO, first: int, kind: int, nodes: IntArray) -> None:
    size = nodes.shape[1]
    lines = [min(8, size - j) for j in range(0, size, 8)]
    row = f"%10d{kind:10d}         1         1         7{size:10d}\n" + "".join("%10d" * k + "\n" for k in lines)
    write_rows(stream, row, np.arange(first, first + len(nodes)), nodes)


def _write_group(stream: BinaryIO, number: int, name: str, members: Mapping[int, IntArray]) -> None:
    """Write a group of entities by kind: 8 elements, 7 nodes."""
    n = sum(map(len, members.values()))
    stream.write(f"{number:10d}{0:10d}{0:10d}{0:10d}{0:10d}{0:10d}{0:10d}{n:10d}\n{name}\n".encode())
    cells = np.zeros((n, 4), dtype=np.int64)
    cells[:, 0] = np.repeat([*members], [len(own) for own in members.values()])
    cells[:, 1] = np.concatenate([*members.values()])
    write_list(stream, "%10d", cells.reshape(-1), per_line=8)


def read(stream: BinaryIO) -> HexMesh:
    """Read bricks, shells, and permanent groups."""
    text = stream.read()
    text = text.replace(b"\r\n", b"\n") if b"\r" in text else text
    sections: dict[int, list[bytes]] = {}
    ends = re.finditer(rb"-1[ \t]*(?:\n|\Z)", text)
    marks = [match for match in ends if not text[text.rfind(b"\n", 0, match.start()) + 1 : match.start()].strip()]
    if len(marks) < 2 or len(marks) % 2:
        raise InputError("it has no datasets between lines of -1, or is cut short")
    for begin, end in zip(marks[::2], marks[1::2], strict=True):
        number, _, body = text[begin.end() : text.rfind(b"\n", 0, end.start()) + 1].partition(b"\n")
        if number.strip().isdigit():
            sections.setdefault(int(number), []).append(body)
    if 2411 not in sections or 2412 not in sections:
        raise InputError("it has no nodes (dataset 2411) or no elements (2412)")
    nodes = parse_numbers(b"\n".join(sections[2411]))
    if len(nodes) % 7:
        raise InputError("a node has not three coordinates: it is cut short")
    nodes = nodes.reshape(-1, 7)
    found: dict[int, list[IntArray]] = {}
    for section in sections[2412]:
        for kind, rows in _elements(parse_numbers(section, np.int64)):
            found.setdefault(kind, []).append(rows)
    return _mesh(
        nodes[:, 0].astype(np.int64),
        nodes[:, 4:],
        found,
        [group for s in (*sections.get(2467, []), *sections.get(2477, [])) for group in _groups(s)],
    )


def _elements(numbers: IntArray) -> Iterator[tuple[int, IntArray]]:
    """Kinds, and runs (r, 1 + size) of elements of each: number and nodes."""
    place = 0
    while place < len(numbers):
        head = numbers[place : place + 6].tolist()
        if len(head) < 6 or head[5] < 1 or (head[1] in _SIZES and head[5] != _SIZES[head[1]]):
            raise InputError(f"element {head[0]} is cut short")
        kind, size = head[1], head[5]
        first = 6 + 3 * (kind in _BEAMS)
        n = (len(numbers) - place) // (first + size)
        rows = numbers[place : place + n * (first + size)].reshape(n, first + size)
        same = (rows[:, 1] == kind) & (rows[:, 5] == size)
        count = n if same.all() else int(np.argmin(same))
        if count == 0:
            raise InputError(f"element {head[0]} is cut short")
        yield kind, np.delete(rows[:count], np.s_[1:first], axis=1)
        place += count * (first + size)


def _groups(section: bytes) -> Iterator[tuple[str, IntArray]]:
    lines = section.split(b"\n")
    lines = lines[:-1] if lines and not lines[-1].strip() else lines
    place = 0
    while place < len(lines):
        n = int(lines[place].split()[7])
        name = lines[place + 1].decode("ascii", "replace").strip()
        n_lines = -(-n // 2)
        members = parse_numbers(b"\n".join(lines[place + 2 : place + 2 + n_lines]), np.int64)
        if len(members) != 4 * n:
            raise InputError(f"group {name!r} is cut short")
        members = members.reshape(n, 4)
        yield name, members[members[:, 0] == 8, 1]
        place += 2 + n_lines


def _mesh(node_tags: IntArray, points: np.ndarray, found: dict[int, list[IntArray]], groups: list) -> HexMesh:
    solids = sorted(set(found) & {111, 112, 113, 115, 116, 118})
    if not solids:
        raise InputError("it has no hexahedra")
    if len(solids) > 1 or solids[0] not in {115, 116}:
        raise InputError(f"it has elements of the kinds {solids}; one of 115 and 116 is read")
    size = _SIZES[solids[0]]
    width = {8: 4, 20: 8}[size]
    rows = np.concatenate(found[solids[0]])
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    shells = [own for kind in (94, 95, 44, 45) for own in found.get(kind, []) if own.shape[1] == width + 1]
    quads = np.concatenate([np.empty((0, width + 1), dtype=np.int64), *shells])
    order = np.argsort(node_tags, kind="stable")
    hexes = order[_place(node_tags[order], rows[:, 1:])][:, np.argsort(HEX_ORDER[size])]
    sides = order[_place(node_tags[order], quads[:, 1:])][:, np.argsort(QUAD_ORDER[width])]
    boundaries, parts = {}, {}
    for name, tags in groups:
        in_hexes, in_quads = np.isin(rows[:, 0], tags), np.isin(quads[:, 0], tags)
        if in_hexes.any():
            parts[name] = np.flatnonzero(in_hexes)
        if in_quads.any() or not in_hexes.any():
            boundaries[name] = sides[in_quads]
    return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts=parts)


def _place(ascending: IntArray, wanted: IntArray) -> IntArray:
    place = np.minimum(np.searchsorted(ascending, wanted), len(ascending) - 1)
    if wanted.size and (ascending[place] != wanted).any():
        raise InputError("an element names a node that is not there")
    return place
