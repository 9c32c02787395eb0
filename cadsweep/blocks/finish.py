"""From a joined mesh to one with names: parts, boundaries, interfaces, and the CAD figures of every solid.

Place in the flow: ``pipeline`` calls it on a :class:`~cadsweep.blocks.joined.JoinedMesh` before the checks. A face
with one cell is a boundary, one between two solids of the model an interface, one between two cells of one solid a
cut, which is neither.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Part, Units
from ..io.sides import find_sides
from ..mesh import HexMesh
from ..quality import fit_surfaces
from .block_mesh import BlockMesh, Faces
from .cells import CellBlocks, SweptCell
from .former_faces import describe_shares, own_quads
from .joined import JoinedMesh
from .naming import NamedFaces, Place, unite_quads
from .slabs import ArrayBlock, Block

_ROLES = ("source", "target", "side")
"""What the faces of a sweep are, in the order in which its boundaries are listed."""


def to_hex_mesh(part: Part, mesh: JoinedMesh, names: NamedFaces, info: dict[str, Any]) -> HexMesh:
    """Give a joined mesh its names; points in model units."""
    owners = np.array(part.owners, dtype=np.int64)[mesh.hex_cells]
    faces = _listed(mesh, by_face(mesh))
    outside, notes = _outside(part, names, [(place, mesh.points[quads], quads) for place, quads in faces])
    parts = {model.name: np.flatnonzero(owners == j) for j, model in enumerate(part.models)}
    return HexMesh(
        points=part.to_model(mesh.points),
        hexes=mesh.hexes,
        boundaries=unite_quads(outside),
        interfaces=unite_quads((names.between[place], quads) for place, quads in faces if names.first.get(place)),
        parts={name: ids for name, ids in parts.items() if len(ids)},
        structure=mesh.structure,
        info=info | {"notes": [*info.get("notes", []), *notes]} if notes else info,
    )


def _listed(mesh: JoinedMesh | CellBlocks, faces: list[tuple[Place, IntArray]]) -> list[tuple[Place, IntArray]]:
    """The faces in the order in which their boundaries are listed: of one sweep the caps first."""
    return faces if mesh.structure is None else sorted(faces, key=lambda own: _ROLES.index(mesh.roles[own[0]]))


def _outside(
    part: Part, names: NamedFaces, faces: Iterable[tuple[Place, FloatArray, IntArray]]
) -> tuple[list[tuple[tuple[str, ...], IntArray]], list[str]]:
    """Names and rows of the faces outside, and of the patches of those that were merged; and what is to be said.

    `faces`: each with the corners (q, 4, 3) of its quads, working units, and rows (q, ...) that stand for these.
    """
    found, notes = list[tuple[tuple[str, ...], IntArray]](), list[str]()
    for place, corners, rows in faces:
        if place not in names.outside:
            continue
        face = part.solids[place[0]].faces[place[1]]
        if not face.former:
            found.append((names.outside[place], rows))
            continue
        owners = own_quads(corners, face)
        called = [names.outside[place], *(names.patches[*place, j] for j in range(len(face.former)))]
        found += [(called[j], rows[owners == j]) for j in np.unique(owners).tolist()]
        notes += describe_shares(corners, owners, face, [known[0] for known in called])
    return found, notes


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
    rows = np.column_stack([mesh.quads, mesh.numbers[mesh.quads], np.concatenate(beside)])
    by_place = _listed(mesh, by_face(replace(mesh, quads=rows)))
    outside, notes = _outside(part, names, [(place, mesh.points[own[:, :4]], own[:, 4:]) for place, own in by_place])
    shared = [(names.between[place], own[:, 4:]) for place, own in by_place if names.first.get(place)]

    def faces(called: list[tuple[tuple[str, ...], IntArray]]) -> dict[str, Faces]:
        return {name: Faces(own[:, :4], own[:, 4]) for name, own in unite_quads(called).items()}

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
        boundaries=faces(outside),
        interfaces=faces(shared),
        problems=tuple(problems),
        info=info | {"notes": [*info.get("notes", []), *notes]} if notes else info,
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
