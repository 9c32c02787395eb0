"""The hexahedron and its tables, and meshes that are layers of one quad mesh.

Node order of a hexahedron (VTK)::

          7-------6            bottom 0 1 2 3 lies nearer to the source; seen along the sweep
         /|      /|            it turns counter-clockwise, so its normal (right-hand rule) points
        4-------5 |            along the sweep and the volume is positive.
        | 3-----|-2
        |/      |/             hex20 adds the middles of the edges
        0-------1                8: 0-1    9: 1-2   10: 2-3   11: 3-0
                                12: 4-5   13: 5-6   14: 6-7   15: 7-4
                                16: 0-4   17: 1-5   18: 2-6   19: 3-7
                               hex27 adds the middles of the faces, then of the volume
                                20: 0-4-7-3   21: 1-2-6-5   22: 0-1-5-4
                                23: 3-7-6-2   24: 0-3-2-1   25: 4-5-6-7   26: volume

Quads of order 2 are quad8 ``(corners, middles of 0-1, 1-2, 2-3, 3-0)`` or quad9 (plus the centre).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .arrays import IntArray, others
from .compiled import compiled
from .threads import LIGHT, map_chunks

HEX_FACES = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]],
    dtype=np.int64,
)
"""The six outward faces of a hexahedron: bottom, top, then the four sides in the order of the quad's edges."""

HEX_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]],
    dtype=np.int64,
)
"""Corners of the edge whose middle is node 8 + j of a hexahedron."""

