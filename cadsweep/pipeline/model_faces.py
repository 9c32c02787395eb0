"""Which face and edge of the model every boundary quad and node lies on, of a mesh whose cells were cut from it.

Place in the flow: before a mesh of several cells is carried to another part (:mod:`.cells_template`). Cuts are inside,
and another part may be cut in another way: what the two have in common are the faces and edges of the model.

Method: nodes on an edge of the model are those on its curve, from vertex to vertex along segments of the boundary. The
boundary falls apart along these: every piece is a face, told by the edges around it.

Not handled: faces that were merged for the mesh, so that no nodes follow the edges between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from ..brep import Solid
from ..errors import InputError

CLOSE = 1e-6
"""Part of the solid's size within which a node lies on an edge: cuts by OpenCASCADE leave 1e-7 of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OnModel:
    """A meshed solid of the model.

    Attributes
    ----------
    faces : (q,) int64
        Face of every quad.
    edges : tuple of int64 arrays
        Nodes along every edge, start to end.
    vertices : (v,) int64
        Node on every vertex.
    """

    faces: IntArray
    edges: tuple[IntArray, ...]
    vertices: IntArray


def find_on_model(solid: Solid, points: FloatArray, quads: IntArray) -> OnModel:
    """Find the model's faces and edges under the quads (q, 4) of its whole boundary.

    Raises
    ------
    InputError
        An edge or vertex has no nodes along it.
    """
    nodes = distinct(quads)
    segments = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    width = int(nodes.max()) + 1
    keys = segments[:, 0] * width + segments[:, 1]
    unique, of = np.unique(keys, return_inverse=True)
    vertices = _nodes_on_vertices(solid, points, nodes)
    edges = tuple(_nodes_on_edge(solid, e, points, nodes, vertices) for e in range(len(solid.edges)))
    for edge, chain in enumerate(edges):
        if not np.isin(_keys(chain, width), unique).all():
            raise InputError(f"{_unlike(solid)}: no nodes follow its {solid.edges[edge].label()}")
    on_edge = np.full(len(unique), -1, dtype=np.int64)
    for edge, chain in enumerate(edges):
        on_edge[np.searchsorted(unique, _keys(chain, width))] = edge
    return OnModel(faces=_faces(solid, points, quads, of.reshape(-1, 4), on_edge), edges=edges, vertices=vertices)


def _keys(chain: IntArray, width: int) -> IntArray:
    return np.minimum(chain[:-1], chain[1:]) * width + np.maximum(chain[:-1], chain[1:])


def _allowance(solid: Solid, gap: float) -> float:
    return CLOSE * solid.size + 2.0 * max(gap, solid.tolerance)


def _nodes_on_vertices(solid: Solid, points: FloatArray, nodes: IntArray) -> IntArray:
    away, nearest = scipy.spatial.cKDTree(points[nodes]).query(solid.vertices)
    if (away > _allowance(solid, max(edge.gap for edge in solid.edges))).any():
        raise InputError(f"{_unlike(solid)}: no node is on one of its corners")
    return nodes[nearest]


def _unlike(solid: Solid) -> str:
    return f"'{solid.name or 'the part'}' was changed to be meshed, so that its mesh cannot be carried to another part"


def _nodes_on_edge(solid: Solid, e: int, points: FloatArray, nodes: IntArray, vertices: IntArray) -> IntArray:
    """The nodes of an edge in order."""
    edge = solid.edges[e]
    allowed = _allowance(solid, edge.gap)
    sample = edge.curve.evaluate(np.linspace(0.0, 1.0, 17))
    reach = allowed + edge.length / 16  # a curve strays from its samples by less than the arc between them
    box = np.all((points[nodes] > sample.min(axis=0) - reach) & (points[nodes] < sample.max(axis=0) + reach), axis=1)
    near = nodes[box]
    at = np.clip(edge.curve.project(points[near]), 0.0, 1.0)
    on = np.linalg.norm(edge.curve.evaluate(at) - points[near], axis=1) <= allowed
    ends = vertices[[edge.start, edge.end]]
    inside = on & ~np.isin(near, vertices)
    return np.concatenate([ends[:1], near[inside][np.argsort(at[inside], kind="stable")], ends[1:]])


def _faces(solid: Solid, points: FloatArray, quads: IntArray, sides: IntArray, on_edge: IntArray) -> IntArray:
    """Face of every quad; `sides` (q, 4) numbers the segments around it, `on_edge` has the edge of every segment."""
    free = on_edge[sides] < 0
    owner = np.repeat(np.arange(len(quads)), 4).reshape(-1, 4)
    links = scipy.sparse.coo_array(
        (np.ones(int(free.sum())), (owner[free], sides[free])), shape=(len(quads), len(on_edge))
    ).tocsr()
    n_pieces, piece = scipy.sparse.csgraph.connected_components(links @ links.T, directed=False)
    around: list[set[int]] = [set() for _ in range(n_pieces)]
    for quad, side in np.argwhere(~free).tolist():
        around[piece[quad]].add(int(on_edge[sides[quad, side]]))
    faces = np.full(n_pieces, -1, dtype=np.int64)
    borders = [frozenset(face.edges) for face in solid.faces]
    for number, edges in enumerate(around):
        candidates = [face for face, border in enumerate(borders) if border == edges]
        faces[number] = _nearest(solid, candidates, points, quads[piece == number])
    if len(set(faces.tolist())) != len(faces):
        raise InputError(f"{_unlike(solid)}: its boundary does not fall apart into its faces")
    return np.asarray(faces[piece])


def _nearest(solid: Solid, candidates: Sequence[int], points: FloatArray, quads: IntArray) -> int:
    """Of faces with the same edges, the one that the quads lie on."""
    if not candidates:
        raise InputError(f"{_unlike(solid)}: its boundary does not fall apart into its faces")
    if len(candidates) == 1:
        return candidates[0]
    nodes = points[distinct(quads)]
    return min(candidates, key=lambda face: float(solid.faces[face].surface.distance(nodes).max()))
