"""PLOT3D grid, ``.xyz``, with its neutral map, ``.nmf``: structured blocks for flow solvers.

Place in the flow: a format module of :mod:`cadsweep.io`, the only one of two files: the map has the name of the grid,
and both are put in place once both are right. The grid is unformatted Fortran: records of the number of blocks, of
their nodes along i, j and k, and of x, y and z of each block in double precision. The map says what every rectangle of
a side is: ``ONE_TO_ONE`` with where it goes on, else the name of a boundary, disjoint ones where they overlap, or
``UNPROCESSED`` where there is none. Comments ``# part`` name the part of each block.

Blocks are those of :mod:`.grids`. Node numbers are not kept, nor names of quads inside.

Reading knows such files in either order of bytes, with or without the map, of which kinds other than these are taken
for names of boundaries. Without a map what is at one place is one node.

References
----------
PLOT3D User's Manual, NASA TM 101067 (1990), "3D, multi-grid, unformatted". W. T. Jones, "The Neutral Map File", NASA
GEOLAB (kept at the Turbulence Modeling Resource).
"""

from __future__ import annotations

from typing import BinaryIO, cast

import numpy as np

from ..errors import InputError
from ..mesh import HexMesh
from .compare import ExpectedBytes
from .grids import MOST_BLOCKS, Grids, find_grids
from .labels import LabelledMesh
from .patches import Patch, Range, find_patches, join, joined_mesh
from .places import same_places
from .vtk_cells import write_bytes

MOST_ORDER = 1
BESIDE = ".nmf"
"""Suffix of the second file."""

RESERVED = ("ONE_TO_ONE", "UNPROCESSED")
_MOST_RECORD = (1 << 31) - 1


def write(stream: BinaryIO, mesh: LabelledMesh, *, beside: BinaryIO, max_blocks: int = MOST_BLOCKS) -> None:
    """Write a labelled mesh, its map to `beside`.

    Parameters
    ----------
    max_blocks : int
        Structured blocks of a part at the most; a mesh of more was not mapped.
    """
    _put(stream, mesh, beside, max_blocks)


def _put(stream: BinaryIO, mesh: LabelledMesh, beside: BinaryIO, max_blocks: int) -> None:
    grids = find_grids(mesh, most=max_blocks)
    sizes = (grids.shapes + 1).astype("<i4")
    if int((grids.shapes + 1).prod(axis=1).max()) * 24 > _MOST_RECORD:
        raise InputError("a block has more nodes than a record of PLOT3D holds; write .cgns with structured=True")
    _record(stream, np.array([len(sizes)], dtype="<i4"))
    _record(stream, sizes)
    for block in range(len(sizes)):
        _record(stream, np.ascontiguousarray(mesh.points[grids.nodes(block).reshape(-1)].T))
    beside.write(_map(mesh, grids).encode())


def _record(stream: BinaryIO, values: np.ndarray) -> None:
    mark = np.array(values.nbytes, dtype="<i4").tobytes()
    stream.write(mark)
    write_bytes(stream, values)
    stream.write(mark)


def _map(mesh: LabelledMesh, grids: Grids) -> str:
    names, parts = mesh.faces.exclusive_names(), mesh.volumes.exclusive_names()
    lines = ["# Neutral map file of cadsweep", "# Block# IDIM JDIM KDIM", str(len(grids.shapes)), ""]
    for block, shape in enumerate(grids.shapes.tolist(), 1):
        lines.append(f"{block} " + " ".join(str(n + 1) for n in shape))
    solids = mesh.volumes.of_cell[grids.order[grids.first[:-1]]].tolist()
    lines += ["", *(f"# part {block} {parts[solid]}" for block, solid in enumerate(solids, 1))]
    lines += ["# Type B1 F1 S1 E1 S2 E2 B2 F2 S1 E1 S2 E2 Swap"]
    lines += [_line(patch, names) for patch in find_patches(mesh, grids)]
    return "\n".join([*lines, ""])


def _line(patch: Patch, names: tuple[str, ...]) -> str:
    if patch.there is not None:
        return f"ONE_TO_ONE {_numbers(patch.here)} {_numbers(patch.there)} {'TRUE' if patch.swapped else 'FALSE'}"
    return f"{names[patch.label] if patch.label >= 0 else 'UNPROCESSED'} {_numbers(patch.here)}"


