"""The lattice of a hexahedron of order p: VTK's numbers of its nodes, and nodes that neighbours share.

Nodes stand equispaced at (i, j, k) / p. VTK's order (``vtkLagrangeHexahedron``, files of version 2.1 and later): the
corners, the p - 1 nodes of each edge, the (p - 1)^2 of each face, the (p - 1)^3 inside; edges rise along i, j or k, in
faces and inside the first axis runs fastest. Order 2 is VTK's hexahedron of 27 nodes.

        7--6--6      edges   0: 0-1   1: 1-2   2: 3-2   3: 0-3
       7|    5|              4: 4-5   5: 5-6   6: 7-6   7: 4-7
      4--4--5 |              8: 0-4   9: 1-5  10: 2-6  11: 3-7
      | 3--2|-2      faces   0, 1: i = 0, p;  2, 3: j = 0, p;  4, 5: k = 0, p
      8 3   9 1      quads   corners, edges 0-1, 1-2, 3-2, 0-3, inside
      |/    |/
      0--0--1
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from .arrays import IntArray
from .errors import InputError

MOST = 8
"""Greatest order."""

EDGES = np.array([[0, 1], [1, 2], [3, 2], [0, 3], [4, 5], [5, 6], [7, 6], [4, 7], [0, 4], [1, 5], [2, 6], [3, 7]])
"""Ends of the edges, each along a positive axis."""

FACES = np.array([[0, 3, 4, 7], [1, 2, 5, 6], [0, 1, 4, 5], [3, 2, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]])
"""Corners (0, 0), (1, 0), (0, 1), (1, 1) of the faces in their own two axes."""

_QUAD_EDGES = np.array([[0, 1], [1, 2], [3, 2], [0, 3]])


def order_of(size: int) -> int:
    """Order of a hexahedron by its number of nodes: 1 for 8, 2 for 20 and 27, p for (p + 1)^3; 0 for others."""
    if size == 20:
        return 2
    return next((order for order in range(1, MOST + 1) if (order + 1) ** 3 == size), 0)


def quad_size(size: int) -> int:
    """Nodes of a side of a hexahedron of so many nodes."""
    return 8 if size == 20 else (order_of(size) + 1) ** 2


@cache
def lexicographic(order: int) -> IntArray:
    """VTK's number ((p + 1)^3,) of the node i + (p + 1) j + (p + 1)^2 k."""
    n = order + 1
    grid = np.empty((n, n, n), dtype=np.int64)
    ends = np.array([0, order])
    corners = [(i, j, k) for k in ends for i, j in ((0, 0), (order, 0), (order, order), (0, order))]
    for number, (i, j, k) in enumerate(corners):
        grid[k, j, i] = number
    inner = np.arange(1, order)
    count = 8
    for a, b in EDGES.tolist():
        steps = (np.subtract(corners[b], corners[a]) // order)[:, None] * inner
        i, j, k = np.array(corners[a])[:, None] + steps
        grid[k, j, i] = count + np.arange(order - 1)
        count += order - 1
    square = (order - 1) ** 2
    for a, b, c, _ in FACES.tolist():
        u, v = (np.subtract(corners[other], corners[a]) // order for other in (b, c))
        second, first = (axis.ravel() for axis in np.meshgrid(inner, inner, indexing="ij"))
        i, j, k = np.array(corners[a])[:, None] + u[:, None] * first + v[:, None] * second
        grid[k, j, i] = count + np.arange(square)
        count += square
    grid[1:-1, 1:-1, 1:-1] = count + np.arange(square * (order - 1)).reshape((order - 1,) * 3)
    return grid.ravel()


@cache
def quad_lexicographic(order: int) -> IntArray:
    """Number ((p + 1)^2,) in a quad of the node i + (p + 1) j: as on the side k = 0 of a hexahedron."""
    inner, numbers = order - 1, lexicographic(order)[: (order + 1) ** 2]
    in_face = numbers - (8 + 12 * inner + 4 * inner**2) + 4 + 4 * inner
    return np.where(numbers < 8, numbers, np.where(numbers < 8 + 4 * inner, numbers - 4, in_face))


@dataclass(frozen=True, kw_only=True, eq=False)
class Lattice:
    """Hexahedra of order p on the corners of hexahedra of order 1.

    Attributes
    ----------
    order : int
    hexes : (m, (p + 1)^3) int64
        Corners keep their numbers; then come the nodes of edges, of faces, and those inside.
    edges : (e, 2) int64
        Every edge once, from its lesser corner; its nodes are ``first + (p - 1) e`` and following.
    edge_of : (m, 12) int64
        Rows of `edges`, in the order of :data:`EDGES`.
    faces : (f, 4) int64
        Every face once: its least corner, the lesser one beside it, the other beside it, the one across.
    first : int
        Number of nodes of order 1, which is the first edge's first node.
    """

    order: int
    hexes: IntArray
    edges: IntArray
    edge_of: IntArray
    faces: IntArray
    first: int

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        inner = self.order - 1
        return self.first + len(self.edges) * inner + len(self.faces) * inner**2 + len(self.hexes) * inner**3

    def edge_nodes(self, ends: IntArray) -> IntArray:
        """Nodes (r, p - 1) of edges from their first end to their second, (r, 2)."""
        rows = find_rows(self.edges, np.sort(ends, axis=1), "segment")
        return self.first + _along(rows, ends, self.order)

    def quads(self, corners: IntArray) -> IntArray:
        """Nodes (q, (p + 1)^2) of quads (q, 4), in VTK's order of Lagrange quadrilaterals."""
        sides = self.edge_nodes(corners[:, _QUAD_EDGES].reshape(-1, 2)).reshape(len(corners), 4 * (self.order - 1))
        rows, codes = _canonical(corners[:, [0, 1, 3, 2]])
        faces = find_rows(self.faces, rows, "quad")
        first = self.first + len(self.edges) * (self.order - 1)
        return np.hstack([corners, sides, first + _within(faces, codes, self.order)])


def number_lattice(corners: IntArray, n_nodes: int, order: int) -> Lattice:
    """Number the nodes of order p of hexahedra (m, 8): first `n_nodes` of order 1, then edges, faces, inside."""
    m, inner = len(corners), order - 1
    ends = corners[:, EDGES].reshape(-1, 2)
    edges, edge_of = unique_rows(np.sort(ends, axis=1))
    rows, codes = _canonical(corners[:, FACES].reshape(-1, 4))
    faces, face_of = unique_rows(rows)
    first_face = n_nodes + len(edges) * inner
    first_inner = first_face + len(faces) * inner**2
    hexes = np.hstack(
        [
            corners,
            (n_nodes + _along(edge_of, ends, order)).reshape(m, -1),
            (first_face + _within(face_of, codes, order)).reshape(m, -1),
            first_inner + np.arange(m * inner**3).reshape(m, -1),
        ]
    )
    return Lattice(order=order, hexes=hexes, edges=edges, edge_of=edge_of.reshape(m, 12), faces=faces, first=n_nodes)


def _along(edges: IntArray, ends: IntArray, order: int) -> IntArray:
    """Places (r, p - 1) of the nodes of edges, seen from the first of the ends (r, 2)."""
    steps = np.arange(order - 1)
    return edges[:, None] * (order - 1) + np.where(ends[:, :1] < ends[:, 1:], steps, steps[::-1])


def _canonical(corners: IntArray) -> tuple[IntArray, IntArray]:
    """Corners (r, 4) of faces as both neighbours see them, and how each is turned for that: 0 to 7."""
    rows = np.arange(len(corners))
    origin = corners.argmin(axis=1)
    one, other = corners[rows, origin ^ 1], corners[rows, origin ^ 2]
    turned = one > other
    ordered = np.stack(
        [corners[rows, origin], np.minimum(one, other), np.maximum(one, other), corners[rows, origin ^ 3]], axis=1
    )
    return ordered, origin + 4 * turned


def _within(faces: IntArray, codes: IntArray, order: int) -> IntArray:
    """Places (r, (p - 1)^2) of the nodes of faces, seen as `codes` say."""
    inner = order - 1
    b, a = np.meshgrid(np.arange(inner), np.arange(inner), indexing="ij")
    seen = np.empty((8, inner**2), dtype=np.int64)
    for code in range(8):
        u, v = (inner - 1 - a if code & 1 else a), (inner - 1 - b if code & 2 else b)
        seen[code] = (v + inner * u if code & 4 else u + inner * v).ravel()
    return faces[:, None] * inner**2 + seen[codes]


def unique_rows(rows: IntArray) -> tuple[IntArray, IntArray]:
    """Different rows of node ids, ascending, and for every row its place among them."""
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    new = np.ones(len(rows), dtype=bool)
    np.any(ordered[1:] != ordered[:-1], axis=1, out=new[1:])
    place = np.empty(len(rows), dtype=np.int64)
    place[order] = np.cumsum(new) - 1
    return ordered[new], place


def find_rows(known: IntArray, wanted: IntArray, what: str) -> IntArray:
    """Places of rows among known, ascending rows.

    Raises
    ------
    InputError
        A row is none of them.
    """
    if not len(wanted):
        return np.empty(0, dtype=np.int64)
    base = max(int(known.max(initial=-1)), int(wanted.max())) + 1
    keys, asked = (rows[:, 0] * base + rows[:, 1] for rows in (known, wanted))
    place = np.searchsorted(keys, asked)
    left = np.arange(len(wanted))
    while len(left):  # rows that begin alike stand side by side: a few
        here = place[left]
        if here.max() >= len(known) or (keys[here] != asked[left]).any():
            raise InputError(f"a {what} is none of the mesh")
        left = left[(known[here] != wanted[left]).any(axis=1)]
        place[left] += 1
    return place
