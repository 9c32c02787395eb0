"""Gmsh's MSH 4.1, ``.msh``.

Place in the flow: a format module of :mod:`cadsweep.io`. Written with numpy alone, because gmsh's own writer takes
several seconds for a million hexes and says nothing of a full disk. Binary by default; ASCII on request.

Every boundary is a physical group of dimension 2, every part one of dimension 3. A cell in several groups belongs to
an elementary entity that carries several physical tags, so nothing is lost. Hex h has the element tag h + 1, node i
the tag i + 1, boundary quads follow the hexes.

Surfaces whose nodes answer each other are linked in ``$Periodic``.

References
----------
Gmsh reference manual, "MSH file format" (version 4.1) and "Node ordering".
"""

from __future__ import annotations

from typing import BinaryIO

import numpy as np

from ..arrays import IntArray
from .labels import LabelledMesh
from .msh_common import HEX_TYPES, QUAD_TYPES, hex_order, in_gmsh_order, physical_names, quad_order
from .periodic_faces import rigid_motion
from .vtk_cells import write_bytes

_CHUNK = 1 << 15


def write(stream: BinaryIO, mesh: LabelledMesh, *, binary: bool = True) -> None:
    """Write a labelled mesh."""
    put = _BinaryOutput(stream) if binary else _TextOutput(stream)
    stream.write(b"$MeshFormat\n4.1 %d 8\n" % binary)
    if binary:
        stream.write(np.int32(1).tobytes() + b"\n")
    stream.write(b"$EndMeshFormat\n")
    stream.write(physical_names(mesh.faces.names, mesh.volumes.names))
    stream.write(b"$Entities\n")
    _write_entities(put, mesh)
    stream.write(b"$EndEntities\n$Nodes\n")
    n, m, q = len(mesh.points), len(mesh.hexes), len(mesh.quads)
    put.sizes(1, n, 1, n)
    put.end()
    put.integers(3, 1, 0)
    put.sizes(n)
    put.end()
    put.column(np.arange(1, n + 1, dtype=np.uint64))
    put.table(mesh.points)
    stream.write(b"$EndNodes\n$Elements\n")
    put.sizes(len(mesh.volumes.members) + len(mesh.faces.members), m + q, 1, m + q)
    put.end()
    quads = in_gmsh_order(mesh.quads, quad_order(mesh.quads.shape[1]))
    for block in range(len(mesh.faces.members)):
        ids = mesh.faces.cells(block)
        put.integers(2, block + 1, QUAD_TYPES[mesh.quads.shape[1]])
        put.sizes(len(ids))
        put.end()
        put.cells(ids, quads, first_tag=m + 1)
    hexes = in_gmsh_order(mesh.hexes, hex_order(mesh.hexes.shape[1]))
    for block in range(len(mesh.volumes.members)):
        ids = mesh.volumes.cells(block)
        put.integers(3, block + 1, HEX_TYPES[mesh.hexes.shape[1]])
        put.sizes(len(ids))
        put.end()
        put.cells(ids, hexes, first_tag=1)
    stream.write(b"$EndElements\n")
    _write_periodic(stream, put, mesh)


def _write_periodic(stream: BinaryIO, put: _BinaryOutput | _TextOutput, mesh: LabelledMesh) -> None:
    """Links between surfaces whose nodes answer each other; only of boundaries that are one surface each."""
    blocks = {name: [b for b, own in enumerate(mesh.faces.members) if name in own] for name in mesh.faces.names}
    links = [
        (blocks[one][0], blocks[other][0], pairs)
        for (one, other), pairs in mesh.periodic.items()
        if len(blocks[one]) == len(blocks[other]) == 1
    ]
    if not links:
        return
    stream.write(b"$Periodic\n")
    put.sizes(len(links))
    put.end()
    for master, slave, pairs in links:
        put.integers(2, slave + 1, master + 1)
        put.end()
        matrix, shift = rigid_motion(mesh.points[pairs[:, 0]], mesh.points[pairs[:, 1]])
        put.sizes(16)
        put.reals(*np.vstack([np.column_stack([matrix, shift]), [0.0, 0.0, 0.0, 1.0]]).ravel())
        put.end()
        put.sizes(len(pairs))
        put.end()
        for first, image in (pairs + 1).tolist():
            put.sizes(image, first)
            put.end()
    stream.write(b"$EndPeriodic\n")


