"""SU2 mesh, ``.su2``: text, hexahedra and markers of quads.

Place in the flow: a format module of :mod:`cadsweep.io`.

A quad has one marker here. Where boundaries overlap, the disjoint blocks are written under the names of
:meth:`~cadsweep.io.labels.Blocks.exclusive_names`. The format knows one zone a file: parts are not kept. Interfaces
would be markers inside the flow, which SU2 refuses: they are left out.

Order 1 only.

References
----------
SU2 documentation, "Mesh file"; element types are those of VTK: 12 a hexahedron, 9 a quad.
"""

from __future__ import annotations

import re
from typing import Any, BinaryIO

import numpy as np

from ..arrays import IntArray
from ..errors import InputError
from ..mesh import HexMesh
from .compare import Groups, disjoint_boundaries
from .labels import DEFAULT_PART, LabelledMesh, check_nodes, without_quads
from .sides import count_users
from .text import parse_numbers, write_rows

MOST_ORDER = 1

_HEX, _QUAD = 12, 9


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    n, m = len(mesh.points), len(mesh.hexes)
    stream.write(b"NDIME= 3\nNELEM= %d\n" % m)
    write_rows(stream, f"{_HEX}" + " %d" * 9 + "\n", mesh.hexes, np.arange(m))
    stream.write(b"NPOIN= %d\n" % n)
    write_rows(stream, "%r %r %r %d\n", mesh.points, np.arange(n))
    markers = _markers(mesh)
    stream.write(b"NMARK= %d\n" % len(markers))
    for name, quads in markers.items():
        stream.write(f"MARKER_TAG= {name}\nMARKER_ELEMS= {len(quads)}\n".encode())
        write_rows(stream, f"{_QUAD} %d %d %d %d\n", quads)


def _markers(mesh: LabelledMesh) -> dict[str, IntArray]:
    """Disjoint boundaries, what is inside the mesh left out."""
    inside = count_users(mesh.hexes, mesh.quads, len(mesh.points)) > 1
    return disjoint_boundaries(without_quads(mesh, inside))


def kept_groups(mesh: LabelledMesh) -> Groups:
    """Disjoint boundaries; the hexahedra are one part."""
    return _markers(mesh), {DEFAULT_PART: np.arange(len(mesh.hexes))}


def read(stream: BinaryIO) -> HexMesh:
    """Read hexahedra and markers."""
    text = stream.read().decode("ascii", "replace")
    text = re.sub(r"%.*", "", text) if "%" in text else text
    if _number(text, "NDIME") != 3:
        raise InputError("it is not of three dimensions")
    hexes = _rows(text, "NELEM", _number(text, "NELEM"), _HEX, 8)
    points = _table(text, "NPOIN", _number(text, "NPOIN"), 3)
    boundaries = {}
    for match in re.finditer(r"MARKER_TAG\s*=\s*(\S+)\s*MARKER_ELEMS\s*=\s*(\d+)", text):
        boundaries[match[1]] = _rows(text[match.start() :], "MARKER_ELEMS", int(match[2]), _QUAD, 4)
    if len(boundaries) != _number(text, "NMARK"):
        raise InputError("a marker is missing: it is cut short")
    for cells in (hexes, *boundaries.values()):
        check_nodes(cells, len(points))
    return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts={DEFAULT_PART: np.arange(len(hexes))})


def _number(text: str, keyword: str) -> int:
    match = re.search(rf"{keyword}\s*=\s*(\d+)", text)
    if match is None:
        raise InputError(f"it has no {keyword}")
    return int(match[1])


def _lines(text: str, keyword: str, n: int) -> bytes:
    """The n lines after a keyword."""
    match = re.search(rf"{keyword}\s*=[^\n]*\n", text)
    assert match is not None
    end = text.find("=", match.end())
    lines = text[match.end() : end if end >= 0 else len(text)].split("\n", n)
    if len(lines) < n or (len(lines) == n and end >= 0):
        raise InputError(f"it has fewer lines after {keyword} than it says: it is cut short")
    return "\n".join(lines[:n]).encode()


def _table(text: str, keyword: str, n: int, width: int, dtype: Any = np.float64) -> np.ndarray:
    """Numbers (n, width) of lines, of which each may end with one more."""
    lines = _lines(text, keyword, n)
    values = parse_numbers(lines, dtype)
    if n == 0 or len(values) % n or len(values) // n - width not in {0, 1}:
        raise InputError(f"lines after {keyword} have not as many numbers as they should: it is cut short")
    return values.reshape(n, -1)[:, :width]


def _rows(text: str, keyword: str, n: int, kind: int, size: int) -> IntArray:
    first = {line.split(None, 1)[0] for line in _lines(text, keyword, n).split(b"\n") if line.strip()}
    if first != {b"%d" % kind}:
        raise InputError(f"it has elements after {keyword} that are not of type {kind}; meshes of hexahedra are read")
    return _table(text, keyword, n, 1 + size, np.int64)[:, 1:]
