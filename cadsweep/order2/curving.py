"""Where a mesh of order 2 must bend: its boundary segments on CAD edges, its boundary quads on CAD faces.

Place in the flow: ``pipeline`` hands what is found here to :func:`cadsweep.elevate.elevate`, which meets the CAD
model as callables alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.block import FactoredMesh
from ..blocks.finish import NamedFaces, by_face
from ..blocks.joined import JoinedMesh
from ..blocks.naming import name_pieces
from ..brep import Curve, Part, Surface
from ..mesh import SurfaceMesh
from ..sweep import Sweep

Projection = Callable[[FloatArray], FloatArray]


def project_to_edges(part: Part, sweep: Sweep, surfaces: SurfaceMesh) -> list[tuple[IntArray, Projection]]:
    """Mesh segments (s, 2) on each CAD edge, with the projection to its curve, model units."""
    found: dict[int, list[IntArray]] = {}
    for segments, edges in ring_segments(sweep, surfaces):
        for edge in np.unique(edges[edges >= 0]).tolist():
            found.setdefault(edge, []).append(segments[edges == edge])
    last = (len(surfaces.rings) - 1) * len(surfaces.source.points)
    for edge, nodes in surfaces.source.edge_nodes.items():
        pairs = np.column_stack([nodes[:-1], nodes[1:]])
        found.setdefault(edge, []).append(pairs)
        if edge in sweep.target_edges and sweep.target_edges[edge][0] in surfaces.target_edge_points:
            found.setdefault(sweep.target_edges[edge][0], []).append(pairs + last)
    # The last layer of a closed ring is its first.
    n_nodes = last if sweep.closed else last + len(surfaces.source.points)
    return [
        (np.unique(np.sort(np.concatenate(pieces) % n_nodes, axis=1), axis=0), _on_curve(part, sweep, edge))
        for edge, pieces in found.items()
    ]


def project_to_faces(part: Part, sweep: Sweep, factored: FactoredMesh) -> list[tuple[IntArray, Projection]]:
    """Quads (q, 4) of each owner on the boundary, with the projection to the nearest of its faces, model units."""
    faces: dict[tuple[str, ...], list[int]] = {}
    for (face, _), names in name_pieces(sweep).items():
        faces.setdefault(names, []).append(face)
    return [(quads, _on_faces(part, sweep, sorted(set(faces[names])))) for names, quads in factored.owned_quads()]


def curves_of(part: Part, mesh: JoinedMesh) -> list[tuple[IntArray, Projection]]:
    """Mesh segments (s, 2) on each CAD edge of a mesh of several cells, with the projection to its curve."""
    curves = {
        int(key): edge.curve
        for solid in part.solids
        for key, edge in zip(solid.edge_keys, solid.edges, strict=True)
        if edge.kind != "line"
    }
    return [
        (np.column_stack([nodes[:-1], nodes[1:]]), _onto_curve(part, curves[key]))
        for key, nodes in mesh.edge_nodes.items()
        if key in curves
    ]


def surfaces_of(part: Part, mesh: JoinedMesh, names: NamedFaces) -> list[tuple[IntArray, Projection]]:
    """Quads (q, 4) on each face of the model that is not plane, with the projection to its surface."""
    found = []
    for (cell, face), quads in by_face(mesh):
        own = part.solids[cell].faces[face]
        # Of an interface one side is enough; a cut is inside, and its middles are free.
        if own.kind != "plane" and names.of((cell, face)) and names.first.get((cell, face), True):
            found.append((quads, _onto_surfaces(part, [own.surface])))
    return found


def _on_curve(part: Part, sweep: Sweep, edge: int) -> Projection:
    return _onto_curve(part, sweep.solid.edges[edge].curve)


def _onto_curve(part: Part, curve: Curve) -> Projection:
    def project(points: FloatArray) -> FloatArray:
        return part.to_model(curve.evaluate(curve.project((points - part.offset) / part.scale)))

    return project


def _on_faces(part: Part, sweep: Sweep, faces: list[int]) -> Projection:
    return _onto_surfaces(part, [sweep.solid.faces[face].surface for face in faces])


def _onto_surfaces(part: Part, surfaces: Sequence[Surface]) -> Projection:
    def project(points: FloatArray) -> FloatArray:
        places = (points - part.offset) / part.scale
        nearest, best = np.full(len(places), np.inf), places.copy()
        for surface in surfaces:
            feet = surface.evaluate(surface.project(places))
            away = np.linalg.norm(feet - places, axis=1)
            closer = away < nearest
            nearest[closer], best[closer] = away[closer], feet[closer]
        return part.to_model(best)

    return project


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
