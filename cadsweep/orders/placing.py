"""Nodes of hexahedra of order 2 and above: on the CAD model's edges and faces, and inside by what bounds it.

Place in the flow: :func:`cadsweep.orders.elevate.elevate` raises whole meshes by it, refinement takes its new nodes
from order 2. What lies on which edge or face is told by the caller (:mod:`cadsweep.entity`).

Method. Corners keep their numbers and places; the others stand equispaced, placed by rising dimension.
1. Nodes of a mesh edge on a CAD edge are those of the chord brought onto its curve. An edge between two CAD faces, on
   no known curve, is brought onto the first of these; one beside quads that are on no known face stays straight.
2. How far nodes lie off their chords is carried over each CAD face, a plane one too: the rows around a bore bend with
   it in its caps as they do below. Those of a curved face are then brought onto it.
3. From the faces it is carried into the inside likewise.
4. Faces, and then hexahedra, are the transfinite (Gordon-Hall) blend of what bounds them; nodes inside quads of a
   curved CAD face are brought onto it.

Carried means: harmonic on the graph whose vertices are the mesh edges and whose links, as strong as they are short,
join opposite edges of a quad. Rows of thin layers so bend with their wall. What is alike seen from both ends of an edge
and what changes its sign are carried apart, since opposite edges may be numbered from opposite ends.

References
----------
Gordon, Hall, "Construction of curvilinear co-ordinate systems and applications to mesh generation", Int. J. Numer.
Meth. Eng. 7 (1973).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import scipy

from ..arrays import BoolArray, FloatArray, IntArray, distinct
from ..cells import HEX_FACES
from ..errors import InputError
from ..lattice import Lattice, find_rows, lexicographic, number_lattice, unique_rows
from ..mesh import HexMesh

Projection = Callable[[FloatArray], FloatArray]
"""Takes points (m, 3) near a curve or surface and returns points (m, 3) on it."""

OnCad = Sequence[tuple[IntArray, Projection | None]]
"""Segments (s, 2) of CAD edges, or quads (q, 4) of CAD faces; None: straight or plane, where nodes are on it anyway."""

_CHUNK = 1 << 12


def place(mesh: HexMesh, order: int, *, curves: OnCad, surfaces: OnCad) -> tuple[FloatArray, Lattice]:
    """Points (n, 3) and lattice of a mesh of order 1 raised to order 2 or more; not checked.

    Raises
    ------
    InputError
        The mesh is not of order 1, or a segment or quad is none of the mesh.
    """
    if mesh.hexes.shape[1] != 8:
        raise InputError(f"the mesh is of order {mesh.order} already")
    lattice = number_lattice(mesh.hexes, mesh.n_nodes, order)
    inner = order - 1
    points = np.empty((lattice.n_nodes, 3))
    points[: lattice.first] = mesh.points
    at = (np.arange(1, order) / order)[:, None]
    start, end = (mesh.points[lattice.edges[:, side]][:, None] for side in (0, 1))
    straight = (1.0 - at) * start + at * end
    bow = _bow(mesh, lattice, straight, curves, surfaces)
    n_edge_nodes = len(lattice.edges) * inner
    points[lattice.first : lattice.first + n_edge_nodes] = (straight + bow).reshape(-1, 3)
    first_face = lattice.first + n_edge_nodes
    middles = points[first_face : first_face + len(lattice.faces) * inner**2].reshape(-1, inner, inner, 3)
    middles[:] = _face_nodes(points, lattice)
    for quads, project in surfaces:
        if project is not None:
            ids = distinct(lattice.quads(quads)[:, 4 * order :].ravel())
            points[ids] = project(points[ids])
    fill_hexes(points, lattice)
    return points, lattice


def _bow(mesh: HexMesh, lattice: Lattice, straight: FloatArray, curves: OnCad, surfaces: OnCad) -> FloatArray:
    """How far the nodes (e, p - 1, 3) of all edges lie from their chords."""
    bow = np.zeros_like(straight)
    lengths = np.linalg.norm(mesh.points[lattice.edges[:, 1]] - mesh.points[lattice.edges[:, 0]], axis=1)
    fixed = np.zeros(len(bow), dtype=bool)

    def bring(ids: IntArray, project: Projection | None) -> None:
        ids = distinct(ids.ravel())
        fixed[ids] = True
        if project is not None and len(ids):
            own = project((straight[ids] + bow[ids]).reshape(-1, 3)).reshape(bow[ids].shape) - straight[ids]
            # A projection to a plane or a line moves a node by rounding alone: that is no bow to be carried.
            own[np.linalg.norm(own, axis=2).max(axis=1) <= 1e-9 * lengths[ids]] = 0.0
            bow[ids] = own

    for segments, project in curves:
        bring(find_rows(lattice.edges, np.sort(segments, axis=1), "segment"), project)
    of_face = [_edges_of(lattice, quads) for quads, _ in surfaces]
    untold = _edges_of(lattice, skin_without(mesh.hexes, [quads for quads, _ in surfaces]))
    n_faces = np.zeros(len(bow), dtype=np.int64)
    for own in of_face:
        n_faces[distinct(own.ravel())] += 1
    n_faces[untold] = 2
    for own, (_, project) in zip(of_face, surfaces, strict=True):
        bring(own[(n_faces[own] > 1) & ~fixed[own]], project)
    fixed[untold] = True
    if not bow.any() and all(project is None for _, project in surfaces):
        return bow
    on_cad = np.concatenate([np.empty((0, 4), dtype=np.int64), *(quads for quads, _ in surfaces)])
    bow = _carried(bow, fixed, on_cad, mesh.points, lattice)
    for own, (_, project) in zip(of_face, surfaces, strict=True):
        bring(own[~fixed[own]], project)
    return _carried(bow, fixed, lattice.faces[:, [0, 1, 3, 2]], mesh.points, lattice) if bow.any() else bow


def skin_without(hexes: IntArray, told: Sequence[IntArray]) -> IntArray:
    """Sides (s, 4) of hexahedra (m, 8) that have no neighbour and are none of the quads that were told of."""
    sides = hexes[:, HEX_FACES].reshape(-1, 4)
    _, place = unique_rows(np.sort(np.concatenate([sides, *told]), axis=1))
    # Of an interface one side is told of: its two hexahedra and the quad make three.
    return sides[(np.bincount(place) == 1)[place[: len(sides)]]]


def _edges_of(lattice: Lattice, quads: IntArray) -> IntArray:
    """Rows (q, 4) of the edges 0-1, 1-2, 2-3 and 3-0 of quads."""
    ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2), axis=2)
    return find_rows(lattice.edges, ends.reshape(-1, 2), "quad's edge").reshape(-1, 4)


def _carried(bow: FloatArray, fixed: BoolArray, quads: IntArray, points: FloatArray, lattice: Lattice) -> FloatArray:
    """Carry the bow of the fixed edges to the others of the quads."""
    edges = _edges_of(lattice, quads)
    free = distinct(edges[~fixed[edges]])
    if not len(free):
        return bow
    pairs = edges[:, [[0, 2], [1, 3]]].reshape(-1, 2)
    # Whether two opposite edges, each numbered from its lesser node, are numbered the same way.
    rising = quads < np.roll(quads, -1, axis=1)
    agree = (rising[:, :2] != rising[:, 2:]).ravel()
    middles = points[lattice.edges].mean(axis=1)
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
    rtol = 10.0 ** -min(2 * (bow.shape[1] + 1), 12)
    for column in np.flatnonzero(np.abs(right).max(axis=0) > 0.0):
        # A bow a little less smooth than harmonic is as good, as long as elements of the order do not see it: with 1e-4
        # the error of Poisson's equation stopped falling at order 6 (scripts/solve_orders.py).
        found[:, column] = scipy.sparse.linalg.cg(own, right[:, column], rtol=rtol, maxiter=5000, M=scale)[0]
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


def fill_hexes(points: FloatArray, lattice: Lattice) -> None:
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
