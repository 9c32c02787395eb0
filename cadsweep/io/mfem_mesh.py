"""MFEM mesh, ``.mesh``, version 1.3: attributes with names.

Place in the flow: a format module of :mod:`cadsweep.io`. MFEM gives every element and boundary element one attribute.
The attributes are the disjoint blocks of the groups; every name is an attribute set over them
(``mesh.bdr_attribute_sets["inlet"]``), so that overlapping groups are kept.

Order 1 has ``vertices``; hex27 has ``nodes`` in the space ``L2_T1_3D_P2`` (every element its own 27 nodes, x fastest),
as MFEM itself keeps curved meshes that are read from elsewhere, order p in ``L2_T4_3D_Pp`` (equispaced nodes). hex20 is
no element of MFEM.

Boundary quads that no name covers are written with an attribute of their own, ``unnamed``: MFEM wants the whole
boundary.

References
----------
MFEM, "Mesh formats", mfem.org/mesh-formats: MFEM mesh v1.0 and v1.3; geometry 5 is CUBE, 3 SQUARE, with VTK's corners.
"""

from __future__ import annotations

import re
from typing import BinaryIO

import numpy as np

from ..arrays import IntArray
from ..errors import InputError
from ..lattice import MOST, lexicographic, number_lattice, order_of
from ..mesh import HexMesh
from .labels import Blocks, LabelledMesh, check_nodes
from .sides import unnamed_sides
from .text import parse_numbers, write_rows

MOST_ORDER = MOST


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    size = mesh.hexes.shape[1]
    if size == 20:
        raise InputError("MFEM has no hex20; make the mesh with order=2, nodes=27")
    corners, blocks = _whole_boundary(mesh)
    hexes = mesh.hexes[:, :8]
    used, hexes, corners = _corner_numbers(hexes, corners, len(mesh.points))
    stream.write(b"MFEM mesh v1.3\n\ndimension\n3\n\nelements\n%d\n" % len(hexes))
    write_rows(stream, "%d 5" + " %d" * 8 + "\n", mesh.volumes.of_cell + 1, hexes)
    _write_sets(stream, "attribute_sets", mesh.volumes)
    stream.write(b"\nboundary\n%d\n" % len(corners))
    write_rows(stream, "%d 3" + " %d" * 4 + "\n", blocks.of_cell + 1, corners)
    _write_sets(stream, "bdr_attribute_sets", blocks)
    stream.write(b"\nvertices\n%d\n" % len(used))
    if size == 8:
        stream.write(b"3\n")
        write_rows(stream, "%r %r %r\n", mesh.points)
    else:
        order = order_of(size)
        space = _space(order).encode()
        stream.write(b"\nnodes\nFiniteElementSpace\nFiniteElementCollection: %s\nVDim: 3\nOrdering: 1\n\n" % space)
        write_rows(stream, "%r %r %r\n", mesh.points[mesh.hexes[:, lexicographic(order)].reshape(-1)])
    stream.write(b"\nmfem_mesh_end\n")


def _corner_numbers(hexes: IntArray, quads: IntArray, n: int) -> tuple[IntArray, IntArray, IntArray]:
    """Number the corners alone, in the order of the nodes."""
    is_corner = np.zeros(n, dtype=bool)
    is_corner[hexes] = True
    used = np.flatnonzero(is_corner)
    if len(used) == n or not is_corner[: len(used)].all():
        number = np.cumsum(is_corner) - 1
        return used, number[hexes], number[quads]
    return used, hexes, quads


def _whole_boundary(mesh: LabelledMesh) -> tuple[IntArray, Blocks]:
    """Named quads, then the quads of the boundary without a name."""
    unnamed = unnamed_sides(mesh.hexes, mesh.quads, len(mesh.points))
    if len(unnamed) == 0:
        return mesh.quads[:, :4], mesh.faces
    members = (*mesh.faces.members, ())
    of_cell = np.concatenate([mesh.faces.of_cell, np.full(len(unnamed), len(members) - 1)])
    return np.concatenate([mesh.quads[:, :4], unnamed]), Blocks(
        names=mesh.faces.names, members=members, of_cell=of_cell
    )


def _write_sets(stream: BinaryIO, keyword: str, blocks: Blocks) -> None:
    lines = []
    for name in blocks.names:
        tags = [j for j, names in enumerate(blocks.members, 1) if name in names]
        lines.append(f'"{name}" {len(tags)} {" ".join(map(str, tags))}'.rstrip())
    stream.write("\n".join(["", keyword, str(len(lines)), *lines, ""]).encode())


