"""A mesh as a list of blocks in one numbering, never in memory as a whole.

Place in the flow: made of one sweep, of cells, of arrays, or of several such meshes side by side; :mod:`.stream` checks
it and writes it slab by slab, :mod:`.pieces` gives every rank its share. Points, hexahedra, boundaries, parts and
interfaces are those of the mesh in memory, bit for bit.

What is in memory: the factors of the blocks, the nodes that blocks share, and the surfaces of the parts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from ..io.sides import find_sides
from ..mesh import HexMesh
from ..quality import part_surfaces
from ..quality.conformity import row_keys
from ..record import MeshRecord
from .naming import unite_quads
from .slabs import ArrayBlock, Block, SweptBlock


class Faces(NamedTuple):
    """Quads (q, 4), and the hexahedron (q,) that each of them points out of."""

    quads: IntArray
    hexes: IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class BlockMesh:
    """Blocks in one numbering of nodes and hexahedra.

    Attributes
    ----------
    blocks : tuple of Block
        In the order of their hexahedra.
    block_parts : tuple of int
        The part that each block is of.
    parts : tuple of str
    n_nodes : int
    kept_nodes, kept_points : (s,) int64, (s, 3) float64
        Nodes that are no block's own, ascending; model units.
    surface_nodes, surface_points : (t,) int64, (t, 3) float64
        All nodes on surfaces of parts, ascending; model units.
    part_quads : tuple of (q, 4) int64
        Surface of every part, outward.
    boundaries, interfaces : dict of str to Faces
    problems : tuple of str
        Where blocks of one part do not fit together.
    info : MeshRecord
    """

    blocks: tuple[Block, ...]
    block_parts: tuple[int, ...]
    parts: tuple[str, ...]
    n_nodes: int
    kept_nodes: IntArray
    kept_points: FloatArray
    surface_nodes: IntArray
    surface_points: FloatArray
    part_quads: tuple[IntArray, ...]
    boundaries: Mapping[str, Faces]
    interfaces: Mapping[str, Faces] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    info: Mapping[str, Any] = field(default_factory=MeshRecord)

    def __post_init__(self) -> None:
        object.__setattr__(self, "info", MeshRecord.of(self.info))

    @property
    def n_hexes(self) -> int:
        """Hexahedra of all blocks."""
        return sum(block.n_layers * block.per_layer for block in self.blocks)

    @property
    def sweep(self) -> SweptBlock | None:
        """The one sweep that the mesh is; None where it is more."""
        block = self.blocks[0]
        return block if isinstance(block, SweptBlock) and block.whole is not None and len(self.blocks) == 1 else None

    @property
    def faces(self) -> dict[str, Faces]:
        """Boundaries and interfaces, as files have them; a name may be of both."""
        both = self.boundaries.keys() & self.interfaces.keys()
        found = {**self.boundaries, **self.interfaces}
        for name in both:
            found[name] = Faces(*map(np.concatenate, zip(self.boundaries[name], found[name], strict=True)))
        return found

    def part_sizes(self) -> dict[str, int]:
        """Hexahedra of every part."""
        sizes = dict.fromkeys(self.parts, 0)
        for block, part in zip(self.blocks, self.block_parts, strict=True):
            sizes[self.parts[part]] += block.n_layers * block.per_layer
        return sizes

    def is_same(self, other: BlockMesh) -> bool:
        """Whether another mesh has the same blocks under the same names."""
        return self.blocks is other.blocks and self.boundaries is other.boundaries and self.parts == other.parts

    def part_of(self, number: int) -> str:
        """The part that a hexahedron is of."""
        block = int(np.searchsorted([block.first_hex for block in self.blocks], number, side="right")) - 1
        return self.parts[self.block_parts[block]]

    def rows(self, quads: IntArray) -> IntArray:
        """Places of nodes of surfaces in `surface_points`."""
        return np.searchsorted(self.surface_nodes, quads)

    def skin(self) -> HexMesh:
        """The surfaces as a mesh without hexahedra, nodes numbered by their places in `surface_points`."""
        return HexMesh(
            points=self.surface_points,
            hexes=np.empty((0, 8), dtype=np.int64),
            boundaries={name: self.rows(faces.quads) for name, faces in self.boundaries.items()},
            interfaces={name: self.rows(faces.quads) for name, faces in self.interfaces.items()},
            info=self.info,
        )

    def named(self, skin: HexMesh) -> BlockMesh:
        """The same mesh with the boundaries and notes of another :meth:`skin`, of the same quads."""
        known = list(self.boundaries.values())
        keys = row_keys(np.concatenate([own.quads for own in known]))
        hexes = np.concatenate([own.hexes for own in known])
        order = np.argsort(keys, kind="stable")

        def faces(quads: IntArray) -> Faces:
            numbered = self.surface_nodes[quads]
            return Faces(numbered, hexes[order[np.searchsorted(keys[order], row_keys(numbered))]])

        boundaries = {name: faces(quads) for name, quads in skin.boundaries.items()}
        return replace(self, boundaries=boundaries, info=skin.info)


def united(
    quads: Sequence[tuple[tuple[str, ...], IntArray]], hexes: Sequence[tuple[tuple[str, ...], IntArray]]
) -> dict[str, Faces]:
    """Faces of every name, from the quads, and the hexahedra at them, of owners."""
    beside = unite_quads(hexes)
    return {name: Faces(own, beside[name]) for name, own in unite_quads(quads).items()}


def mesh_of_arrays(mesh: HexMesh) -> BlockMesh:
    """A mesh of order 1 that is in memory, a block for every run of hexahedra of one part."""
    part = np.zeros(mesh.n_hexes, dtype=np.int64)
    for j, ids in enumerate(mesh.parts.values()):
        part[ids] = j
    starts = np.concatenate([[0], np.flatnonzero(np.diff(part)) + 1, [mesh.n_hexes]])
    nodes = np.arange(mesh.n_nodes, dtype=np.int64)
    surfaces = part_surfaces(mesh)
    on_surface = distinct(np.concatenate([own.quads for own in surfaces]))

    def faces(named: Mapping[str, IntArray]) -> dict[str, Faces]:
        return {name: Faces(quads, find_sides(mesh.hexes, quads, mesh.n_nodes)[0]) for name, quads in named.items()}

    return BlockMesh(
        blocks=tuple(
            ArrayBlock(points=mesh.points, nodes=nodes, hexes=mesh.hexes[a:b], first_hex=int(a))
            for a, b in pairwise(starts)
        ),
        block_parts=tuple(part[starts[:-1]].tolist()),
        parts=tuple(mesh.parts),
        n_nodes=mesh.n_nodes,
        kept_nodes=nodes,
        kept_points=mesh.points,
        surface_nodes=on_surface,
        surface_points=mesh.points[on_surface],
        part_quads=tuple(own.quads for own in surfaces),
        boundaries=faces(mesh.boundaries),
        interfaces=faces(mesh.interfaces),
        info=mesh.info,
    )


def blocks_side_by_side(meshes: Sequence[BlockMesh], info: Mapping[str, Any]) -> BlockMesh:
    """One mesh of several that share no node; boundaries of one name become one."""
    nodes = np.cumsum([0, *(mesh.n_nodes for mesh in meshes)]).tolist()
    hexes = np.cumsum([0, *(mesh.n_hexes for mesh in meshes)]).tolist()
    parts = tuple(dict.fromkeys(name for mesh in meshes for name in mesh.parts))
    quads: dict[str, list[IntArray]] = {name: [] for name in parts}
    kinds: dict[str, dict[str, list[Faces]]] = {"boundaries": {}, "interfaces": {}}
    for mesh, node, first in zip(meshes, nodes, hexes, strict=False):
        for name, own in zip(mesh.parts, mesh.part_quads, strict=True):
            quads[name].append(own + node)
        for kind, found in kinds.items():
            for name, faces in getattr(mesh, kind).items():
                found.setdefault(name, []).append(Faces(faces.quads + node, faces.hexes + first))
    placed = list(zip(meshes, nodes, hexes, strict=False))
    named = {
        kind: {name: Faces(*map(np.concatenate, zip(*pieces, strict=True))) for name, pieces in found.items()}
        for kind, found in kinds.items()
    }
    return BlockMesh(
        blocks=tuple(block.shifted(node, first) for mesh, node, first in placed for block in mesh.blocks),
        block_parts=tuple(parts.index(mesh.parts[part]) for mesh in meshes for part in mesh.block_parts),
        parts=parts,
        n_nodes=nodes[-1],
        kept_nodes=np.concatenate([mesh.kept_nodes + node for mesh, node, _ in placed]),
        kept_points=np.concatenate([mesh.kept_points for mesh in meshes]),
        surface_nodes=np.concatenate([mesh.surface_nodes + node for mesh, node, _ in placed]),
        surface_points=np.concatenate([mesh.surface_points for mesh in meshes]),
        part_quads=tuple(np.concatenate(own) for own in quads.values()),
        boundaries=named["boundaries"],
        interfaces=named["interfaces"],
        problems=tuple(problem for mesh in meshes for problem in mesh.problems),
        info=info,
    )
