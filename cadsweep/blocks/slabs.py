"""Blocks of a mesh, each of which can be multiplied out some layers at a time.

Place in the flow: :mod:`.block_mesh` joins them to one mesh; :mod:`.stream` and :mod:`.pieces` go through them.

============= ==================================================================
block         what it is made of
============= ==================================================================
SweptBlock    a cell that is swept between others: its caps and sides are borrowed,
              only the nodes inside are its own; all are where it is the whole mesh
ArrayBlock    hexahedra as they are: all nodes are borrowed
============= ==================================================================

A block borrows nodes from what the whole mesh keeps (:class:`~.block_mesh.BlockMesh`): those have their numbers
already, and stand in several blocks.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, distinct
from ..brep import Units
from ..cells import BlockStructure, SweptStructure, sweep_hexes
from ..projection import FactoredSweep
from ..quality import block_problems

SLAB_NODES = 200_000
"""Nodes of a slab: large enough for the arithmetic, small enough for the cache and for flat memory."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Slab:
    """Some layers of hexahedra.

    Attributes
    ----------
    points : (p, 3) float64
        Nodes, model units. Valid until the next slab is made.
    nodes : (p,) int64
        Their numbers in the whole mesh.
    hexes : (m, 8) int64
        Rows of `points`.
    first_hex : int
        Number of the first of them; the others follow.
    own : (o,) int64
        Rows of `points` whose nodes are this slab's own.
    first_node : int
        Number of the first of these; the others follow.
    layer, per_layer : int
        Layer of the block that the first hexahedron is in, and hexahedra of a layer.
    """

    points: FloatArray
    nodes: IntArray
    hexes: IntArray
    first_hex: int
    own: IntArray
    first_node: int
    layer: int
    per_layer: int

    def cut(self, start: int, stop: int) -> Slab:
        """Some of its hexahedra, with points of their own, which no later slab overwrites."""
        rows, hexes = np.unique(self.hexes[start:stop], return_inverse=True)
        return Slab(
            points=self.points[rows],
            nodes=self.nodes[rows],
            hexes=hexes.reshape(-1, 8),
            first_hex=self.first_hex + start,
            own=np.empty(0, dtype=np.int64),
            first_node=0,
            layer=self.layer,
            per_layer=self.per_layer,
        )


