"""Which face and edge of the model every boundary quad and node lies on, of a mesh whose cells were cut from it.

Place in the flow: before a mesh of several cells is carried to another part (:mod:`.template`). Cuts are inside,
and another part may be cut in another way: what the two have in common are the faces and edges of the model.

Method: nodes on an edge of the model are those on its curve, from vertex to vertex along segments of the boundary. The
boundary falls apart along these: every piece is a face, told by the edges around it.

A seam, an edge between two pieces of one face of the input, need not be followed: cuts may have taken that face as one
and divided it elsewhere. Its pieces are one face then, and a vertex that only seams tell from the inside of an edge may
have no node.

Not handled: other faces that were merged for the mesh, so that no nodes follow the edges between them.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ...arrays import FloatArray, IntArray, distinct
from ...brep import Edge, Solid
from ...errors import InputError

CLOSE = 1e-6
"""Part of the solid's size within which a node lies on an edge: cuts by OpenCASCADE leave 1e-7 of it."""

_FOLLOWING = (
    "carry a mesh by a sweep, columns or cells: where the part has one, that is made with "
    "without=['fitted: instead of a poor mesh', 'part: tips bridged after cuts']"
)
"""What a refusal says of edges that a mesh may have left out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class OnModel:
    """A meshed solid of the model.

    Attributes
    ----------
    faces : (q,) int64
        Face of every quad; of pieces that are one face here the first.
    edges : dict of int to int64 array
        Nodes along every edge that is followed, start to end. Where a vertex between two edges has no node, the segment
        over it is of the edge that its middle is on.
    vertices : (v,) int64
        Node on every vertex; -1 where there is none.
    pieces : dict of int to tuple of int
        Of every face in `faces`, the faces of the model that are one here.
    """

    faces: IntArray
    edges: dict[int, IntArray]
    vertices: IntArray
    pieces: dict[int, tuple[int, ...]]


def find_on_model(solid: Solid, points: FloatArray, quads: IntArray) -> OnModel:
    """Find the model's faces and edges under the quads (q, 4) of its whole boundary.

    Raises
    ------
    InputError
        An edge or vertex that is no seam's has no nodes along it.
    """
    return _Finder(solid, points, quads).found()


class _Finder:
    """The solid, its boundary's quads, and where the segments between these are."""

    def __init__(self, solid: Solid, points: FloatArray, quads: IntArray) -> None:
        self.solid, self.points, self.quads = solid, points, quads
        self.nodes = distinct(quads)
        self.width = int(self.nodes.max()) + 1
        sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
        self.segments, of = np.unique(self.keys(sides[:, 0], sides[:, 1]), return_inverse=True)
        self.sides = of.reshape(-1, 4)
        self.vertices = self.on_vertices()
        self.inside = [self.nodes_inside(edge) for edge in solid.edges]

    def keys(self, first: IntArray, second: IntArray) -> IntArray:
        """A number for every segment."""
        return np.minimum(first, second) * self.width + np.maximum(first, second)

    @cached_property
    def known(self) -> set[int]:
        """The segments that there are."""
        return set(self.segments.tolist())

    def found(self) -> OnModel:
        """Edges, and the faces that they part."""
        edges = self.followed()
        for vertex in np.flatnonzero(self.vertices < 0).tolist():
            if sum(edge.id in edges for edge in self.solid.edges if vertex in (edge.start, edge.end)) not in (0, 2):
                raise InputError(f"{self.unlike()}: no node is on one of its corners", try_=_FOLLOWING)
        on_edge = np.full(len(self.segments), -1, dtype=np.int64)
        for edge, chain in edges.items():
            on_edge[np.searchsorted(self.segments, self.keys(chain[:-1], chain[1:]))] = edge
        pieces = faces_parted(self.solid, edges)
        return OnModel(faces=self.faces(on_edge, pieces), edges=edges, vertices=self.vertices, pieces=pieces)

    def allowance(self, gap: float) -> float:
        """How far a node may be off an edge."""
        return CLOSE * self.solid.size + 2.0 * max(gap, self.solid.tolerance)

    def unlike(self) -> str:
        """How every refusal begins."""
        name = self.solid.name or "the part"
        return f"'{name}' was changed to be meshed, so that its mesh cannot be carried to another part"

    def on_vertices(self) -> IntArray:
        """Node on every vertex, or -1."""
        away, nearest = scipy.spatial.cKDTree(self.points[self.nodes]).query(self.solid.vertices)
        allowed = self.allowance(max(edge.gap for edge in self.solid.edges))
        return np.where(away <= allowed, self.nodes[nearest], -1)

    def nodes_inside(self, edge: Edge) -> IntArray:
        """The nodes of an edge in order, vertices left out."""
        allowed = self.allowance(edge.gap)
        points = self.points[self.nodes]
        sample = edge.curve.evaluate(np.linspace(0.0, 1.0, 17))
        reach = allowed + edge.length / 16  # a curve strays from its samples by less than the arc between them
        box = np.all((points > sample.min(axis=0) - reach) & (points < sample.max(axis=0) + reach), axis=1)
        near = self.nodes[box]
        at = np.clip(edge.curve.project(self.points[near]), 0.0, 1.0)
        on = np.linalg.norm(edge.curve.evaluate(at) - self.points[near], axis=1) <= allowed
        inside = on & ~np.isin(near, self.vertices)
        return near[inside][np.argsort(at[inside], kind="stable")]

    def followed(self) -> dict[int, IntArray]:
        """Nodes along every edge, but for seams that nothing follows."""
        found = {}
        for edge in self.solid.edges:
            first, last = self.end(edge, edge.start), self.end(edge, edge.end)
            chain = np.array([*first, *self.inside[edge.id].tolist(), *last], dtype=np.int64)
            if len(chain) > 1 and self.known.issuperset(self.keys(chain[:-1], chain[1:]).tolist()):
                found[edge.id] = chain
            elif not _is_seam(self.solid, edge.id):
                raise InputError(f"{self.unlike()}: no nodes follow its {edge.label()}", try_=_FOLLOWING)
        return found

    def end(self, edge: Edge, vertex: int) -> list[int]:
        """The node at an end of an edge; where there is none, the next one, if the middle between is on this edge."""
        if self.vertices[vertex] >= 0:
            return [int(self.vertices[vertex])]
        if not len(self.inside[edge.id]):
            return []
        last = int(self.inside[edge.id][0 if edge.start == vertex else -1])
        for other in self.solid.edges:
            if other.id == edge.id or vertex not in (other.start, other.end) or not len(self.inside[other.id]):
                continue
            node = int(self.inside[other.id][0 if other.start == vertex else -1])
            if int(self.keys(np.array([last]), np.array([node]))[0]) in self.known:
                at = float(edge.curve.project((self.points[last] + self.points[node])[None] / 2.0)[0])
                # A middle at the vertex itself is nearest to the ends of both.
                return [node] if 0.0 < at < 1.0 or (at in {0.0, 1.0} and edge.id < other.id) else []
        return []

    def faces(self, on_edge: IntArray, pieces: dict[int, tuple[int, ...]]) -> IntArray:
        """Face of every quad; `on_edge` has the edge of every segment."""
        free = on_edge[self.sides] < 0
        owner = np.repeat(np.arange(len(self.quads)), 4).reshape(-1, 4)
        links = scipy.sparse.coo_array(
            (np.ones(int(free.sum())), (owner[free], self.sides[free])), shape=(len(self.quads), len(on_edge))
        ).tocsr()
        n_pieces, piece = scipy.sparse.csgraph.connected_components(links @ links.T, directed=False)
        around: list[set[int]] = [set() for _ in range(n_pieces)]
        for quad, side in np.argwhere(~free).tolist():
            around[piece[quad]].add(int(on_edge[self.sides[quad, side]]))
        followed = set(on_edge.tolist())
        borders = {
            first: {e for face in own for e in self.solid.faces[face].edges if e in followed}
            for first, own in pieces.items()
        }
        faces = np.full(n_pieces, -1, dtype=np.int64)
        for number, edges in enumerate(around):
            candidates = [face for face, border in borders.items() if border == edges]
            faces[number] = self.nearest(candidates, self.quads[piece == number])
        if -1 in faces or len(set(faces.tolist())) != len(faces):
            raise InputError(f"{self.unlike()}: its boundary does not fall apart into its faces")
        return np.asarray(faces[piece])

    def nearest(self, candidates: Sequence[int], quads: IntArray) -> int:
        """Of faces with the same edges, the one that the quads lie on; -1 of none."""
        if len(candidates) < 2:
            return candidates[0] if candidates else -1
        nodes = self.points[distinct(quads)]
        return min(candidates, key=lambda face: float(self.solid.faces[face].surface.distance(nodes).max()))


def _is_seam(solid: Solid, edge: int) -> bool:
    """Whether an edge is between pieces of one face of the input."""
    return len({face.key for face in solid.faces if edge in face.edges}) == 1


def faces_parted(solid: Solid, followed: Container[int]) -> dict[int, tuple[int, ...]]:
    """Faces that no edge parts, by the first of them."""
    of_edge = [[face.id for face in solid.faces if edge.id in face.edges] for edge in solid.edges]
    pairs = [(own[0], own[-1]) for edge, own in enumerate(of_edge) if edge not in followed]
    links = scipy.sparse.coo_array(
        (np.ones(len(pairs)), np.array(pairs, dtype=np.int64).reshape(-1, 2).T), shape=(len(solid.faces),) * 2
    )
    found: dict[int, list[int]] = {}
    for face, number in enumerate(scipy.sparse.csgraph.connected_components(links, directed=False)[1].tolist()):
        found.setdefault(number, []).append(face)
    return {own[0]: tuple(own) for own in found.values()}
