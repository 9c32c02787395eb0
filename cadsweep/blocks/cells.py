"""Cells that were meshed on one skeleton, their insides still factors.

Place in the flow: ``pipeline`` makes it cell by cell; :meth:`CellBlocks.joined` multiplies it out in memory,
:func:`~cadsweep.blocks.finish.to_block_mesh` leaves it in blocks.

The skeleton (edges, faces, cells of corner blocks) is small beside the insides of cells and has a numbering of its own.
In the whole mesh the nodes inside a cell come after what of the skeleton was there when it was filled; those of a mesh
of one swept cell are numbered layer by layer instead (:class:`~cadsweep.cells.SweptStructure`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Units
from ..cells import SweptStructure, fill_hexes, hexes_at_faces
from ..projection import FactoredSweep
from .joined import JoinedMesh
from .slabs import SweptBlock


@dataclass(frozen=True, kw_only=True, eq=False)
class SweptCell:
    """The mesh of a cell that is swept; nodes are the skeleton's.

    Attributes
    ----------
    cell : int
    sweep : FactoredSweep
    bottom, top : (n,) int64
        Nodes of its caps.
    rings : (n_layers + 1, b) int64
    after : int
        Nodes of the skeleton that come before those inside.
    seen : (s,) int64 or None
        Which of the quads of its caps and sides, one after the other, are known to others: those of columns that touch
        are not. None for all.
    kept : (k,) int64
        Nodes of the source cap whose images smoothing leaves where they are, in every layer.
    """

    cell: int
    sweep: FactoredSweep
    bottom: IntArray
    top: IntArray
    rings: IntArray
    after: int
    seen: IntArray | None = None
    kept: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))

    @property
    def n_hexes(self) -> int:
        """Hexahedra."""
        return self.sweep.n_layers * len(self.sweep.quads)

    @property
    def n_own(self) -> int:
        """Nodes inside."""
        return (self.sweep.n_layers - 1) * (self.sweep.n_nodes - len(self.sweep.ring_nodes))

    def quad_hexes(self) -> IntArray:
        """The hexahedron at every boundary quad that others know: of source, target and sides."""
        s = self.sweep
        every = np.concatenate(hexes_at_faces(s.quads, s.loops, s.n_nodes, s.n_layers))
        return every if self.seen is None else every[self.seen]


@dataclass(frozen=True, kw_only=True, eq=False)
class FilledCell:
    """The mesh of a cell of corner blocks: hexahedra (m, 8) of the skeleton's nodes."""

    cell: int
    hexes: IntArray

    @property
    def n_hexes(self) -> int:
        """Hexahedra."""
        return len(self.hexes)


