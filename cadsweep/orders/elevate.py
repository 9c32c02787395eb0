"""Meshes of order 2 and above, here of order 2: middles of edges, faces and volumes for a mesh of order 1.

Place in the flow: after ``smoothing``, before the last ``quality``; ``pipeline`` calls :func:`elevate` and hands over
the CAD geometry as callables.

Method. Corners keep their numbers; new nodes follow them: one an edge, then (hex27) one a face and one a hex.
1. The middle of a mesh edge on a CAD curve is put on the curve, of one on a CAD surface on the surface, by the caller's
   projections; other boundary edges stay straight.
2. The bow of an edge (its middle less the straight one) fades into the inside: it is harmonic on the graph whose
   vertices are the mesh edges and whose links join the opposite edges of a quad. Inner edges near a curved side so bend
   with it, and along the sweep the layers' lines bow from one side of a bend to the other.
3. Centres of inner faces, and of hexes, are those of the transfinite (Coons) interpolation of their edges (and faces),
   for which hex20 and hex27 are the same shape inside; centres on a CAD surface are projected.
4. The Jacobian is proven positive inside every hex, or the mesh is refused.

Orders above 2 are :mod:`.high`'s. Not handled: moving the corners.

References
----------
Gordon, Hall, "Construction of curvilinear co-ordinate systems and applications to mesh generation", Int. J. Numer.
Meth. Eng. 7 (1973): transfinite interpolation.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from ..cells import HEX_EDGES, HEX_FACES
from ..errors import InputError, InvertedHexError
from ..lattice import MOST, find_rows, unique_rows
from ..mesh import HexMesh
from ..quality import positive_inside
from .high import OPPOSITE, Projection, place_high

_FACE_NODES = np.array([[0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2], [0, 3, 2, 1], [4, 5, 6, 7]])
"""Corners of the face whose centre is node 20 + j of a hex27."""

_FACE_EDGES = np.array([[8, 7, 11, 3], [1, 10, 5, 9], [0, 9, 4, 8], [11, 6, 10, 2], [3, 2, 1, 0], [4, 5, 6, 7]])
"""Edges of the same faces, as rows of ``HEX_EDGES``."""


def elevate(
    mesh: HexMesh,
    *,
    order: int = 2,
    nodes: int = 20,
    curves: Iterable[tuple[IntArray, Projection]] = (),
    surfaces: Iterable[tuple[IntArray, Projection]] = (),
    allow_inverted: bool = False,
) -> HexMesh:
    """Return the mesh with hexes of order 2 (20 or 27 nodes) or p (``(p + 1) ** 3``), its quads alike.

    Parameters
    ----------
    mesh : HexMesh
        Of order 1.
    order : int
        2 to 8.
    nodes : {20, 27}
        Of a hex of order 2.
    curves : iterable of (segments (s, 2) int64, projection)
        Mesh edges that lie on a CAD edge, as pairs of nodes in any order, and the projection to that edge's curve.
    surfaces : iterable of (quads (q, 4) int64, projection)
        Quads that lie on a CAD face, and the projection to that face's surface. Where a mesh edge lies on several
        surfaces and no curve, the first one counts.
    allow_inverted : bool
        Return a mesh with hexes that are not valid, instead of raising.

    Returns
    -------
    HexMesh
        Its first ``mesh.n_nodes`` points are those of `mesh`, bit for bit.

    Raises
    ------
    InputError
        The mesh is not of order 1, `order` or `nodes` is none of those above, or a segment or quad is none of the mesh.
    InvertedHexError
        The Jacobian of a hex is not positive everywhere; names the hexes.
    """
    if not 2 <= order <= MOST:
        raise InputError(f"the order of a raised mesh is 2 to {MOST}, not {order!r}")
    if order > 2:
        _check_plain(mesh)
        known = [(np.asarray(quads, dtype=np.int64), project) for quads, project in surfaces]
        stacked, lattice = place_high(mesh, order, list(curves), known)
        hexes, raised = lattice.hexes, lattice.quads
    else:
        stacked, hexes, edges, faces = place_lattice(mesh, nodes=nodes, curves=curves, surfaces=surfaces)
        n = mesh.n_nodes
        raised = partial(_elevated_quads, edges=edges, n=n, faces=faces, first_face=n + len(edges))
    positive, _ = positive_inside(stacked, hexes)
    if not positive.all() and not allow_inverted:
        worst = np.flatnonzero(~positive)
        x, y, z = mesh.points[mesh.hexes[worst[0]]].mean(axis=0)
        raise InvertedHexError(
            f"{len(worst)} hexes of order {order} have a Jacobian that is not positive inside, the first is hex "
            f"{worst[0]} at ({x:.6g}, {y:.6g}, {z:.6g}): "
            "the curved boundary is too coarsely meshed; try a smaller size or order=1",
            hexes=worst[:10].tolist(),
        )
    boundaries, interfaces = (
        {name: raised(quads) for name, quads in named.items()} for named in (mesh.boundaries, mesh.interfaces)
    )
    return replace(mesh, points=stacked, hexes=hexes, boundaries=boundaries, interfaces=interfaces, structure=None)


def _check_plain(mesh: HexMesh) -> None:
    if mesh.hexes.shape[1] != 8:
        raise InputError(f"the mesh is of order {mesh.order} already")


def place_lattice(
    mesh: HexMesh,
    *,
    nodes: int,
    curves: Iterable[tuple[IntArray, Projection]],
    surfaces: Iterable[tuple[IntArray, Projection]],
) -> tuple[FloatArray, IntArray, IntArray, IntArray | None]:
    """Points, hexes (m, `nodes`), edges (e, 2) and faces (f, 4; of 27 nodes alone) of :func:`elevate`, not checked."""
    _check_plain(mesh)
    if nodes not in {20, 27}:
        raise InputError(f"a hex of order 2 has 20 or 27 nodes, not {nodes!r}")
    n = mesh.n_nodes
    corners = mesh.hexes
    edges, edge_of = unique_rows(np.sort(corners[:, HEX_EDGES], axis=2).reshape(-1, 2))
    edge_of = edge_of.reshape(-1, 12)
    straight = 0.5 * (mesh.points[edges[:, 0]] + mesh.points[edges[:, 1]])
    surfaces = [(np.asarray(quads, dtype=np.int64), project) for quads, project in surfaces]
    bow, fixed = _boundary_bow(mesh, edges, straight, list(curves), surfaces)
    # A projection to a plane or a line moves a middle by rounding alone: that is no bow to be faded.
    lengths = np.linalg.norm(mesh.points[edges[:, 1]] - mesh.points[edges[:, 0]], axis=1)
    straight_enough = np.linalg.norm(bow, axis=1) <= 1e-9 * lengths
    if not straight_enough.all():
        bow = _faded(bow, fixed, edge_of)
    middles = straight + bow
    points = [mesh.points, middles]
    columns = [corners, n + edge_of]
    faces: IntArray | None = None
    if nodes == 27:
        first_face = n + len(edges)
        faces, face_of = unique_rows(np.sort(corners[:, _FACE_NODES], axis=2).reshape(-1, 4))
        centres = _face_centres(mesh.points, middles, corners, edge_of, face_of)
        for quads, project in surfaces:
            ids = find_rows(faces, np.sort(quads, axis=1), "quad")
            centres[ids] = project(centres[ids])
        face_of = face_of.reshape(-1, 6)
        volume = (
            centres[face_of].sum(axis=1) / 2 - middles[edge_of].sum(axis=1) / 4 + mesh.points[corners].sum(axis=1) / 8
        )
        points += [centres, volume]
        columns += [first_face + face_of, first_face + len(faces) + np.arange(len(corners))[:, None]]
    hexes = np.hstack(columns)
    stacked = np.concatenate(points)
    return stacked, hexes, edges, faces


def _boundary_bow(
    mesh: HexMesh,
    edges: IntArray,
    straight: FloatArray,
    curves: list[tuple[IntArray, Projection]],
    surfaces: list[tuple[IntArray, Projection]],
) -> tuple[FloatArray, np.ndarray]:
    """How far the middles of the boundary's edges lie from the straight ones, and which edges those are."""
    bow = np.zeros_like(straight)
    placed = np.zeros(len(edges), dtype=bool)
    for segments, project in curves:
        ids = find_rows(edges, np.sort(np.asarray(segments, dtype=np.int64), axis=1), "segment")
        bow[ids] = project(straight[ids]) - straight[ids]
        placed[ids] = True
    for quads, project in surfaces:
        ids = distinct(find_rows(edges, _quad_edges(quads).reshape(-1, 2), "quad's edge"))
        ids = ids[~placed[ids]]
        if len(ids):
            bow[ids] = project(straight[ids]) - straight[ids]
        placed[ids] = True
    sides = mesh.hexes[:, HEX_FACES].reshape(-1, 4)
    faces, of_side = unique_rows(np.sort(sides, axis=1))
    outer = sides[np.bincount(of_side, minlength=len(faces))[of_side] == 1]
    placed[find_rows(edges, _quad_edges(outer).reshape(-1, 2), "quad's edge")] = True
    return bow, placed


