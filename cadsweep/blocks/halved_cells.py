"""Every hexahedron of a mesh of several cells in eight: which hex and quad of the fine mesh comes from where.

Place in the flow: ``pipeline`` has the new nodes placed as those of hexahedra of 27 nodes, which are the fine mesh's;
the coarse ones keep their numbers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import FloatArray, IntArray
from ..cells import HEX_EDGES
from .joined import JoinedMesh

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
"""Corners of a hexahedron."""


def split_hexes(hexes: IntArray) -> IntArray:
    """The eight hexes (8 m, 8) of every hex of 27 nodes (m, 27): 8 j + c has corner c of hex j as its corner c."""
    places = _lattice_places()
    children = CORNERS[:, None] + CORNERS
    return np.asarray(hexes[:, places[children[..., 0], children[..., 1], children[..., 2]]]).reshape(-1, 8)


def _lattice_places() -> IntArray:
    """Node (3, 3, 3) of a hex of 27 nodes in VTK's order at each place of its lattice."""
    corners = 2 * CORNERS
    middles = corners[HEX_EDGES].sum(axis=1) // 2
    sides = [[0, 1, 1], [2, 1, 1], [1, 0, 1], [1, 2, 1], [1, 1, 0], [1, 1, 2]]
    places = np.full((3, 3, 3), -1, dtype=np.int64)
    for node, place in enumerate([*corners, *middles, *sides, [1, 1, 1]]):
        places[tuple(place)] = node
    return places


def split_quads(quads: IntArray, middles: IntArray, centres: IntArray) -> IntArray:
    """The four quads (4 q, 4) of each quad, from the nodes in the middle of its edges (q, 4) and its centre (q,)."""
    (a, b, c, d), (e, f, g, h) = quads.T, middles.T
    m = centres
    return np.stack([[a, e, m, h], [e, b, f, m], [m, f, c, g], [h, m, g, d]], axis=0).transpose(2, 0, 1).reshape(-1, 4)


def halve_joined(
    coarse: JoinedMesh, points: FloatArray, hexes: IntArray, quads: IntArray, chains: dict[int, IntArray]
) -> JoinedMesh:
    """The mesh with half the steps.

    Parameters
    ----------
    coarse : JoinedMesh
    points : (n, 3) float64
        Fine nodes, the coarse ones first.
    hexes : (m, 27) int64
    quads : (4 q, 4) int64
        Of ``coarse.quads``, four each.
    chains : dict of int to int64 array
        ``coarse.edge_nodes`` with the middles between them.
    """
    return replace(
        coarse,
        points=points,
        hexes=split_hexes(hexes),
        blocks=(),
        structure=None,
        hex_cells=np.repeat(coarse.hex_cells, 8),
        quads=quads,
        quad_cells=np.repeat(coarse.quad_cells, 4),
        quad_faces=np.repeat(coarse.quad_faces, 4),
        edge_nodes=chains,
    )