@dataclass(frozen=True, kw_only=True, eq=False)
class CellBlocks:
    """The cells of a part, in order; arrays as in :class:`~.joined.JoinedMesh`, but in the skeleton's numbers.

    Attributes
    ----------
    points : (s, 3) float64
        Nodes of the skeleton, working units.
    cells : tuple of SweptCell or FilledCell
        In order.
    firsts : tuple of int
        Number in the whole mesh of each cell's first node inside.
    numbers : (s,) int64
        Number in the whole mesh of every node of the skeleton; ascending, but for one swept cell.
    moved_nodes, moved_points : (m,) int64, (m, 3) float64
        Nodes, by their numbers in the whole mesh, that smoothing moved, and where to.
    """

    points: FloatArray
    cells: tuple[SweptCell | FilledCell, ...]
    firsts: tuple[int, ...]
    numbers: IntArray
    quads: IntArray
    quad_cells: IntArray
    quad_faces: IntArray
    roles: dict[tuple[int, int], str] = field(default_factory=dict)
    edge_nodes: dict[int, IntArray] = field(default_factory=dict)
    moved_nodes: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    moved_points: FloatArray = field(default_factory=lambda: np.empty((0, 3)))

    @property
    def n_hexes(self) -> int:
        """Hexahedra of all cells."""
        return sum(own.n_hexes for own in self.cells)

    @property
    def n_nodes(self) -> int:
        """Nodes of the whole mesh."""
        return len(self.points) + sum(own.n_own for own in self.cells if isinstance(own, SweptCell))

    def moved(self, nodes: IntArray, points: FloatArray) -> CellBlocks:
        """The same with some nodes, ascending numbers of the whole mesh, elsewhere."""
        at = np.searchsorted(nodes, self.numbers)
        kept = np.flatnonzero(np.isin(self.numbers, nodes))
        skeleton = self.points.copy()
        skeleton[kept] = points[at[kept]]
        return replace(self, points=skeleton, moved_nodes=nodes, moved_points=points)

    @property
    def structure(self) -> SweptStructure | None:
        """Of one swept cell that is numbered layer by layer, its layers."""
        own = self.cells[0]
        if self.firsts != (0,) or not isinstance(own, SweptCell):
            return None  # the inside comes after the skeleton
        return structure_of(own)

    def swept_block(self, number: int, units: Units, first_hex: int) -> SweptBlock:
        """A cell that is swept as a block of the whole mesh."""
        own = self.cells[number]
        assert isinstance(own, SweptCell), "the others are no factors"
        return SweptBlock(
            sweep=own.sweep,
            units=units,
            bottom=self.numbers[own.bottom],
            top=self.numbers[own.top],
            rings=self.numbers[own.rings],
            first_node=self.firsts[number],
            first_hex=first_hex,
            whole=self.structure,
            moved_nodes=self.moved_nodes,
            moved_points=self.moved_points,
        )

    @property
    def kept_nodes(self) -> IntArray:
        """Nodes of the whole mesh that smoothing leaves where they are."""
        nodes = [np.empty(0, dtype=np.int64)]
        for number, own in enumerate(self.cells):
            if isinstance(own, SweptCell) and len(own.kept):
                block = self.swept_block(number, Units(), 0)
                nodes.append(block.layers(np.arange(block.n_layers + 1))[:, own.kept].reshape(-1))
        return np.concatenate(nodes)

    def joined(self) -> JoinedMesh:
        """Multiply out."""
        points = np.empty((self.n_nodes, 3))
        points[self.numbers] = self.points
        hexes = np.empty((self.n_hexes, 8), dtype=np.int64)
        blocks, first = [], 0
        for number, own in enumerate(self.cells):
            filled = hexes[first : first + own.n_hexes]
            if isinstance(own, FilledCell):
                filled[:] = self.numbers[own.hexes]
            else:
                block = self.swept_block(number, Units(), first)
                nodes = block.layers(np.arange(block.n_layers + 1))
                if own.n_own and block.whole is not None:
                    own.sweep.points(slice(1, own.sweep.n_layers), out=_layers_of(points, block.whole))
                elif own.n_own:
                    inner = points[block.first_node : block.first_node + own.n_own]
                    made = own.sweep.points(slice(1, own.sweep.n_layers))
                    np.take(made, block.inside, axis=1, out=inner.reshape(len(made), -1, 3), mode="clip")
                fill_hexes(nodes, own.sweep.quads, filled)
                if block.whole is None:
                    blocks.append(block.structure)
            first += own.n_hexes
        points[self.moved_nodes] = self.moved_points
        return JoinedMesh(
            points=points,
            hexes=hexes,
            hex_cells=np.repeat([own.cell for own in self.cells], [own.n_hexes for own in self.cells]),
            quads=self.numbers[self.quads],
            quad_cells=self.quad_cells,
            quad_faces=self.quad_faces,
            roles=self.roles,
            edge_nodes={key: self.numbers[nodes] for key, nodes in self.edge_nodes.items()},
            blocks=tuple(blocks),
            structure=self.structure,
        )


def structure_of(own: SweptCell) -> SweptStructure:
    """The layers of a cell by itself."""
    sweep = own.sweep
    closed = bool((own.bottom == own.top).all())
    return SweptStructure(
        quads=sweep.quads, loops=sweep.loops, n_nodes=sweep.n_nodes, n_layers=sweep.n_layers, periodic=closed
    )


def _layers_of(points: FloatArray, structure: SweptStructure) -> FloatArray:
    """Nodes between the caps, layer by layer."""
    return points.reshape(-1, structure.n_nodes, 3)[1 : structure.n_layers]


def number_blocks(n_skeleton: int, cells: Sequence[SweptCell | FilledCell]) -> tuple[IntArray, dict[int, int]]:
    """Number the nodes of a mesh whose cells were filled in the order that is given.

    Returns
    -------
    numbers : (n_skeleton,) int64
        Of the skeleton's nodes in the whole mesh.
    firsts : dict of int to int
        Of the first node inside every cell.
    """
    swept = [own for own in cells if isinstance(own, SweptCell)]
    if len(cells) == len(swept) == 1:
        (own,) = swept
        structure, numbers = structure_of(own), np.empty(n_skeleton, dtype=np.int64)
        layers = structure.layers(np.arange(own.sweep.n_layers + 1))
        numbers[own.rings] = layers[:, own.sweep.ring_nodes]
        numbers[own.top], numbers[own.bottom] = layers[-1], layers[0]
        return numbers, {own.cell: 0}
    after = np.array([own.after for own in swept], dtype=np.int64)
    before = np.cumsum([0, *(own.n_own for own in swept)], dtype=np.int64)
    skeleton = np.arange(n_skeleton, dtype=np.int64)
    firsts = {own.cell: int(own.after + start) for own, start in zip(swept, before, strict=False)}
    return skeleton + before[np.searchsorted(after, skeleton, side="right")], firsts
