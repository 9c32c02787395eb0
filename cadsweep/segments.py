"""The segments of a sweep's boundary mesh, and the CAD edges that they lie on.

Foundation: checks ask how far segments are off their edges, and order 2 bends them onto these.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from .arrays import FloatArray, IntArray
from .mesh import SurfaceMesh
from .sweep import Sweep


def segments_by_edge(sweep: Sweep, surfaces: SurfaceMesh) -> dict[int, IntArray]:
    """Segments (s, 2) on each CAD edge of a sweep's boundary; nodes are numbered layer by layer, as on the source."""
    found: dict[int, list[IntArray]] = {}
    for segments, edges in ring_segments(sweep, surfaces):
        # Sorted once, in their order on each edge: a plate with a thousand holes has thousands of edges.
        order = np.argsort(edges, axis=None, kind="stable")
        ids, sizes = np.unique(edges, return_counts=True)
        groups = np.split(segments.reshape(-1, 2)[order], np.cumsum(sizes)[:-1])
        for edge, own in zip(ids.tolist(), groups, strict=True):
            if edge >= 0:
                found.setdefault(edge, []).append(own)
    last = (len(surfaces.rings) - 1) * len(surfaces.source.points)
    for edge, nodes in surfaces.source.edge_nodes.items():
        pairs = np.column_stack([nodes[:-1], nodes[1:]])
        found.setdefault(edge, []).append(pairs)
        if edge in sweep.target_edges and sweep.target_edges[edge][0] in surfaces.target_edge_points:
            found.setdefault(sweep.target_edges[edge][0], []).append(pairs + last)
    return {edge: np.concatenate(pieces) for edge, pieces in found.items()}


def ring_segments(sweep: Sweep, surfaces: SurfaceMesh) -> list[tuple[IntArray, IntArray]]:
    """Segments (layers, b, 2) around the rings and along the sweep, and the CAD edge (layers, b) of each (-1: none)."""
    loops, n = surfaces.source.loops, len(surfaces.source.points)
    n_layers = len(surfaces.rings) - 1
    ring = np.concatenate(loops)
    starts = np.concatenate([[0], np.cumsum([len(loop) for loop in loops])])
    following = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in pairwise(starts)])
    nodes = np.arange(n_layers + 1)[:, None] * n + ring
    edges, vertices = surfaces.node_edges, surfaces.node_vertices
    middles_around = 0.5 * (surfaces.rings + surfaces.rings[:, following])
    middles_along = 0.5 * (surfaces.rings[:-1] + surfaces.rings[1:])
    around = _common_edges(sweep, (edges, vertices), (edges[:, following], vertices[:, following]), middles_around)
    along = _common_edges(sweep, (edges[:-1], vertices[:-1]), (edges[1:], vertices[1:]), middles_along)
    return [
        (np.stack([nodes, nodes[:, following]], axis=-1), around),
        (np.stack([nodes[:-1], nodes[1:]], axis=-1), along),
    ]


def _common_edges(
    sweep: Sweep, first: tuple[IntArray, IntArray], second: tuple[IntArray, IntArray], middles: FloatArray
) -> IntArray:
    """The CAD edge that both ends (edge ids, vertex ids) of mesh segments lie on; -1 where there is none."""
    (edge_a, vertex_a), (edge_b, vertex_b) = first, second
    ends = np.array([[e.start, e.end] for e in sweep.solid.edges], dtype=np.int64).reshape(-1, 2)

    def touches(edge: IntArray, vertex: IntArray) -> np.ndarray:
        return (edge >= 0) & (vertex >= 0) & (ends[np.maximum(edge, 0)] == vertex[..., None]).any(axis=-1)

    plain_a, plain_b = (vertex_a < 0) & (edge_a >= 0), (vertex_b < 0) & (edge_b >= 0)
    common = np.where(plain_a & plain_b & (edge_a == edge_b), edge_a, -1)
    common = np.where(plain_a & touches(edge_a, vertex_b), edge_a, common)
    common = np.where(plain_b & touches(edge_b, vertex_a), edge_b, common)
    # One segment from vertex to vertex: of the edges that join the two, the one it follows.
    joining: dict[tuple[int, int], list[int]] = {}
    for edge in sweep.solid.edges:
        joining.setdefault((min(edge.start, edge.end), max(edge.start, edge.end)), []).append(edge.id)
    for place in np.argwhere((vertex_a >= 0) & (vertex_b >= 0)):
        at = tuple(place)
        pair = sorted((int(vertex_a[at]), int(vertex_b[at])))
        for edge_id in joining.get((pair[0], pair[1]), []):
            edge = sweep.solid.edges[edge_id]
            chord = float(np.linalg.norm(sweep.solid.vertices[edge.end] - sweep.solid.vertices[edge.start]))
            if np.linalg.norm(edge.midpoint - middles[at]) <= 0.75 * max(edge.length, chord):
                common[at] = edge_id
    return common