AXIS_EDGES = np.array(
    [
        [[0, 1], [3, 2], [4, 5], [7, 6]],
        [[0, 3], [1, 2], [4, 7], [5, 6]],
        [[0, 4], [1, 5], [2, 6], [3, 7]],
    ],
    dtype=np.int64,
)
"""The same edges along xi, eta and zeta, each from its lower to its upper end."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SweptStructure:
    """How a hexahedral mesh is made of layers of one quad mesh.

    Node i of layer k is ``k * n_nodes + i``; hex q between layers k and k + 1 is ``k * n_quads + q``
    and has the nodes ``quads[q] + k * n_nodes`` and ``quads[q] + (k + 1) * n_nodes``. On a closed
    ring (``periodic``) the last layer is the first.

    Examples
    --------
    >>> import cadquery as cq
    >>> import cadsweep as cs
    >>> box = cq.Workplane().box(4, 3, 2)
    >>> structure = cs.sweep_mesh(box, size=1.0, layers=2).structure
    >>> structure.n_layers, structure.quads.shape, structure.n_nodes
    (2, (12, 4), 20)
    """

    quads: IntArray
    loops: tuple[IntArray, ...]
    n_nodes: int
    n_layers: int
    periodic: bool = False

    def layers(self, layers: IntArray) -> IntArray:
        """Nodes (k, n_nodes) of layers of nodes."""
        kept = layers % self.n_layers if self.periodic else layers
        return kept[:, None] * self.n_nodes + np.arange(self.n_nodes)


@dataclass(frozen=True, kw_only=True, eq=False)
class BlockStructure:
    """How some hexahedra of a mesh are layers of one quad mesh between nodes that they share with others.

    Attributes
    ----------
    quads : (q, 4) int64
        By places in a layer, as are the loops.
    loops : tuple of int64 arrays
        Around the layer, the outer one first.
    n_nodes : int
        Nodes of a layer.
    bottom, top : (n_nodes,) int64
        Nodes of the mesh in the first and in the last layer; others may have them, too.
    rings : (n_layers + 1, b) int64
        Nodes of the mesh around every layer, in the order of the loops; others may have them, too.
    first_node, first_hex : int
        Numbers of its first node inside, and of its first hexahedron; the others follow, layer by layer.
    whole : SweptStructure or None
        Where the block is all of the mesh: its layers are numbered as this says, one after the other.
    """

    quads: IntArray
    loops: tuple[IntArray, ...]
    n_nodes: int
    bottom: IntArray
    top: IntArray
    rings: IntArray
    first_node: int
    first_hex: int
    whole: SweptStructure | None = None

    @property
    def n_layers(self) -> int:
        """Layers of hexahedra."""
        return len(self.rings) - 1

    @property
    def n_hexes(self) -> int:
        """Hexahedra."""
        return self.n_layers * len(self.quads)

    @cached_property
    def inside(self) -> IntArray:
        """Nodes of a layer that are on no loop, by their places in the layer."""
        return others(self.n_nodes, np.concatenate(self.loops))

    @property
    def n_own(self) -> int:
        """Nodes inside, which no other hexahedra have."""
        return (self.n_layers - 1) * len(self.inside)

    def layers(self, layers: IntArray) -> IntArray:
        """Nodes (k, n_nodes) of layers of nodes."""
        if self.whole is not None:
            return self.first_node + self.whole.layers(layers)
        within = np.zeros(self.n_nodes, dtype=np.int64)
        within[self.inside] = self.first_node + np.arange(len(self.inside))
        nodes = (layers[:, None] - 1) * len(self.inside) + within
        nodes[:, np.concatenate(self.loops)] = self.rings[layers]
        nodes[layers == 0] = self.bottom
        nodes[layers == self.n_layers] = self.top
        return nodes


def sweep_hexes(quads: IntArray, n_nodes: int, n_layers: int, *, periodic: bool = False) -> IntArray:
    """Connect layers of a quad mesh to hexahedra, as :class:`SweptStructure` numbers them.

    Parameters
    ----------
    quads : (q, 4) int64
    n_nodes : int
        Nodes of one layer.
    n_layers : int
        Layers of hexahedra.
    periodic : bool
        The last layer of hexahedra closes on the first layer of nodes.

    Returns
    -------
    (n_layers * q, 8) int64
    """
    hexes = np.empty((n_layers, len(quads), 8), dtype=np.int64)
    plane = np.ascontiguousarray(quads, dtype=np.int64)
    step = max(1, LIGHT // max(1, len(quads)))
    for _ in map_chunks(lambda run: _fill_layers(plane, n_nodes, run.start, hexes[run]), n_layers, chunk=step):
        pass
    if periodic:
        hexes[-1, :, 4:] = quads
    return hexes.reshape(-1, 8)


@compiled(cache=True, nogil=True)
def _fill_layers(quads, n_nodes, first, hexes):  # type: ignore[no-untyped-def]
    """Write the hexahedra (k, q, 8) of quads (q, 4) between layers of nodes from `first` on."""
    for k in range(hexes.shape[0]):
        low = (first + k) * n_nodes
        for j in range(quads.shape[0]):
            for i in range(4):
                hexes[k, j, i] = quads[j, i] + low
                hexes[k, j, 4 + i] = quads[j, i] + low + n_nodes


@compiled(cache=True, nogil=True)
def fill_hexes(nodes, quads, hexes):  # type: ignore[no-untyped-def]
    """Write hexahedra of quads (q, 4) between layers of nodes (n_layers + 1, n) into an array (n_layers * q, 8)."""
    n = quads.shape[0]
    for k in range(nodes.shape[0] - 1):
        for j in range(n):
            for i in range(4):
                hexes[k * n + j, i] = nodes[k, quads[j, i]]
                hexes[k * n + j, 4 + i] = nodes[k + 1, quads[j, i]]


def side_quads(loops: Sequence[IntArray], n_nodes: int, n_layers: int, *, periodic: bool = False) -> IntArray:
    """Outward quads of the linking sides.

    Returns
    -------
    (n_layers, b, 4) int64
        Quad (k, j) stands on ring segment j (from ring node j to its successor in its loop)
        between layers k and k + 1.
    """
    starts = np.concatenate([np.asarray(loop) for loop in loops])
    ends = np.concatenate([np.roll(loop, -1) for loop in loops])
    layers = np.arange(n_layers, dtype=np.int64)[:, None] * n_nodes
    upper = layers + n_nodes
    if periodic:
        upper[-1] = 0
    return np.stack([starts + layers, ends + layers, ends + upper, starts + upper], axis=-1)


def quads_of_segments(quads: IntArray, loops: tuple[IntArray, ...], n_nodes: int) -> IntArray:
    """The quad (b,) of a layer that has each segment of its loops as an edge."""
    starts, ends = np.concatenate(loops), np.concatenate([np.roll(loop, -1) for loop in loops])
    edges = quads * n_nodes + np.roll(quads, -1, axis=1)
    order = np.argsort(edges, axis=None)
    found = np.searchsorted(edges.reshape(-1), starts * n_nodes + ends, sorter=order)
    return order[found] // 4


def hexes_at_faces(quads: IntArray, loops: tuple[IntArray, ...], n_nodes: int, n_layers: int) -> list[IntArray]:
    """The hexahedron, of those of one sweep, at every quad of its source, of its target and of its sides."""
    q = len(quads)
    beside = quads_of_segments(quads, loops, n_nodes)
    sides = np.arange(n_layers)[:, None] * q + beside
    return [np.arange(q), (n_layers - 1) * q + np.arange(q), sides.reshape(-1)]