def _write_entities(put: _BinaryOutput | _TextOutput, mesh: LabelledMesh) -> None:
    low, high = mesh.bounds
    n_surfaces = len(mesh.faces.members)
    put.sizes(0, 0, n_surfaces, len(mesh.volumes.members))
    put.end()
    for block in range(n_surfaces):
        put.integers(block + 1)
        put.reals(*mesh.block_bounds[block][0], *mesh.block_bounds[block][1])
        tags = [mesh.faces.names.index(name) + 1 for name in mesh.faces.members[block]]
        put.sizes(len(tags))
        put.integers(*tags)
        put.sizes(0)
        put.end()
    for block, names in enumerate(mesh.volumes.members):
        put.integers(block + 1)
        put.reals(*low, *high)
        # Tags of volumes follow those of surfaces: some readers forget the dimension.
        tags = [len(mesh.faces.names) + mesh.volumes.names.index(name) + 1 for name in names]
        put.sizes(len(tags))
        put.integers(*tags)
        put.sizes(0)
        put.end()


class _BinaryOutput:
    """Writes the values of a section as the machine's own bytes."""

    def __init__(self, stream: BinaryIO) -> None:
        self.stream = stream

    def sizes(self, *values: int) -> None:
        self.stream.write(np.array(values, dtype=np.uint64).tobytes())

    def integers(self, *values: int) -> None:
        self.stream.write(np.array(values, dtype=np.int32).tobytes())

    def reals(self, *values: float) -> None:
        self.stream.write(np.array(values, dtype=np.float64).tobytes())

    def end(self) -> None:
        """Binary records have no end mark."""

    def column(self, values: np.ndarray) -> None:
        write_bytes(self.stream, values)

    def table(self, values: np.ndarray) -> None:
        write_bytes(self.stream, values)

    def cells(self, ids: IntArray, nodes: IntArray, *, first_tag: int) -> None:
        rows = np.empty((_CHUNK, 1 + nodes.shape[1]), dtype=np.int64)
        for start in range(0, len(ids), _CHUNK):
            chunk = ids[start : start + _CHUNK]
            part = rows[: len(chunk)]
            np.add(chunk, first_tag, out=part[:, 0])
            run = chunk[-1] - chunk[0] == len(chunk) - 1  # consecutive ids need no gathering
            np.add(nodes[chunk[0] : chunk[-1] + 1] if run else nodes[chunk], 1, out=part[:, 1:])
            write_bytes(self.stream, part)


class _TextOutput:
    """Writes the same values as text, one record a line."""

    def __init__(self, stream: BinaryIO) -> None:
        self.stream = stream
        self.line: list[str] = []

    def sizes(self, *values: int) -> None:
        self.line += [str(int(value)) for value in values]

    def integers(self, *values: int) -> None:
        self.line += [str(int(value)) for value in values]

    def reals(self, *values: float) -> None:
        self.line += [repr(float(value)) for value in values]

    def end(self) -> None:
        self.stream.write((" ".join(self.line) + "\n").encode())
        self.line = []

    def column(self, values: np.ndarray) -> None:
        self.stream.write(("\n".join(map(str, values.tolist())) + "\n").encode())

    def table(self, values: np.ndarray) -> None:
        for start in range(0, len(values), _CHUNK):
            rows = values[start : start + _CHUNK].tolist()
            self.stream.write("".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in rows).encode())

    def cells(self, ids: IntArray, nodes: IntArray, *, first_tag: int) -> None:
        for start in range(0, len(ids), _CHUNK):
            chunk = ids[start : start + _CHUNK]
            rows = np.column_stack([chunk + first_tag, nodes[chunk] + 1]).tolist()
            self.stream.write("".join(" ".join(map(str, row)) + "\n" for row in rows).encode())