class Block(Protocol):
    """What every block knows."""

    @property
    def first_hex(self) -> int:
        """Number of its first hexahedron; the others follow."""

    @property
    def n_layers(self) -> int:
        """Layers of hexahedra, the steps in which it can be made."""

    @property
    def per_layer(self) -> int:
        """Hexahedra of a layer."""

    def slabs(self, start: int = 0, stop: int | None = None) -> Iterator[Slab]:
        """Make the layers `start` to `stop` (exclusive), a slab at a time."""

    def border(self, start: int, stop: int) -> IntArray:
        """Nodes of some layers that hexahedra elsewhere may have."""

    def touching(self, start: int, stop: int, nodes: IntArray) -> IntArray:
        """Layers outside `start` to `stop` that may have some of the nodes, ascending, of these layers and of other
        blocks."""

    def problems(self) -> list[str]:
        """What is wrong with its structure; nothing where its hexahedra conform."""

    def shifted(self, nodes: int, hexes: int) -> Block:
        """The same block with so many nodes and hexahedra before it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SweptBlock:
    """A sweep between others.

    Attributes
    ----------
    sweep : FactoredSweep
        Places of the nodes, working units.
    units : Units
        From working to model units.
    bottom, top : (n,) int64
        Borrowed nodes of the first and of the last layer.
    rings : (n_layers + 1, b) int64
        Borrowed nodes of the ring of every layer.
    first_node, first_hex : int
        Numbers of its first node inside, and of its first hexahedron; the others follow, layer by layer.
    whole : SweptStructure or None
        Where the block is all of the mesh, its layers.
    moved_nodes, moved_points : (m,) int64, (m, 3) float64
        Nodes of the whole mesh that smoothing moved, ascending, and where to, working units.
    """

    sweep: FactoredSweep
    units: Units
    bottom: IntArray
    top: IntArray
    rings: IntArray
    first_node: int
    first_hex: int
    whole: SweptStructure | None = None
    moved_nodes: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    moved_points: FloatArray = field(default_factory=lambda: np.empty((0, 3)))

    @property
    def n_layers(self) -> int:
        return self.sweep.n_layers

    @property
    def per_layer(self) -> int:
        return len(self.sweep.quads)

    @property
    def n_own(self) -> int:
        """Nodes inside."""
        return (self.n_layers - 1) * len(self.inside)

    @property
    def inside(self) -> IntArray:
        """Nodes of a layer that are not on its ring, by their places in the layer."""
        return self.structure.inside

    @cached_property
    def structure(self) -> BlockStructure:
        """Its quads times layers, in the numbers of the whole mesh."""
        return BlockStructure(
            quads=self.sweep.quads,
            loops=self.sweep.loops,
            n_nodes=self.sweep.n_nodes,
            bottom=self.bottom,
            top=self.top,
            rings=self.rings,
            first_node=self.first_node,
            first_hex=self.first_hex,
            whole=self.whole,
        )

    def layers(self, layers: IntArray) -> IntArray:
        """Nodes (k, n) of layers of nodes."""
        return self.structure.layers(layers)

    def placed(self, first: int, last: int, out: FloatArray | None = None) -> tuple[FloatArray, IntArray]:
        """Nodes of the layers `first` to `last` (inclusive): their places (m, 3), working units, and numbers (m,)."""
        points = self.sweep.points(slice(first, last + 1), out=out).reshape(-1, 3)
        nodes = self.layers(np.arange(first, last + 1)).reshape(-1)
        if len(self.moved_nodes):
            at = np.minimum(np.searchsorted(self.moved_nodes, nodes), len(self.moved_nodes) - 1)
            moved = self.moved_nodes[at] == nodes
            points[moved] = self.moved_points[at[moved]]
        return points, nodes

    def slabs(self, start: int = 0, stop: int | None = None) -> Iterator[Slab]:
        """Multiply out into one buffer."""
        n = self.sweep.n_nodes
        stop = self.n_layers if stop is None else stop
        step = max(1, min(stop - start, SLAB_NODES // n))
        buffer = np.empty((step + 1, n, 3))
        hexes = np.empty((0, 8), dtype=np.int64)
        for first in range(start, stop, step):
            last = min(first + step, stop)
            points, nodes = self.placed(first, last, out=buffer[: last - first + 1])
            if len(hexes) != (last - first) * self.per_layer:
                hexes = sweep_hexes(self.sweep.quads, n, last - first)
            own, first_node = self._own(first, last)
            yield Slab(
                points=self.units.to_model(points),
                nodes=nodes,
                hexes=hexes,
                first_hex=self.first_hex + first * self.per_layer,
                own=own,
                first_node=first_node,
                layer=first,
                per_layer=self.per_layer,
            )

    def _own(self, first: int, last: int) -> tuple[IntArray, int]:
        """Rows of the nodes of a slab that no slab before it has and nobody lends, and the number of the first."""
        if self.whole is not None:
            rows = np.arange(first + (first > 0), last + (last < self.n_layers or not self.whole.periodic))
            own: IntArray = ((rows - first)[:, None] * self.whole.n_nodes + np.arange(self.whole.n_nodes)).reshape(-1)
            return own, self.first_node + (first + (first > 0)) * self.whole.n_nodes
        below = max(first, 1)  # the first layer and the last are borrowed
        rows = np.arange(below - first, last - first)
        own = (rows[:, None] * self.sweep.n_nodes + self.inside).reshape(-1)
        return own, self.first_node + (below - 1) * len(self.inside)

    def border(self, start: int, stop: int) -> IntArray:
        ends = self.layers(np.array([start, stop]))
        return distinct(np.concatenate([ends.reshape(-1), self.rings[start : stop + 1].reshape(-1)]))

    def touching(self, start: int, stop: int, nodes: IntArray) -> IntArray:
        hit: BoolArray = np.asarray(np.isin(self.rings, nodes).any(axis=1))
        hit[0] |= np.isin(self.bottom, nodes).any()
        hit[-1] |= np.isin(self.top, nodes).any()
        if stop > start:
            hit[[start, stop]] = True
        layers = hit[:-1] | hit[1:]
        layers[start:stop] = False
        return np.flatnonzero(layers)

    def problems(self) -> list[str]:
        return block_problems(self.structure)

    def shifted(self, nodes: int, hexes: int) -> SweptBlock:
        return replace(
            self,
            bottom=self.bottom + nodes,
            top=self.top + nodes,
            rings=self.rings + nodes,
            moved_nodes=self.moved_nodes + nodes,
            first_node=self.first_node + nodes,
            first_hex=self.first_hex + hexes,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class ArrayBlock:
    """Hexahedra as they are; a layer is one of them.

    Attributes
    ----------
    points : (n, 3) float64
        Model units.
    nodes : (n,) int64
        Borrowed.
    hexes : (m, 8) int64
        Rows of `points`.
    first_hex : int
    """

    points: FloatArray
    nodes: IntArray
    hexes: IntArray
    first_hex: int

    @property
    def n_layers(self) -> int:
        return len(self.hexes)

    @property
    def per_layer(self) -> int:
        return 1

    def slabs(self, start: int = 0, stop: int | None = None) -> Iterator[Slab]:
        stop = len(self.hexes) if stop is None else stop
        every = Slab(
            points=self.points,
            nodes=self.nodes,
            hexes=self.hexes,
            first_hex=self.first_hex,
            own=np.empty(0, dtype=np.int64),
            first_node=0,
            layer=0,
            per_layer=1,
        )
        for first in range(start, stop, SLAB_NODES):
            yield replace(every.cut(first, min(first + SLAB_NODES, stop)), layer=first)

    def border(self, start: int, stop: int) -> IntArray:
        return self.nodes[distinct(self.hexes[start:stop])]

    def touching(self, start: int, stop: int, nodes: IntArray) -> IntArray:
        hit: BoolArray = np.asarray(np.isin(self.nodes, nodes)[self.hexes].any(axis=1))
        hit[start:stop] = False
        return np.flatnonzero(hit)

    def problems(self) -> list[str]:
        return []  # its faces are matched one by one, by who made it

    def shifted(self, nodes: int, hexes: int) -> ArrayBlock:
        return replace(self, nodes=self.nodes + nodes, first_hex=self.first_hex + hexes)