def _numbers(part: Range) -> str:
    ends = [n + 1 for pair in zip(part.begin, part.end, strict=True) for n in pair]
    return " ".join(map(str, [part.block + 1, part.side + 1, *ends]))


def verify(stream: BinaryIO, mesh: LabelledMesh, *, beside: BinaryIO, max_blocks: int = MOST_BLOCKS) -> None:
    """Compare every byte of files that were just written with what it should be."""
    sinks = ExpectedBytes(stream), ExpectedBytes(beside)
    _put(cast(BinaryIO, sinks[0]), mesh, cast(BinaryIO, sinks[1]), max_blocks)
    for sink in sinks:
        sink.finish()


def read(stream: BinaryIO, *, beside: BinaryIO | None = None) -> HexMesh:
    """Read blocks, and the map where there is one."""
    content = stream.read()
    if len(content) < 20 or content[:4] not in {b"\4\0\0\0", b"\0\0\0\4"}:
        raise InputError("it does not begin with a record of the number of blocks")
    order = "<" if content[0] else ">"
    place = 0

    def record(kind: str, count: int) -> np.ndarray:
        nonlocal place
        size = count * int(kind[1:])
        if count < 0 or len(content) < place + size + 8 or np.frombuffer(content, f"{order}u4", 1, place)[0] != size:
            raise InputError("a record is not as long as it should be, or the file is cut short")
        values = np.frombuffer(content, order + kind, count, place + 4)
        place += size + 8
        return values

    count = int(record("i4", 1)[0])
    sizes = record("i4", 3 * count).reshape(count, 3).astype(np.int64)
    if count < 1 or (sizes < 2).any():
        raise InputError("it has no blocks of three dimensions")
    places = [record("f8", 3 * int(own.prod())).reshape(3, -1).T.astype(np.float64) for own in sizes]
    shapes = [(int(a), int(b), int(c)) for a, b, c in sizes]
    if beside is None:
        points, number = same_places(np.concatenate(places))
        ends = np.cumsum([len(own) for own in places])[:-1]
        nodes = [own.reshape(shape[::-1]) for own, shape in zip(np.split(number, ends), shapes, strict=True)]
        return joined_mesh(points, nodes, [], [])
    shared, named, parts = _read_map(beside.read().decode("utf-8", "replace"), shapes)
    points, nodes = join(places, shared, shapes)
    return joined_mesh(points, nodes, named, parts)


def _read_map(
    text: str, shapes: list[tuple[int, int, int]]
) -> tuple[list[tuple[Range, Range, bool]], list[tuple[str, Range]], list[str]]:
    """Shared rectangles, named ones, and the part of every block."""
    lines = [line.split() for line in text.splitlines() if line.strip()]
    parts = {int(line[2]): line[3] for line in lines if line[:2] == ["#", "part"] and len(line) == 4}
    rows = [line for line in lines if not line[0].startswith("#")]
    n = len(shapes)
    if not rows or rows[0] != [str(n)] or [tuple(map(int, row[1:4])) for row in rows[1 : n + 1]] != shapes:
        raise InputError("the blocks of its neutral map (.nmf) are not those of the grid; put them side by side again")
    shared, named = [], []
    for row in rows[n + 1 :]:
        if len(row) not in {7, 14}:
            raise InputError(f"a line of its neutral map has {len(row)} words, not 7 or 14")
        here = _range(row[1:7], n)
        if len(row) == 14 and row[0].upper() == "ONE_TO_ONE":
            shared.append((here, _range(row[7:13], n), row[13].upper() == "TRUE"))
        elif row[0].upper() != "UNPROCESSED":
            named.append((row[0], here))
    return shared, named, [parts[block] for block in range(1, n + 1)] if len(parts) == n else []


def _range(words: list[str], n_blocks: int) -> Range:
    block, side, a, b, c, d = (int(word) - 1 for word in words)
    if not (0 <= block < n_blocks and 0 <= side < 6 and min(a, b, c, d) >= 0):
        raise InputError("a patch names a block or a side that is not there")
    return Range(block=block, side=side, begin=(a, c), end=(b, d))
