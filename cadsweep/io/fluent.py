"""Fluent mesh, ``.msh`` with ``version="fluent"``: text, faces with the cells on their sides, a zone a boundary.

Place in the flow: a format module of :mod:`cadsweep.io`, reached through :mod:`cadsweep.io.msh`. It is written, and not
read: OpenFOAM's ``fluent3DMeshToFoam`` reads it back in the tests.

Cells are numbered part by part. A face has one zone here: disjoint blocks of boundaries, by the names of
:meth:`~cadsweep.io.labels.Blocks.exclusive_names`; interfaces are zones of inner faces. Boundaries by name of wall are
walls, others pressure outlets that the solver's user changes.

Order 1 only.

References
----------
ANSYS Fluent user's guide, "Mesh file format": sections 10 (nodes), 12 (cells), 13 (faces: nodes, then the cell that the
right hand's thumb points to, then the other one), 45 (zones); all numbers but of section 45 are hexadecimal.
"""

from __future__ import annotations

from typing import BinaryIO

import numpy as np

from ..errors import InputError
from .foam import DEFAULT_PATCH, ZONES, ordered_faces, patch_type, with_whole_boundary
from .labels import LabelledMesh
from .sides import corner_keys
from .text import write_rows

_INTERIOR, _WALL, _PRESSURE_OUTLET = 2, 3, 5
_QUAD, _HEX = 4, 4


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    if mesh.hexes.shape[1] != 8:
        raise InputError("Fluent's cells are of order 1; make the mesh with order=1")
    mesh = with_whole_boundary(mesh)
    faces, owner, neighbour, patches = ordered_faces(mesh)
    n, n_inner = len(mesh.points), len(neighbour)
    names = mesh.volumes.exclusive_names()
    blocks = [mesh.volumes.cells(block) for block in range(len(names))]
    number = np.empty(len(mesh.hexes), dtype=np.int64)
    number[np.concatenate(blocks)] = np.arange(1, len(mesh.hexes) + 1)

    stream.write(b'(0 "cadsweep")\n(2 3)\n')
    stream.write(b"(10 (0 1 %x 0 3))\n(10 (1 1 %x 1 3)(\n" % (n, n))
    write_rows(stream, "%r %r %r\n", mesh.points)
    stream.write(b"))\n(12 (0 1 %x 0))\n" % len(mesh.hexes))
    zones: list[tuple[int, str, str]] = []
    first = 1
    for name, ids in zip(names, blocks, strict=True):
        zones.append((len(zones) + 2, "fluid", name))
        stream.write(b"(12 (%x %x %x 1 %x))\n" % (zones[-1][0], first, first + len(ids) - 1, _HEX))
        first += len(ids)
    stream.write(b"(13 (0 1 %x 0))\n" % len(faces))

    first = 1
    for zone, (kind, name, rows) in enumerate(_face_zones(mesh, faces, n_inner, patches), len(zones) + 2):
        zones.append((zone, {_INTERIOR: "interior", _WALL: "wall"}.get(kind, "pressure-outlet"), name))
        stream.write(b"(13 (%x %x %x %x %x)(\n" % (zone, first, first + len(rows) - 1, kind, _QUAD))
        inner = rows < n_inner
        other = np.zeros(len(rows), dtype=np.int64)
        other[inner] = number[neighbour[rows[inner]]]
        # Our quads turn about the way out of their owner: turned round, the thumb points to the owner.
        write_rows(stream, "%x %x %x %x %x %x\n", faces[rows][:, ::-1] + 1, number[owner[rows]], other)
        stream.write(b"))\n")
        first += len(rows)
    for zone, word, name in zones:
        stream.write(f"(45 ({zone} {word} {name})())\n".encode())


def _face_zones(
    mesh: LabelledMesh, faces: np.ndarray, n_inner: int, patches: list[tuple[str, tuple[str, ...], int, int]]
) -> list[tuple[int, str, np.ndarray]]:
    """Kind, name and faces of every zone: inner faces, interfaces, boundaries."""
    zone_of = np.zeros(n_inner, dtype=np.int64)
    named = []
    for name, quads in mesh.info.get(ZONES, {}).items():
        _, codes = corner_keys(np.concatenate([faces[:n_inner], quads[:, :4]]))
        free = np.flatnonzero(np.isin(codes[:n_inner], codes[n_inner:]) & (zone_of == 0))
        if len(free):
            named.append((_INTERIOR, name, free))
            zone_of[free] = len(named)
    rest = np.flatnonzero(zone_of == 0)
    found = [(_INTERIOR, "interior", rest)] if len(rest) else []
    found += named
    for name, groups, start, count in patches:
        wall = name.startswith(DEFAULT_PATCH) or patch_type((name, *groups), {}) == "wall"
        found.append((_WALL if wall else _PRESSURE_OUTLET, name, np.arange(start, start + count)))
    return found