def read(stream: BinaryIO) -> HexMesh:
    """Read a mesh of hexes of order 1, or of order 2 as :func:`write` makes it."""
    text = stream.read().decode("utf-8", "replace")
    if not re.match(r"MFEM mesh v1\.[0-9]", text):
        raise InputError("it does not begin with 'MFEM mesh v1.'")
    if "#" in text:
        text = re.sub(r"^\s*#.*$", "", text, flags=re.MULTILINE)
    elements = _cells(text, "elements", geometry=5, width=8)
    boundary = _cells(text, "boundary", geometry=3, width=4)
    hexes, quads = elements[:, 2:], boundary[:, 2:]
    head = _head(text, "vertices")
    if head is None:
        raise InputError("it has no vertices, or is cut short")
    place = max(text.find("\nnodes"), 0)
    nodes = re.compile(
        r"\nnodes\s+FiniteElementSpace\s+FiniteElementCollection: (\S+)\s+VDim: 3\s+Ordering: 1\s+"
    ).match(text, place)
    if nodes is None:
        if place:
            raise InputError("it has curved elements in a space that is not read (L2_T1_3D_P2 is)")
        values = _floats(text, head.end())
        n = int(head[1])
        if len(values) < 1 + 3 * n or values[0] != 3:
            raise InputError("it has fewer vertices than it says, or not in three dimensions")
        points = values[1 : 1 + 3 * n].reshape(n, 3)
    else:
        points, hexes, quads = _curved(nodes[1], _floats(text, nodes.end()), hexes, quads)
    check_nodes(hexes, len(points))
    boundaries = {
        name: quads[np.isin(boundary[:, 0], tags)]
        for name, tags in _sets(text, "bdr_attribute_sets", boundary[:, 0], "boundary").items()
    }
    parts = {
        name: np.flatnonzero(np.isin(elements[:, 0], tags))
        for name, tags in _sets(text, "attribute_sets", elements[:, 0], "part").items()
    }
    return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts=parts)


def aligned(mesh: LabelledMesh, back: HexMesh) -> HexMesh:
    """Number the nodes of a mesh that was read as those of the mesh that was written.

    Curved elements bring their own nodes along, without the mesh's numbers.
    """
    if back.hexes.shape[1] == 8 or back.hexes.shape != mesh.hexes.shape or len(back.points) != len(mesh.points):
        return back
    number = np.empty(len(back.points), dtype=np.int64)
    number[back.hexes] = mesh.hexes
    points = np.empty_like(mesh.points)
    points[number] = back.points
    boundaries = {name: number[quads] for name, quads in back.boundaries.items()}
    return HexMesh(points=points, hexes=number[back.hexes], boundaries=boundaries, parts=back.parts)


def _cells(text: str, keyword: str, *, geometry: int, width: int) -> IntArray:
    head = _head(text, keyword)
    if head is None:
        raise InputError(f"it has no section {keyword!r}, or is cut short")
    n = int(head[1])
    end = text.find("\n\n", head.end())
    lines = text[head.end() : end if end >= 0 else len(text)].rstrip()
    if n == 0 and keyword != "elements":
        return np.empty((0, 2 + width), dtype=np.int64)
    kinds = set(re.findall(r"^\s*\d+\s+(\d+)", lines, re.MULTILINE))
    if kinds != {str(geometry)}:
        raise InputError(
            f"its {keyword} are of the geometries {sorted(kinds)}; only hexahedra (5) and quads (3) are read"
        )
    rows = parse_numbers(lines.encode(), np.int64)
    if len(rows) != n * (2 + width) or lines.count("\n") != n - 1:
        raise InputError(f"its section {keyword!r} is cut short")
    return rows.reshape(n, 2 + width)


def _head(text: str, keyword: str) -> re.Match[str] | None:
    """The line of a keyword, and the count after it; looked for by its letters, which is faster than by a pattern."""
    place = text.find(f"\n{keyword}")
    while place >= 0:
        found = re.compile(rf"{keyword}\s+(\d+)[ \t]*\n").match(text, place + 1)
        if found is not None:
            return found
        place = text.find(f"\n{keyword}", place + 1)
    return None


def _floats(text: str, start: int) -> np.ndarray:
    body = text[start:].partition("mfem_mesh_end")[0]
    return parse_numbers(body.encode())


def _space(order: int) -> str:
    """Discontinuous elements whose nodes are equispaced: type 1 to order 2 as MFEM writes itself, type 4 above."""
    return f"L2_T{1 if order == 2 else 4}_3D_P{order}"


def _curved(space: str, values: np.ndarray, hexes: IntArray, quads: IntArray) -> tuple[np.ndarray, IntArray, IntArray]:
    order = next((p for p in range(2, MOST + 1) if _space(p) == space), 0)
    if not order or len(values) != len(hexes) * (order + 1) ** 3 * 3:
        raise InputError(f"it has curved elements in the space {space}, or is cut short; {_space(2)} is read")
    # A node of several elements stands once for each. Corners are known by number, the others by their corners.
    lattice = number_lattice(hexes, int(np.max(hexes)) + 1, order)
    points = np.empty((lattice.n_nodes, 3))
    points[lattice.hexes[:, lexicographic(order)].reshape(-1)] = values.reshape(-1, 3)
    return points, lattice.hexes, lattice.quads(quads)


def _sets(text: str, keyword: str, tags: IntArray, stem: str) -> dict[str, list[int]]:
    head = _head(text, keyword)
    if head is None:
        return {f"{stem}_{tag}": [tag] for tag in np.unique(tags).tolist()}
    rows = re.compile(r'\s*"([^"]*)"\s+(\d+)')
    found: dict[str, list[int]] = {}
    place = head.end()
    for _ in range(int(head[1])):
        row = rows.match(text, place)
        values = re.compile(r"\s+(\d+)" * int(row[2])).match(text, row.end()) if row and int(row[2]) < 100_000 else None
        if row is None or values is None:
            raise InputError(f"its section {keyword!r} is cut short")
        found[row[1]] = [int(word) for word in values.groups()]
        place = values.end()
    return found
