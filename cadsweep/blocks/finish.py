"""From a joined mesh to one with names: parts, boundaries, interfaces, and the CAD figures of every solid.

Place in the flow: ``pipeline`` calls it on a :class:`~cadsweep.blocks.joined.JoinedMesh` before the checks. A face
with one cell is a boundary, one between two solids of the model an interface, one between two cells of one solid a
cut, which is neither.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import IntArray
from ..brep import Part, Units
from ..io.sides import find_sides
from ..mesh import HexMesh
from ..quality import fit_surfaces
from .block_mesh import BlockMesh, Faces
from .cells import CellBlocks, SweptCell
from .former_faces import own_quads
from .joined import JoinedMesh
from .naming import NamedFaces, Place, unite_quads
from .slabs import ArrayBlock, Block

_ROLES = ("source", "target", "side")
"""What the faces of a sweep are, in the order in which its boundaries are listed."""


def to_hex_mesh(part: Part, mesh: JoinedMesh, names: NamedFaces, info: dict[str, Any]) -> HexMesh:
    """Give a joined mesh its names; points in model units."""
    owners = np.array(part.owners, dtype=np.int64)[mesh.hex_cells]
    faces = by_face(mesh)
    if mesh.structure is not None:  # the caps first, as its user thinks of a sweep
        faces.sort(key=lambda own: _ROLES.index(mesh.roles[own[0]]))
    outside = [
        own for place, quads in faces if place in names.outside for own in _by_patch(part, mesh, names, place, quads)
    ]
    parts = {model.name: np.flatnonzero(owners == j) for j, model in enumerate(part.models)}
    return HexMesh(
        points=part.to_model(mesh.points),
        hexes=mesh.hexes,
        boundaries=unite_quads(outside),
        interfaces=unite_quads((names.between[place], quads) for place, quads in faces if names.first.get(place)),
        parts={name: ids for name, ids in parts.items() if len(ids)},
        structure=mesh.structure,
        info=info,
    )


def _by_patch(
    part: Part, mesh: JoinedMesh, names: NamedFaces, place: Place, quads: IntArray
) -> list[tuple[tuple[str, ...], IntArray]]:
    """Names and quads of a face, and of the patches of one that was merged."""
    faces = part.solids[place[0]].faces
    n_patches = len(faces[place[1]].former)
    if not n_patches:
        return [(names.outside[place], quads)]
    owners, _ = own_quads(
        np.full(len(quads), place[1]),
        lambda at: mesh.points[quads[at]],
        faces,
        np.zeros(len(faces), dtype=np.int64),
        {(place[1], j): j + 1 for j in range(n_patches)},
    )
    return [
        (names.outside[place] if j == 0 else names.patches[*place, j - 1], quads[owners == j])
        for j in np.unique(owners).tolist()
    ]


def to_block_mesh(part: Part, mesh: CellBlocks, names: NamedFaces, info: dict[str, Any]) -> BlockMesh:
    """The mesh of :func:`to_hex_mesh`, its cells left in blocks."""
    units = Units(part.scale, part.offset)
    points = units.to_model(mesh.points)
    starts = np.cumsum([0, *(own.n_hexes for own in mesh.cells)])
    blocks: list[Block] = []
    beside = []
    for number, own in enumerate(mesh.cells):
        first = int(starts[number])
        if isinstance(own, SweptCell):
            blocks.append(mesh.swept_block(number, units, first))
            beside.append(own.quad_hexes() + first)
        else:
            blocks.append(ArrayBlock(points=points, nodes=mesh.numbers, hexes=own.hexes, first_hex=first))
            quads = mesh.quads[mesh.quad_cells == own.cell]
            beside.append(find_sides(own.hexes, quads, len(points))[0] + first)
    owners = [part.owners[own.cell] for own in mesh.cells]
    present = [j for j in range(len(part.models)) if j in owners]
    of_quad = np.array(part.owners, dtype=np.int64)[mesh.quad_cells]
    surfaces, problems = [], list[str]()
    for owner in present:
        quads = mesh.quads[of_quad == owner]
        rows, unfit = fit_surfaces(quads)
        surfaces.append(mesh.numbers[quads[rows]])
        problems += [f"part '{part.models[owner].name}': {problem}" for problem in unfit]
    with_hexes = replace(mesh, quads=np.column_stack([mesh.numbers[mesh.quads], np.concatenate(beside)]))

    def faces(labels: dict[Place, tuple[str, ...]]) -> dict[str, Faces]:
        rows = unite_quads((labels[place], own) for place, own in by_face(with_hexes) if place in labels)
        return {name: Faces(own[:, :4], own[:, 4]) for name, own in rows.items()}

    order = np.argsort(mesh.numbers)
    kept = np.arange(0) if mesh.structure is not None else order  # its slabs have all nodes
    return BlockMesh(
        blocks=tuple(blocks),
        block_parts=tuple(present.index(owner) for owner in owners),
        parts=tuple(part.models[owner].name for owner in present),
        n_nodes=mesh.n_nodes,
        kept_nodes=mesh.numbers[kept],
        kept_points=points[kept],
        surface_nodes=mesh.numbers[order],
        surface_points=points[order],
        part_quads=tuple(surfaces),
        boundaries=faces(names.outside),
        interfaces=faces({place: given for place, given in names.between.items() if names.first[place]}),
        problems=tuple(problems),
        info=info,
    )


def by_face(mesh: JoinedMesh | CellBlocks) -> list[tuple[Place, IntArray]]:
    """Quads of every face of every cell, outward from the cell."""
    width = int(mesh.quad_faces.max(initial=0)) + 1
    keys = mesh.quad_cells * width + mesh.quad_faces
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    starts = np.flatnonzero(np.diff(ordered, prepend=-1))
    pieces = np.split(mesh.quads[order], starts)[1:]
    return [(divmod(key, width), quads) for key, quads in zip(ordered[starts].tolist(), pieces, strict=True)]