def _faded(bow: FloatArray, fixed: np.ndarray, edge_of: IntArray) -> FloatArray:
    """Carry the bow of the fixed edges harmonically to the others, over opposite edges of quads."""
    free = np.flatnonzero(~fixed)
    if len(free) == 0:
        return bow
    pairs, _ = unique_rows(np.sort(edge_of[:, OPPOSITE].reshape(-1, 2), axis=1))
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    links = scipy.sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(bow), len(bow))).tocsr()
    laplacian = (scipy.sparse.diags_array(np.asarray(links.sum(axis=1)).ravel()) - links).tocsr()
    right = -(laplacian[free][:, np.flatnonzero(fixed)] @ bow[fixed])
    matrix = laplacian[free][:, free]
    scale = scipy.sparse.diags_array(1.0 / matrix.diagonal())
    result = bow.copy()
    for axis in range(3):
        # A bow that is a little less smooth than harmonic is as good: the iteration may stop early.
        result[free, axis] = scipy.sparse.linalg.cg(matrix, right[:, axis], rtol=1e-4, maxiter=2000, M=scale)[0]
    return result


def _face_centres(
    points: FloatArray, middles: FloatArray, corners: IntArray, edge_of: IntArray, face_of: IntArray
) -> FloatArray:
    """Centres of the Coons patches of the faces' edges: half the middles' sum less a quarter of the corners'."""
    values = middles[edge_of[:, _FACE_EDGES]].sum(axis=2) / 2 - points[corners[:, _FACE_NODES]].sum(axis=2) / 4
    centres = np.empty((int(np.max(face_of)) + 1, 3))
    centres[face_of] = values.reshape(-1, 3)
    return centres


def _elevated_quads(quads: IntArray, edges: IntArray, n: int, faces: IntArray | None, *, first_face: int) -> IntArray:
    sides = _quad_edges(quads).reshape(-1, 2)
    columns = [quads, n + find_rows(edges, sides, "boundary edge").reshape(-1, 4)]
    if faces is not None:
        columns.append(first_face + find_rows(faces, np.sort(quads, axis=1), "boundary quad")[:, None])
    return np.hstack(columns)


def _quad_edges(quads: IntArray) -> IntArray:
    """Edges 0-1, 1-2, 2-3, 3-0 of quads (q, 4), each with its lesser node first: (q, 4, 2)."""
    return np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2), axis=2)
