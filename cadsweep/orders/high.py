"""Nodes of hexahedra of order 3 and above.

Place in the flow: :func:`cadsweep.orders.elevate.elevate` hands orders above 2 over.

Method. Corners keep their numbers and places; the others stand equispaced.
1. Nodes of an edge on a CAD curve are those of the chord brought onto the curve, of one on a CAD surface onto the
   surface; other boundary edges stay straight.
2. How far an edge's nodes lie off its chord is carried into the inside: harmonic on the graph whose vertices are the
   mesh edges and whose links, as strong as they are short, join opposite edges of a quad. Rows of thin layers bend with
   their wall. What is alike seen from both ends of an edge and what changes its sign are carried apart, since opposite
   edges may be numbered from opposite ends.
3. Faces, and then hexahedra, are the transfinite (Gordon-Hall) blend of what bounds them; nodes of faces on a CAD
   surface are brought onto it.

References
----------
Gordon, Hall, "Construction of curvilinear co-ordinate systems and applications to mesh generation", Int. J. Numer.
Meth. Eng. 7 (1973).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from ..cells import HEX_FACES
from ..lattice import Lattice, find_rows, lexicographic, number_lattice, unique_rows
from ..mesh import HexMesh

Projection = Callable[[FloatArray], FloatArray]
"""Takes points (m, 3) near a curve or surface and returns points (m, 3) on it."""

OPPOSITE = np.array(
    [[0, 2], [0, 4], [2, 6], [4, 6], [1, 3], [1, 5], [3, 7], [5, 7], [8, 9], [9, 10], [10, 11], [11, 8]]
)
"""Pairs of edges of a hexahedron that lie opposite in one of its faces."""

_CHUNK = 1 << 12


def place_high(
    mesh: HexMesh,
    order: int,
    curves: Sequence[tuple[IntArray, Projection]],
    surfaces: Sequence[tuple[IntArray, Projection]],
) -> tuple[FloatArray, Lattice]:
    """Points (n, 3) and lattice of a mesh of order 1 raised to an order of 3 or more; not checked."""
    lattice = number_lattice(mesh.hexes, mesh.n_nodes, order)
    inner = order - 1
    points = np.empty((lattice.n_nodes, 3))
    points[: lattice.first] = mesh.points
    at = (np.arange(1, order) / order)[:, None]
    start, end = (mesh.points[lattice.edges[:, side]][:, None] for side in (0, 1))
    straight = (1.0 - at) * start + at * end
    bow, fixed = _boundary_bow(mesh, lattice, straight, curves, surfaces)
    lengths = np.linalg.norm(end - start, axis=2)
    # A projection to a plane or a line moves a node by rounding alone: that is no bow to be carried.
    bow[np.linalg.norm(bow, axis=2).max(axis=1) <= 1e-9 * lengths[:, 0]] = 0.0
    if bow.any():
        bow = _carried(bow, fixed, mesh, lattice)
    n_edge_nodes = len(lattice.edges) * inner
    points[lattice.first : lattice.first + n_edge_nodes] = (straight + bow).reshape(-1, 3)
    first_face = lattice.first + n_edge_nodes
    faces = points[first_face : first_face + len(lattice.faces) * inner**2].reshape(-1, inner, inner, 3)
    faces[:] = _face_nodes(points, lattice)
    for quads, project in surfaces:
        ids = distinct(lattice.quads(quads)[:, 4 * order :].ravel())
        points[ids] = project(points[ids])
    _fill_hexes(points, lattice)
    return points, lattice


def _boundary_bow(
    mesh: HexMesh,
    lattice: Lattice,
    straight: FloatArray,
    curves: Sequence[tuple[IntArray, Projection]],
    surfaces: Sequence[tuple[IntArray, Projection]],
) -> tuple[FloatArray, np.ndarray]:
    """How far the nodes (e, p - 1, 3) of the boundary's edges lie from the chords, and which edges those are."""
    bow = np.zeros_like(straight)
    placed = np.zeros(len(bow), dtype=bool)
    for segments, project in curves:
        ids = distinct(find_rows(lattice.edges, np.sort(np.asarray(segments, dtype=np.int64), axis=1), "segment"))
        bow[ids] = project(straight[ids].reshape(-1, 3)).reshape(len(ids), -1, 3) - straight[ids]
        placed[ids] = True
    for quads, project in surfaces:
        ids = distinct(_edges_of(lattice, quads))
        ids = ids[~placed[ids]]
        if len(ids):
            bow[ids] = project(straight[ids].reshape(-1, 3)).reshape(len(ids), -1, 3) - straight[ids]
        placed[ids] = True
    sides = mesh.hexes[:, HEX_FACES].reshape(-1, 4)
    _, of_side = unique_rows(np.sort(sides, axis=1))
    placed[_edges_of(lattice, sides[np.bincount(of_side)[of_side] == 1])] = True
    return bow, placed


def _edges_of(lattice: Lattice, quads: IntArray) -> IntArray:
    ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2), axis=2)
    return find_rows(lattice.edges, ends.reshape(-1, 2), "quad's edge")


