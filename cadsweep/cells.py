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

import numpy as np

from .arrays import IntArray

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
    layers = np.arange(n_layers, dtype=np.int64)[:, None, None] * n_nodes
    np.add(quads, layers, out=hexes[:, :, :4])
    np.add(hexes[:, :, :4], n_nodes, out=hexes[:, :, 4:])
    if periodic:
        hexes[-1, :, 4:] = quads
    return hexes.reshape(-1, 8)


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
