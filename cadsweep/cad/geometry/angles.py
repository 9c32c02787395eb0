"""Angles between edges and between faces, and the chaining of edges to loops; numpy alone.

Place in the flow: ``extract`` fills ``Loop.angles`` and ``Edge.dihedral`` from here.

Method: the interior angle at a corner turns, about the outward normal, from the edge that leaves
to the edge that arrives. Where the two tangents coincide the angle is 0 or 2 pi, and chords of
growing length decide.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from ...arrays import FloatArray, IntArray
from ...brep import Loop
from ...sweep import DirectedEdge
from .curves import EdgeCurve

MIDDLE = -1
"""Key of the normal in the middle of the face, beside those of its edges."""

_CUSP = 1e-4
"""Below this angle (radians) between the tangents a corner counts as a cusp."""


def chain_loops(
    directed: Sequence[DirectedEdge],
    ends: Sequence[tuple[int, int]],
    curves: Sequence[EdgeCurve],
    normals: Mapping[int, FloatArray],
    end_tangents: FloatArray,
) -> list[list[DirectedEdge]]:
    """Chain directed edges to closed loops.

    Parameters
    ----------
    directed : sequence of (edge, forward)
        The edges of one wire, material on the left.
    ends : sequence of (int, int)
        Start and end vertex of every edge.
    curves, normals
        Curve of every edge; outward normals of this face at each edge's start, middle and end.
    end_tangents : (n_edges, 2, 3) float64
        At the start and the end of every edge.

    Returns
    -------
    list of loops
        Edges that do not close are returned as loops too; the caller's check of uses finds them.
    """
    leaving: dict[int, list[DirectedEdge]] = {}
    for e, forward in directed:
        leaving.setdefault(ends[e][0 if forward else 1], []).append((e, forward))
    loops = []
    for first in directed:
        start = ends[first[0]][0 if first[1] else 1]
        if first not in leaving.get(start, ()):
            continue
        loop = [first]
        leaving[start].remove(first)
        while True:
            e, forward = loop[-1]
            vertex = ends[e][1 if forward else 0]
            choices = leaving.get(vertex, [])
            if vertex == start or not choices:
                break
            best = choices[0]
            if len(choices) > 1:
                angles = _angles([(loop[-1], choice, normals) for choice in choices], curves, end_tangents)
                best = choices[int(np.argmin(angles))]
            choices.remove(best)
            loop.append(best)
        loops.append(loop)
    return loops


def n_touching(loops: Sequence[Loop], ends: IntArray) -> int:
    """How often the loops of a face touch each other in a vertex: each time joins two, or parts the face once more.

    Parameters
    ----------
    ends : (n_edges, 2) int64
        Start and end vertex of every edge.
    """
    met = Counter(v for loop in loops for v in set(ends[list(loop.edges)].ravel().tolist()))
    return sum(met.values()) - len(met)


def corner_angles(
    loops: Sequence[Sequence[DirectedEdge]],
    curves: Sequence[EdgeCurve],
    normals: Sequence[Mapping[int, FloatArray]],
    end_tangents: FloatArray,
) -> list[tuple[float, ...]]:
    """Interior angles of faces where each edge of a loop begins.

    Parameters
    ----------
    loops : sequence of n loops
    curves : sequence of EdgeCurve
        Of all edges.
    normals : sequence of n mappings
        Outward normals of each loop's face, as for :func:`chain_loops`.
    end_tangents : (n_edges, 2, 3) float64
        At the start and the end of all edges.
    """
    corners = [
        (loop[j - 1], loop[j], frame) for loop, frame in zip(loops, normals, strict=True) for j in range(len(loop))
    ]
    if not corners:
        return [() for _ in loops]
    angles = _angles(corners, curves, end_tangents)
    stops = np.cumsum([0, *map(len, loops)]).tolist()
    return [tuple(angles[a:b]) for a, b in pairwise(stops)]


def _angles(
    corners: Sequence[tuple[DirectedEdge, DirectedEdge, Mapping[int, FloatArray]]],
    curves: Sequence[EdgeCurve],
    end_tangents: FloatArray,
) -> list[float]:
    """Interior angle, in [0, 2 pi], of each pair of successive directed edges of a face with its normals."""
    before = np.array([frame[e][2 if forward else 0] for (e, forward), _, frame in corners])
    after = np.array([frame[e][0 if forward else 2] for _, (e, forward), frame in corners])
    normals = before + after
    for j in np.flatnonzero(np.einsum("md,md->m", before, after) < 0.5).tolist():
        # At an apex the normal is not one: those at the middles of the edges show the face's side.
        (arriving, _), (leaving, _), frame = corners[j]
        normals[j] += frame[arriving][1] + frame[leaving][1] + frame[MIDDLE][0]
    out = np.array([_signed(end_tangents[e, 0 if forward else 1], forward) for _, (e, forward), _ in corners])
    back = np.array([_signed(end_tangents[e, 1 if forward else 0], not forward) for (e, forward), _, _ in corners])
    angles = _turns(out, back, normals).tolist()
    for j, angle in enumerate(angles):
        if not _CUSP < angle < 2 * np.pi - _CUSP:
            angles[j] = _at_cusp(angle, corners[j][0], corners[j][1], curves, normals[j])
    return angles


def _signed(tangent: FloatArray, forward: bool) -> FloatArray:
    return tangent if forward else -tangent


def _at_cusp(
    angle: float, arriving: DirectedEdge, leaving: DirectedEdge, curves: Sequence[EdgeCurve], normal: FloatArray
) -> float:
    """Tell 0 from 2 pi by chords."""
    for share in (1e-3, 1e-2, 1e-1):
        distance = share * min(curves[leaving[0]].length, curves[arriving[0]].length)
        out, back = _chord(leaving, curves, distance, True), _chord(arriving, curves, distance, False)
        chord = float(_turns(out[None], back[None], normal[None])[0])
        if 1e-6 < chord < 2 * np.pi - 1e-6:
            return angle if abs(chord - angle) < np.pi else 2 * np.pi - angle
    return angle


def dihedral_angles(tangents: FloatArray, left_normals: FloatArray, right_normals: FloatArray) -> FloatArray:
    """Interior angles (m,) of the solid across edges, in [0, 2 pi).

    Parameters
    ----------
    tangents : (m, 3) float64
        Unit tangents of the edges; the face of `left_normals` lies on their left seen from outside.
    left_normals, right_normals : (m, 3) float64
        Outward normals of the two faces.
    """
    left = np.cross(left_normals, tangents)
    right = np.cross(tangents, right_normals)
    sine, cosine = -np.einsum("md,md->m", right, left_normals), np.einsum("md,md->m", right, left)
    return np.asarray(np.arctan2(sine, cosine) % (2 * np.pi))


def _turns(out: FloatArray, back: FloatArray, normals: FloatArray) -> FloatArray:
    """Angles (m,) in [0, 2 pi) about the normals (m, 3) from `out` to `back`, each (m, 3)."""
    lengths = np.linalg.norm(normals, axis=1)
    units = normals / np.where(lengths > 0, lengths, 1.0)[:, None]
    sine = np.einsum("md,md->m", np.cross(out, back), units)
    return np.asarray(np.arctan2(sine, np.einsum("md,md->m", out, back)) % (2 * np.pi))


def _chord(edge: DirectedEdge, curves: Sequence[EdgeCurve], distance: float, at_start: bool) -> FloatArray:
    number, forward = edge
    curve = curves[number]
    share = distance / curve.length
    fractions = np.array([0.0, share] if at_start == forward else [1.0, 1.0 - share])
    points = curve.evaluate(fractions)
    chord = points[1] - points[0]
    return chord / max(float(np.linalg.norm(chord)), 1e-300)
