"""How far sharp edges of the part lie off the segments that stand for them.

Place in the flow: ``pipeline`` asks for it beside what quads sag (:mod:`.deviation`).

Method: a segment may be near both faces of its edge and far from the edge: where a shallow cap meets a wall at 24
degrees, the rim is off by 2.5 times what the cap is. Around its middle the faces are taken for half planes, and so are
the quads: the greater distance of either edge from the other's half planes is what the boundary is off there.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Edge, Solid

_TANGENT = 0.02
"""Sine of the angle between two faces below which no edge is seen, and a segment that is off it loses nothing."""


def is_rim(edge: Edge) -> bool:
    """Whether segments may be off an edge at which faces meet at an angle."""
    return edge.kind != "line" and abs(np.sin(edge.dihedral)) > _TANGENT


def off_edges(solid: Solid, segments: Mapping[int, tuple[FloatArray, FloatArray]]) -> dict[int, float]:
    """Greatest distance, working units, of each edge from its segments, as far as its faces part there.

    Parameters
    ----------
    solid : Solid
    segments : mapping of int to two (m, 3) float64
        By edge: where its segments begin and end.
    """
    if not segments:
        return {}
    edges = [solid.edges[e] for e in segments]
    begin, end = (np.concatenate([ends[k] for ends in segments.values()]) for k in (0, 1))
    starts = np.cumsum([0, *(len(ends[0]) for ends in segments.values())])
    middles = 0.5 * (begin + end)
    steps = end - begin
    lengths = np.linalg.norm(steps, axis=1)[:, None]
    along = steps / np.where(lengths > 0.0, lengths, 1.0)
    places = [edge.curve.nearest(middles[a:b]) for edge, (a, b) in zip(edges, pairwise(starts), strict=True)]
    away = np.concatenate(places) - middles
    away -= np.einsum("md,md->m", away, along)[:, None] * along
    of_edge = np.repeat(np.arange(len(edges)), np.diff(starts))
    faces = np.array([edge.faces for edge in edges], dtype=np.int64)[of_edge]
    normals = _normals_beside(solid, faces, middles)
    normals -= np.einsum("kmd,md->km", normals, along)[..., None] * along
    normals /= np.maximum(np.linalg.norm(normals, axis=2), 1e-300)[..., None]
    convex = np.array([1.0 if edge.dihedral < np.pi else -1.0 for edge in edges])[of_edge, None]
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
    worst = np.maximum.reduceat(np.sqrt(nearest.max(axis=0)), starts[:-1])
    return dict(zip(segments, worst.tolist(), strict=True))


def _normals_beside(solid: Solid, faces: IntArray, points: FloatArray) -> FloatArray:
    """Normals (2, m, 3) at the feet of points (m, 3) on both of their faces (m, 2); each face is asked once."""
    normals = np.empty((2, len(points), 3))
    order = np.argsort(faces, axis=None, kind="stable")
    ids, starts = np.unique(faces.ravel()[order], return_index=True)
    for face, own in zip(ids.tolist(), np.split(order, starts[1:]), strict=True):
        which, side = np.divmod(own, 2)
        surface = solid.faces[face].surface
        normals[side, which] = surface.normals(surface.project(points[which]))
    return normals
