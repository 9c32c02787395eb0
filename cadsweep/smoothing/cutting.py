"""Cutting patches out of a mesh: neighbourhoods, connected pieces, nodes shared with the rest.

A mesh is known by the layers of its sweep, or, where it is several blocks, by its hexahedra alone.

Place in the flow: :mod:`cadsweep.smoothing.ladder` decides what a patch grows from.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ..arrays import IntArray
from ..cells import SweptStructure
from .patch import BoolArray


@dataclass(frozen=True, eq=False)
class Blocks:
    """Hexahedra (m, 8) of several blocks in one numbering of `n_nodes` nodes."""

    hexes: IntArray
    n_nodes: int

    @cached_property
    def incidence(self) -> scipy.sparse.csr_matrix:
        """Which node (row) is a corner of which hexahedron (column)."""
        cols = np.repeat(np.arange(len(self.hexes)), 8)
        shape = (self.n_nodes, len(self.hexes))
        return scipy.sparse.csr_matrix((np.ones(len(cols), dtype=np.float32), (self.hexes.ravel(), cols)), shape=shape)

    @cached_property
    def uses(self) -> IntArray:
        """Hexahedra (n_nodes,) at every node."""
        return np.bincount(self.hexes.ravel(), minlength=self.n_nodes)


Connected = SweptStructure | Blocks


def hex_nodes(structure: Connected, hexes: IntArray) -> IntArray:
    """Nodes (m, 8) of hexahedra given by id."""
    if isinstance(structure, Blocks):
        return structure.hexes[hexes]
    layer, quad = np.divmod(hexes, len(structure.quads))
    lower = structure.quads[quad] + (layer * structure.n_nodes)[:, None]
    upper_layer = (layer + 1) % structure.n_layers if structure.periodic else layer + 1
    return np.hstack([lower, structure.quads[quad] + (upper_layer * structure.n_nodes)[:, None]])


def _incidence(structure: SweptStructure) -> scipy.sparse.csr_matrix:
    """Which node (row) is a corner of which quad (column) of one layer."""
    q = structure.quads
    rows, cols = q.ravel(), np.repeat(np.arange(len(q)), 4)
    return scipy.sparse.csr_matrix((np.ones(len(rows)), (rows, cols)), shape=(structure.n_nodes, len(q)))


def grown(marked: BoolArray, structure: Connected, rings: int) -> BoolArray:
    """Add to marked hexahedra, (n_layers, q) or (m,), those within some rings of neighbours across nodes."""
    if isinstance(structure, Blocks):
        for _ in range(rings):
            touched = (structure.incidence @ marked.astype(np.float32)) > 0
            marked = (structure.incidence.T @ touched.astype(np.float32)) > 0
        return marked
    incidence = _incidence(structure)
    for _ in range(rings):
        touched = (incidence @ marked.T.astype(np.float64)) > 0
        marked = (incidence.T @ touched.astype(np.float64)).T > 0
        wider = marked.copy()
        wider[1:] |= marked[:-1]
        wider[:-1] |= marked[1:]
        if structure.periodic:
            wider[0] |= marked[-1]
            wider[-1] |= marked[0]
        marked = wider
    return marked


def patches(region: BoolArray, structure: Connected) -> list[IntArray]:
    """Split marked hexahedra, (n_layers, q) or (m,), into connected pieces of ascending ids."""
    ids = np.flatnonzero(region.ravel())
    if not len(ids):
        return []
    nodes, local = np.unique(hex_nodes(structure, ids), return_inverse=True)
    rows, cols = np.repeat(np.arange(len(ids)), 8), local.ravel() + len(ids)
    size = len(ids) + len(nodes)
    graph = scipy.sparse.coo_matrix((np.ones(len(rows), dtype=np.int8), (rows, cols)), shape=(size, size))
    _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    label = label[: len(ids)]
    order = np.argsort(label, kind="stable")
    cuts = np.flatnonzero(np.diff(label[order])) + 1
    return [np.sort(piece) for piece in np.split(ids[order], cuts)]


def touches_others(structure: Connected, hexes: IntArray, nodes: IntArray) -> BoolArray:
    """Which nodes of a patch belong to a hexahedron outside it."""
    counts = np.bincount(np.searchsorted(nodes, hex_nodes(structure, hexes).ravel()), minlength=len(nodes))
    if isinstance(structure, Blocks):
        return counts < structure.uses[nodes]
    per_node = np.bincount(structure.quads.ravel(), minlength=structure.n_nodes)
    layer, node = np.divmod(nodes, structure.n_nodes)
    sides = np.full(len(nodes), 2)
    if not structure.periodic:
        sides[(layer == 0) | (layer == structure.n_layers)] = 1
    return counts < per_node[node] * sides
