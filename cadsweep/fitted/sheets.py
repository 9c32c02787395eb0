"""Sheets of hexahedra under the skin of a grid, where its own hexahedra would be flat once they lie on the model.

Two things make them flat, however fine the grid is: two quads of one hexahedron on one smooth face (their common edge
becomes one of 180 degrees), and two sides of one quad on one smooth curve (so does their common corner). One sheet
under the whole skin gives every quad a hexahedron of its own: at every edge of the model two meet, each with half of
the angle, whether it is convex, concave or smooth. A sheet around the hexahedra of one face gives the faces beside it a
row of quads along the border, inside or outside of it, so that two quads of these meet at every node of it::

    before           a sheet under the skin      and one around those of the face above
    --+--+--         --+--+--                    --+--+--      of the face
      |  |            \\ |  |                      \\_|__|__
    --+--+             -+--+                     |..+..+..     new hexahedra, with quads of the face beside
                                                 |  |
"""

from __future__ import annotations

import itertools
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..brep import Solid
from ..cells import HEX_EDGES, HEX_FACES
from .skin import find_hexes, outward_at, sides_around

_THICK = 0.3
"""Thickness of a sheet at first over the size of the grid; untangling evens it out."""
_MOST = 3
"""Rounds in which faces are given sheets; one does but where rows of two faces meet."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fitted:
    """A mesh of one solid whose boundary knows the solid's faces and edges.

    Attributes
    ----------
    points : (n, 3) float64
    hexes : (m, 8) int64
    quads : (q, 4) int64
        The boundary, outward.
    labels : (q,) int64
        Face of every quad.
    chains : dict of int to int64 array
        Nodes of every edge, by id, from its start to its end.
    """

    points: FloatArray
    hexes: IntArray
    quads: IntArray
    labels: IntArray
    chains: dict[int, IntArray]


def lay_sheets(solid: Solid, mesh: Fitted, size: float) -> Fitted:
    """The mesh with a sheet under its skin, and around faces, as far as it needs them."""
    if not (_shares_hexes(mesh) or _bent(solid, mesh)):
        return mesh
    mesh = _with_skin(mesh, size)
    for _ in range(_MOST):
        faces = _bent(solid, mesh)
        if not faces:
            break
        for face in sorted(faces):
            if face in _bent(solid, mesh):
                mesh = _with_sheet(mesh, face)
    return mesh


def _shares_hexes(mesh: Fitted) -> bool:
    """Whether some hexahedron has two quads on one face."""
    owners, _ = find_hexes(mesh.hexes, mesh.quads)
    both = np.stack([owners, mesh.labels], axis=1)
    return len(np.unique(both, axis=0)) < len(both)


def _bent(solid: Solid, mesh: Fitted) -> Collection[int]:
    """Faces around which a sheet is needed: some quad beside has two sides in turn on their border, and no vertex there."""
    beyond: dict[tuple[int, int], tuple[int, int]] = {}
    for edge, chain in mesh.chains.items():
        low, high = solid.edges[edge].faces
        for a, b in itertools.pairwise(chain.tolist()):
            beyond[a, b] = beyond[b, a] = (low, high)
    vertices = {int(chain[j]) for chain in mesh.chains.values() for j in (0, -1)}
    found = set()
    on_edges = np.zeros(len(mesh.points), dtype=np.int64)
    for chain in mesh.chains.values():
        on_edges[chain] = 1
    near = on_edges[mesh.quads].sum(axis=1) > 2
    for quad, label in zip(mesh.quads[near].tolist(), mesh.labels[near].tolist(), strict=True):
        across = [sum(beyond.get((quad[j], quad[(j + 1) % 4]), (-1, label))) - label for j in range(4)]
        found |= {across[j] for j in range(4) if across[j] == across[j - 1] >= 0 and quad[j] not in vertices}
    return found


def _with_skin(mesh: Fitted, size: float) -> Fitted:
    """A sheet under the whole skin: what was there keeps to a copy of its nodes, hexahedra join the two."""
    nodes = np.unique(mesh.quads)
    inner = np.arange(len(mesh.points))
    inner[nodes] = len(mesh.points) + np.arange(len(nodes))
    sunk = mesh.points[nodes] - _THICK * size * outward_at(mesh.points, mesh.quads)[nodes]
    return Fitted(
        points=np.concatenate([mesh.points, sunk]),
        hexes=np.concatenate([inner[mesh.hexes], np.concatenate([inner[mesh.quads], mesh.quads], axis=1)]),
        quads=mesh.quads,
        labels=mesh.labels,
        chains=mesh.chains,
    )


def _with_sheet(mesh: Fitted, face: int) -> Fitted:
    """A sheet around the hexahedra with quads on a face, which keep their nodes; the others get copies of them.

    Where it ends on the boundary, at the border of the face, it leaves a row of quads on the faces beside.
    """
    on = mesh.labels == face
    own = mesh.quads[on]
    owners, _ = find_hexes(mesh.hexes, own)
    inside = np.zeros(len(mesh.hexes), dtype=bool)
    inside[owners] = True
    walls = _walls(mesh, inside)
    nodes = np.unique(walls)
    copy = np.arange(len(mesh.points))
    copy[nodes] = len(mesh.points) + np.arange(len(nodes))
    points, copies = _parted(mesh, on, owners, nodes)
    others, labels = mesh.quads[~on], mesh.labels[~on]
    sides = sides_around(others)
    border = {tuple(side) for side in sides_around(own).tolist()}
    beside = np.array([(b, a) in border for a, b in sides.tolist()], dtype=bool)
    a, b = sides[beside].T
    hexes = np.where(inside[:, None], mesh.hexes, copy[mesh.hexes])
    return Fitted(
        points=np.concatenate([points, copies]),
        hexes=np.concatenate([hexes, np.concatenate([walls, copy[walls]], axis=1)]),
        quads=np.concatenate([own, copy[others], np.stack([a, b, copy[b], copy[a]], axis=1)]),
        labels=np.concatenate([mesh.labels[on], labels, np.repeat(labels, 4)[beside]]),
        chains={edge: _stretched(chain, copy, border) for edge, chain in mesh.chains.items()},
    )


def _walls(mesh: Fitted, inside: BoolArray) -> IntArray:
    """Faces (w, 4) between hexahedra that are inside and others, outward from those inside."""
    every = mesh.hexes[:, HEX_FACES].reshape(-1, 4)
    keys = np.sort(every, axis=1)
    order = np.lexsort(keys.T)
    same = (keys[order[1:]] == keys[order[:-1]]).all(axis=1)
    one, other = order[:-1][same], order[1:][same]
    is_in, is_out = inside[one // 6], inside[other // 6]
    found = np.concatenate([one[is_in & ~is_out], other[is_out & ~is_in]])
    return every[np.sort(found)]


def _parted(mesh: Fitted, on: BoolArray, owners: IntArray, nodes: IntArray) -> tuple[FloatArray, FloatArray]:
    """Points for a sheet around a face, and those (k, 3) of the copies of `nodes`: apart enough to tell them.

    Nodes on the border stay, and their copies go into the faces beside; below, the hexahedra of the face make room.
    """
    points = mesh.points.copy()
    copies = points[nodes].copy()
    is_face = np.zeros(len(points), dtype=bool)
    is_face[mesh.quads[on]] = True
    border = is_face[nodes]
    # Below: half of the way towards the skin.
    lines = mesh.hexes[owners][:, HEX_EDGES].reshape(-1, 2)
    above, n = _mean_beyond(mesh.points, lines, ~is_face, is_face)
    below = nodes[~border & (n[nodes] > 0)]
    points[below] = 0.5 * (points[below] + above[below])
    # On the skin: towards what of the faces beside is no border.
    ahead, n = _mean_beyond(mesh.points, sides_around(mesh.quads[~on]), is_face, ~is_face)
    moved = border & (n[nodes] > 0)
    copies[moved] = 0.6 * copies[moved] + 0.4 * ahead[nodes[moved]]
    return points, copies


def _mean_beyond(
    points: FloatArray, lines: IntArray, here: BoolArray, there: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Mean (n, 3) of the places of the other ends of lines (l, 2) from nodes that are here to such that are there."""
    both = np.concatenate([lines, lines[:, ::-1]])
    both = both[here[both[:, 0]] & there[both[:, 1]]]
    total, counts = np.zeros_like(points), np.zeros(len(points))
    np.add.at(total, both[:, 0], points[both[:, 1]])
    np.add.at(counts, both[:, 0], 1.0)
    return total / np.maximum(counts, 1.0)[:, None], counts


def _stretched(chain: IntArray, copy: IntArray, border: set[tuple[int, int]]) -> IntArray:
    """Nodes of an edge: those of the face's own edges stay, one that ends at the face gets a segment more there."""
    a, b = chain[:2].tolist()
    if (a, b) in border or (b, a) in border:
        return chain
    moved = copy[chain]
    first = chain[:1] if moved[0] != chain[0] else chain[:0]
    last = chain[-1:] if moved[-1] != chain[-1] else chain[:0]
    return np.concatenate([first, moved, last])