def _carried(bow: FloatArray, fixed: np.ndarray, mesh: HexMesh, lattice: Lattice) -> FloatArray:
    """Carry the bow of the fixed edges to the others."""
    free = np.flatnonzero(~fixed)
    if not len(free):
        return bow
    pairs, place = unique_rows(np.sort(lattice.edge_of[:, OPPOSITE].reshape(-1, 2), axis=1))
    # Whether the edges of a hexahedron are numbered along its axis, and so whether two opposite ones agree.
    inner = lattice.order - 1
    along = lattice.hexes[:, 8 : 8 + 12 * inner].reshape(-1, 12, inner)
    rising = along[:, :, 0] < along[:, :, -1]
    agree = np.empty(len(pairs), dtype=bool)
    agree[place] = (rising[:, OPPOSITE[:, 0]] == rising[:, OPPOSITE[:, 1]]).ravel()
    middles = mesh.points[lattice.edges].mean(axis=1)
    apart = np.linalg.norm(middles[pairs[:, 0]] - middles[pairs[:, 1]], axis=1)
    weights = 1.0 / np.maximum(apart, 1e-6 * apart.max())
    result = bow.copy()
    even, odd = 0.5 * (bow + bow[:, ::-1]), 0.5 * (bow - bow[:, ::-1])
    result[free] = _harmonic(pairs, weights, weights, even, free) + _harmonic(
        pairs, weights, np.where(agree, weights, -weights), odd, free
    )
    return result


def _harmonic(pairs: IntArray, weights: FloatArray, links: FloatArray, bow: FloatArray, free: IntArray) -> FloatArray:
    """Values (f, p - 1, 3) of the free edges, each the mean of its neighbours'; signs of the links turn an edge."""
    n = len(bow)
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    matrix = scipy.sparse.coo_array((np.tile(links, 2), (rows, columns)), shape=(n, n)).tocsr()
    sums = np.bincount(rows, weights=np.tile(weights, 2), minlength=n)
    known = bow.reshape(n, -1).copy()
    known[free] = 0.0
    right = matrix[free] @ known
    own = (scipy.sparse.diags_array(sums[free]) - matrix[free][:, free]).tocsr()
    scale = scipy.sparse.diags_array(1.0 / sums[free])
    found = np.zeros_like(right)
    for column in np.flatnonzero(np.abs(right).max(axis=0) > 0.0):
        # A bow that is a little less smooth than harmonic is as good: the iteration may stop early.
        found[:, column] = scipy.sparse.linalg.cg(own, right[:, column], rtol=1e-4, maxiter=2000, M=scale)[0]
    return found.reshape(len(free), *bow.shape[1:])


def _face_nodes(points: FloatArray, lattice: Lattice) -> FloatArray:
    """Nodes (f, p - 1, p - 1, 3) inside every face, blended from its edges; the first axis of the face runs fastest."""
    order, corners = lattice.order, lattice.faces
    grid = np.zeros((len(corners), order + 1, order + 1, 3))
    grid[:, 0, 0], grid[:, 0, -1], grid[:, -1, 0], grid[:, -1, -1] = (points[corners[:, c]] for c in range(4))
    for (row, column), ends in (
        ((0, slice(1, -1)), [0, 1]),
        ((-1, slice(1, -1)), [2, 3]),
        ((slice(1, -1), 0), [0, 2]),
        ((slice(1, -1), -1), [1, 3]),
    ):
        grid[:, row, column] = points[lattice.edge_nodes(corners[:, ends])]
    return _blended(grid, (1, 2))[:, 1:-1, 1:-1]


def _fill_hexes(points: FloatArray, lattice: Lattice) -> None:
    """Place the nodes inside hexahedra, blended from their faces."""
    n = lattice.order + 1
    table = lexicographic(lattice.order)
    inner = table.reshape(n, n, n)[1:-1, 1:-1, 1:-1].ravel()
    for first in range(0, len(lattice.hexes), _CHUNK):
        hexes = lattice.hexes[first : first + _CHUNK]
        points[hexes[:, inner]] = 0.0
        grid = points[hexes[:, table]].reshape(-1, n, n, n, 3)
        points[hexes[:, inner]] = _blended(grid, (1, 2, 3))[:, 1:-1, 1:-1, 1:-1].reshape(len(hexes), -1, 3)


def _blended(grid: FloatArray, axes: tuple[int, ...]) -> FloatArray:
    """The transfinite blend of a grid's boundary; inside the grid is zero: G - (1 - L1)(1 - L2)... G, L linear."""
    rest = grid
    for axis in axes:
        at = np.linspace(0.0, 1.0, grid.shape[axis]).reshape([-1 if a == axis else 1 for a in range(grid.ndim)])
        low, high = np.take(rest, [0], axis=axis), np.take(rest, [-1], axis=axis)
        rest = rest - ((1.0 - at) * low + at * high)
    return grid - rest


__all__ = ["OPPOSITE", "Projection", "place_high"]
