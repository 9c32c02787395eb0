"""Every hexahedron of a swept block in eight: which node, quad and hex of the fine block comes from where.

Place in the flow: ``pipeline.refinement`` has the new nodes placed as those of hexahedra of 27 nodes, which are the
same lattice, and sorts them here into the layers of a finer :class:`~cadsweep.cells.SweptStructure`.

::

    d---e2---c      Fine source nodes: the coarse ones under their numbers, then the middles of the quads' edges,
    |    |    |     then the quads' centres. Fine layer 2k is coarse layer k. Fine quad 4q + j has corner j of quad q
    e3---m---e1     as its corner j.
    |    |    |
    a---e0---b
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray, IntArray
from ..cells import SweptStructure
from ..mesh import QuadMesh, SurfaceMesh

_SIDE_CENTRES = (22, 21, 23, 20)
"""Node of a hex27 at the centre of the side that stands on edge j of its bottom."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Halved:
    """A swept structure with half the steps in every direction.

    Attributes
    ----------
    structure : SweptStructure
    lattice : (2 n_layers + 1, n_nodes) int64
        Node of the hex27 mesh at every fine node.
    parents : (8 m,) int64
        Coarse hex of every fine one.
    middles : (e, 2) int64
        Source nodes at the ends of the edges that fine source nodes ``n ... n + e - 1`` are the middles of.
    quads : (q, 4) int64
        The coarse quads; fine source node ``n + e + q`` is the centre of quad q.
    n_coarse : int
        Nodes of the coarse source, n.
    """

    structure: SweptStructure
    lattice: IntArray
    parents: IntArray
    middles: IntArray
    quads: IntArray
    n_coarse: int

    @property
    def nodes(self) -> IntArray:
        """Fine node of every coarse one, (n_node_layers * n,)."""
        n_layers = self.structure.n_layers // 2 + (not self.structure.periodic)
        return np.asarray(np.arange(n_layers)[:, None] * 2 * self.structure.n_nodes + np.arange(self.n_coarse)).reshape(
            -1
        )

    def prolonged(self, values: FloatArray) -> FloatArray:
        """Values (n_layers + 1, n, ...) at coarse nodes, and their means at the nodes between."""
        n_layers, n = values.shape[:2]
        fine = np.empty((2 * n_layers - 1, self.structure.n_nodes, *values.shape[2:]))
        even = fine[::2]
        even[:, :n] = values
        even[:, n : n + len(self.middles)] = 0.5 * (values[:, self.middles[:, 0]] + values[:, self.middles[:, 1]])
        even[:, n + len(self.middles) :] = values[:, self.quads].mean(axis=2)
        fine[1::2] = 0.5 * (even[:-1] + even[1:])
        return fine

    def source(self, coarse: QuadMesh, points: FloatArray) -> QuadMesh:
        """The source cap's mesh; `points` (n_nodes, 3) of the fine source."""
        n = self.n_coarse
        return QuadMesh(
            points=points,
            quads=self.structure.quads,
            faces=np.repeat(coarse.faces, 4),
            loops=self.structure.loops,
            edge_nodes={e: _between(nodes, self.middles, n) for e, nodes in coarse.edge_nodes.items()},
        )


def halve(structure: SweptStructure, hexes: IntArray) -> Halved:
    """Halve a structure whose mesh has got hexahedra of 27 nodes (m, 27)."""
    quads, n, n_layers = structure.quads, structure.n_nodes, structure.n_layers
    pairs = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2), axis=2)
    middles, edge_of = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    edge_of = n + edge_of.reshape(-1, 4)
    centres = n + len(middles) + np.arange(len(quads))
    n_fine = n + len(middles) + len(quads)
    table = hexes.reshape(n_layers, len(quads), 27)
    lattice = np.empty((2 * n_layers + 1, n_fine), dtype=np.int64)
    for layers, rows, corners, edges, centre in (
        (slice(0, -1, 2), table, range(4), range(8, 12), 24),
        (slice(-1, None), table[-1:], range(4, 8), range(12, 16), 25),
        (slice(1, None, 2), table, range(16, 20), _SIDE_CENTRES, 26),
    ):
        for j, (corner, edge) in enumerate(zip(corners, edges, strict=True)):
            lattice[layers, quads[:, j]] = rows[:, :, corner]
            lattice[layers, edge_of[:, j]] = rows[:, :, edge]
        lattice[layers, centres] = rows[:, :, centre]
    e0, e1, e2, e3 = edge_of.T
    a, b, c, d = quads.T
    fine_quads = np.stack(
        [[a, e0, centres, e3], [e0, b, e1, centres], [centres, e1, c, e2], [e3, centres, e2, d]], axis=0
    ).transpose(2, 0, 1)
    parents = np.arange(n_layers * len(quads), dtype=np.int64).reshape(n_layers, len(quads))
    middles = middles.astype(np.int64)
    return Halved(
        structure=SweptStructure(
            quads=np.ascontiguousarray(fine_quads.reshape(-1, 4)),
            loops=tuple(_between(np.append(loop, loop[0]), middles, n)[:-1] for loop in structure.loops),
            n_nodes=n_fine,
            n_layers=2 * n_layers,
            periodic=structure.periodic,
        ),
        lattice=lattice,
        parents=np.repeat(np.repeat(parents, 2, axis=0), 4, axis=1).reshape(-1),
        middles=middles,
        quads=quads,
        n_coarse=n,
    )


def _between(nodes: IntArray, middles: IntArray, n: int) -> IntArray:
    """A chain of source nodes with the middles of its segments between them."""
    known = middles[:, 0] * n + middles[:, 1]  # ascending
    first, second = nodes[:-1], nodes[1:]
    chain = np.empty(2 * len(nodes) - 1, dtype=np.int64)
    chain[::2] = nodes
    chain[1::2] = n + np.searchsorted(known, np.minimum(first, second) * n + np.maximum(first, second))
    return chain


def halved_surfaces(
    halved: Halved,
    coarse: SurfaceMesh,
    points: FloatArray,
    *,
    around: IntArray,
    along: IntArray,
    target_edges: Mapping[int, tuple[int, bool]],
) -> SurfaceMesh:
    """The boundary's mesh with half the steps.

    Parameters
    ----------
    points : (2 n_layers + 1, n_nodes, 3) float64
        Where the fine nodes are; of those inside only the caps' are used.
    around, along : (n_layers + 1, b), (n_layers, b) int64
        CAD edge on which the segment from a ring node to the next, and to the next layer, lies; -1 where it lies
        on none.
    target_edges : as ``Sweep.target_edges``
    """
    source = halved.source(coarse.source, points[0])
    n_layers, b = along.shape
    edges = np.full((2 * n_layers + 1, 2 * b), -1, dtype=np.int64)
    vertices = np.full_like(edges, -1)
    edges[::2, ::2], edges[::2, 1::2], edges[1::2, ::2] = coarse.node_edges, around, along
    vertices[::2, ::2] = coarse.node_vertices
    on_target = {}
    for edge, nodes in source.edge_nodes.items():
        target, forward = target_edges.get(edge, (-1, True))
        if target in coarse.target_edge_points:
            on_target[target] = points[-1][nodes if forward else nodes[::-1]]
    return SurfaceMesh(
        source=source,
        rings=np.ascontiguousarray(points[:, np.concatenate(source.loops)]),
        side_faces=np.repeat(np.repeat(coarse.side_faces, 2, axis=0), 2, axis=1),
        node_edges=edges,
        node_vertices=vertices,
        target_edge_points=on_target,
    )
