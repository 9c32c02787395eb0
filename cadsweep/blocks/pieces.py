"""The share of a mesh that one of several processes makes: some layers of blocks, and the hexahedra around them.

Place in the flow: every rank makes its own :class:`Piece` of a :class:`~cadsweep.blocks.block_mesh.BlockMesh`, and
``pipeline`` writes them. Hexahedra of other pieces that have a node of this one are its ghosts. A node of several
pieces belongs to the one with the lowest rank.
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray, distinct
from ..io.vtk_cells import GHOSTS, HEX_IDS, NODE_IDS, QUAD_PLACES
from .block_mesh import BlockMesh
from .slabs import Slab
from .stream import BoundaryMarks, Run, field_arrays


def share_out(mesh: BlockMesh, rank: int, size: int) -> list[Run]:
    """The layers of a rank: as many hexahedra as the others have, to a layer; a run of each block that it has of."""
    n_hexes = mesh.n_hexes
    first, last = rank * n_hexes // size, (rank + 1) * n_hexes // size
    runs = []
    for block in mesh.blocks:
        start, stop = ((end - block.first_hex) // block.per_layer for end in (first, last))
        start, stop = max(start, 0), min(stop, block.n_layers)
        if start < stop:
            runs.append((block, start, stop))
    return runs


class Piece:
    """What one rank writes.

    Attributes
    ----------
    points : (n, 3) float64
        Model units, by ascending number in the whole mesh.
    hexes : (m, 8) int64
        In the piece's own numbers, ghosts included, by ascending number in the whole mesh.
    node_ids, hex_ids : (n,) int64, (m,) int64
        Their numbers in the whole mesh.
    """

    def __init__(self, mesh: BlockMesh, rank: int, size: int) -> None:
        runs = share_out(mesh, rank, size)
        own = [slab for block, start, stop in runs for slab in map(_kept, block.slabs(start, stop))]
        mine = distinct(_joined([slab.nodes for slab in own]))
        slabs = own + _around(mesh, runs, mine)
        slabs.sort(key=lambda slab: slab.first_hex)
        nodes = _joined([slab.nodes for slab in slabs])
        self.node_ids, first = np.unique(nodes, return_index=True)
        self.points = np.concatenate([np.empty((0, 3)), *(slab.points for slab in slabs)])[first]
        numbered = [slab.nodes[slab.hexes] for slab in slabs]
        corners = np.concatenate([np.empty((0, 8), dtype=np.int64), *numbered])
        self.hexes = np.searchsorted(self.node_ids, corners)
        ids = [np.arange(slab.first_hex, slab.first_hex + len(slab.hexes)) for slab in slabs]
        self.hex_ids = _joined(ids)
        starts = np.array([block.first_hex + start * block.per_layer for block, start, _ in runs])
        stops = np.array([block.first_hex + stop * block.per_layer for block, _, stop in runs])
        at = np.searchsorted(starts, self.hex_ids, side="right") - 1
        is_own = np.zeros(len(self.hex_ids), dtype=bool)
        if len(starts):
            is_own = (at >= 0) & (self.hex_ids < stops[at])
        lower = _joined([block.border(a, b) for r in range(rank) for block, a, b in share_out(mesh, r, size)])
        self.node_ghosts = (~np.isin(self.node_ids, mine) | np.isin(self.node_ids, lower)).astype(np.uint8)
        self.hex_ghosts = (~is_own).astype(np.uint8)
        of_block = np.searchsorted([block.first_hex for block in mesh.blocks], self.hex_ids, side="right") - 1
        self.parts = np.array(mesh.block_parts, dtype=np.int32)[of_block]
        self.marks = BoundaryMarks(mesh.faces).of(self.hex_ids)
        owned = self.hex_ids[is_own]
        rows = {name: np.flatnonzero(np.isin(faces.hexes, owned)) for name, faces in mesh.faces.items()}
        quads = {name: np.searchsorted(self.node_ids, mesh.faces[name].quads[own]) for name, own in rows.items()}
        places = {QUAD_PLACES + name: own for name, own in rows.items()} if size > 1 else {}
        self.fields = {**field_arrays(mesh, quads), **places}

    def node_arrays(self) -> dict[str, np.ndarray]:
        """Data of the points."""
        return {NODE_IDS: self.node_ids, GHOSTS: self.node_ghosts}

    def hex_arrays(self) -> dict[str, np.ndarray]:
        """Data of the cells."""
        return {HEX_IDS: self.hex_ids, GHOSTS: self.hex_ghosts, "part": self.parts, "boundary": self.marks}


def _around(mesh: BlockMesh, runs: list[Run], mine: IntArray) -> list[Slab]:
    """Hexahedra beside those of a piece that have a node of it, a slab for every run of numbers."""
    if not runs:
        return []
    of_block = {block.first_hex: (start, stop) for block, start, stop in runs}
    found = []
    for block in mesh.blocks:
        layers = block.touching(*of_block.get(block.first_hex, (0, 0)), mine)
        for run in np.split(layers, np.flatnonzero(np.diff(layers) > 1) + 1):
            if not len(run):
                continue
            for slab in block.slabs(int(run[0]), int(run[-1]) + 1):
                beside = np.flatnonzero(np.isin(slab.nodes, mine)[slab.hexes].any(axis=1))
                for ids in np.split(beside, np.flatnonzero(np.diff(beside) > 1) + 1):
                    if len(ids):
                        found.append(slab.cut(int(ids[0]), int(ids[-1]) + 1))
    return found


def _kept(slab: Slab) -> Slab:
    """The slab with points of its own."""
    return slab.cut(0, len(slab.hexes))


def _joined(arrays: list[IntArray]) -> IntArray:
    return np.concatenate([np.empty(0, dtype=np.int64), *arrays])
