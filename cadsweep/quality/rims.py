"""How far sharp edges of the part lie off the segments that stand for them.

Place in the flow: :mod:`.deviation` asks for it beside what quads sag.

Method: a segment may be near both faces of its edge and far from the edge: where a shallow cap meets a wall at 24
degrees, the rim is off by 2.5 times what the cap is. Around its middle the faces are taken for half planes, and so are
the quads: the greater distance of either edge from the other's half planes is what the boundary is off there.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..brep import Edge, Solid
from ..mesh import SurfaceMesh
from ..segments import segments_by_edge
from ..sweep import Sweep

_TANGENT = 0.02
"""Sine of the angle between two faces below which no edge is seen, and a segment that is off it loses nothing."""


def rim_deviations(sweep: Sweep, surfaces: SurfaceMesh, target_points: FloatArray) -> dict[int, float]:
    """Greatest distance, working units, of each curved edge from its segments, as far as its faces part there.

    Parameters
    ----------
    sweep : Sweep
    surfaces : SurfaceMesh
    target_points : (n, 3) float64
        The source's nodes on the target cap.
    """
    solid, n = sweep.solid, len(surfaces.source.points)
    ring = np.concatenate(surfaces.source.loops)
    place = np.full(n, -1)
    place[ring] = np.arange(len(ring))
    last = len(surfaces.rings) - 1

    def points(ids: np.ndarray) -> FloatArray:
        layer, node = np.divmod(ids, n)
        found: FloatArray = surfaces.rings[layer, place[node]]
        found[layer == 0] = surfaces.source.points[node[layer == 0]]
        found[layer == last] = target_points[node[layer == last]]
        return found

    found = {}
    for e, segments in segments_by_edge(sweep, surfaces).items():
        edge = solid.edges[e]
        if is_rim(edge):
            found[e] = float(off_edge(solid, edge, points(segments[:, 0]), points(segments[:, 1])).max())
    return found


def is_rim(edge: Edge) -> bool:
    """Whether segments may be off an edge at which faces meet at an angle."""
    return edge.kind != "line" and abs(np.sin(edge.dihedral)) > _TANGENT


def off_edge(solid: Solid, edge: Edge, begin: FloatArray, end: FloatArray) -> FloatArray:
    """Distances (m,) of an edge from its segments, from (m, 3) to (m, 3), as far as its faces part there."""
    middles = 0.5 * (begin + end)
    steps = end - begin
    lengths = np.linalg.norm(steps, axis=1)[:, None]
    along = steps / np.where(lengths > 0.0, lengths, 1.0)
    away = edge.curve.evaluate(edge.curve.project(middles)) - middles
    away -= np.einsum("md,md->m", away, along)[:, None] * along
    normals = []
    for face in edge.faces:
        surface = solid.faces[face].surface
        normal = surface.normals(surface.project(middles))
        normal = normal - np.einsum("md,md->m", normal, along)[:, None] * along
        normals.append(normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None])
    convex = 1.0 if edge.dihedral < np.pi else -1.0
    squares = np.einsum("md,md->m", away, away)
    nearest = np.full((2, len(middles)), np.inf)
    for one, other in (normals, normals[::-1]):
        # Where one face leaves the edge for: away from the other's outside on a ridge, towards it in a groove.
        leaves = convex * (np.einsum("md,md->m", one, other)[:, None] * one - other)
        leaves /= np.maximum(np.linalg.norm(leaves, axis=1), 1e-300)[:, None]
        ahead = np.einsum("md,md->m", away, leaves)
        for way, sign in enumerate((1.0, -1.0)):
            within = np.maximum(sign * ahead, 0.0) ** 2
            nearest[way] = np.minimum(nearest[way], squares - np.minimum(within, squares))
    return np.asarray(np.sqrt(nearest.max(axis=0)))
