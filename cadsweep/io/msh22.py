"""Gmsh's MSH 2.2 as text, ``.msh`` with ``version="2.2"``: what OpenFOAM's ``gmshToFoam`` reads.

Place in the flow: a format module of :mod:`cadsweep.io`.

A cell has one physical group here. Where groups overlap, the disjoint blocks are written under the names of
:meth:`~cadsweep.io.labels.Blocks.exclusive_names`.

References
----------
Gmsh reference manual, "MSH file format version 2 (Legacy)" and "Node ordering".
"""

from __future__ import annotations

from typing import BinaryIO

import numpy as np

from .labels import LabelledMesh
from .msh_common import HEX_TYPES, QUAD_TYPES, hex_order, in_gmsh_order, physical_names, quad_order
from .text import write_rows


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    faces, volumes = mesh.faces.exclusive_names(), mesh.volumes.exclusive_names()
    n, m, q = len(mesh.points), len(mesh.hexes), len(mesh.quads)
    stream.write(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
    stream.write(physical_names(faces, volumes))
    stream.write(b"$Nodes\n%d\n" % n)
    write_rows(stream, "%d %r %r %r\n", np.arange(1, n + 1), mesh.points)
    stream.write(b"$EndNodes\n$Elements\n%d\n" % (m + q))
    tag = mesh.faces.of_cell + 1
    kind = QUAD_TYPES[mesh.quads.shape[1]]
    row = f"%d {kind} 2 %d %d" + " %d" * mesh.quads.shape[1] + "\n"
    write_rows(
        stream,
        row,
        np.arange(m + 1, m + q + 1),
        tag,
        tag,
        in_gmsh_order(mesh.quads, quad_order(mesh.quads.shape[1])) + 1,
    )
    tag = mesh.volumes.of_cell + 1 + len(faces)
    size = mesh.hexes.shape[1]
    row = f"%d {HEX_TYPES[size]} 2 %d %d" + " %d" * size + "\n"
    write_rows(stream, row, np.arange(1, m + 1), tag, tag, in_gmsh_order(mesh.hexes, hex_order(size)) + 1)
    stream.write(b"$EndElements\n")
