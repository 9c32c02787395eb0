"""Angles between edges and between faces, and the chaining of edges to loops; numpy alone.

Place in the flow: ``extract`` fills ``Loop.angles`` and ``Edge.dihedral`` from here.

Method: the interior angle at a corner turns, about the outward normal, from the edge that leaves
to the edge that arrives. Where the two tangents coincide the angle is 0 or 2 pi, and chords of
growing length decide.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...arrays import FloatArray
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
                best = min(choices, key=lambda c: corner_angle(loop[-1], c, curves, normals))
            choices.remove(best)
            loop.append(best)
        loops.append(loop)
    return loops


def corner_angles(
    loop: Sequence[DirectedEdge], curves: Sequence[EdgeCurve], normals: Mapping[int, FloatArray]
) -> tuple[float, ...]:
    """Interior angle of the face where each edge of the loop begins."""
    return tuple(corner_angle(loop[j - 1], loop[j], curves, normals) for j in range(len(loop)))


def corner_angle(
    arriving: DirectedEdge,
    leaving: DirectedEdge,
    curves: Sequence[EdgeCurve],
    normals: Mapping[int, FloatArray],
) -> float:
    """Interior angle, in [0, 2 pi], between two successive directed edges of a face."""
    ends = normals[arriving[0]][2 if arriving[1] else 0], normals[leaving[0]][0 if leaving[1] else 2]
    normal = ends[0] + ends[1]
    if ends[0] @ ends[1] < 0.5:
        # At an apex the normal is not one: those at the middles of the edges show the face's side.
        normal = normal + normals[arriving[0]][1] + normals[leaving[0]][1] + normals[MIDDLE][0]
    out = _direction(leaving, curves, at_start=True)
    back = -_direction(arriving, curves, at_start=False)
    angle = _turn(out, back, normal)
    if _CUSP < angle < 2 * np.pi - _CUSP:
        return angle
    for share in (1e-3, 1e-2, 1e-1):
        distance = share * min(curves[leaving[0]].length, curves[arriving[0]].length)
        chord = _turn(_chord(leaving, curves, distance, True), _chord(arriving, curves, distance, False), normal)
        if 1e-6 < chord < 2 * np.pi - 1e-6:
            return angle if abs(chord - angle) < np.pi else 2 * np.pi - angle
    return angle


def dihedral_angle(tangent: FloatArray, left_normal: FloatArray, right_normal: FloatArray) -> float:
    """Interior angle of the solid across an edge, in [0, 2 pi).

    Parameters
    ----------
    tangent : (3,) float64
        Unit tangent of the edge; the face of `left_normal` lies on its left seen from outside.
    left_normal, right_normal : (3,) float64
        Outward normals of the two faces.
    """
    left = _cross(left_normal, tangent)
    right = _cross(tangent, right_normal)
    return float(np.arctan2(-right @ left_normal, right @ left) % (2 * np.pi))


def _turn(out: FloatArray, back: FloatArray, normal: FloatArray) -> float:
    length = np.linalg.norm(normal)
    normal = normal / (length if length > 0 else 1.0)
    return float(np.arctan2(_cross(out, back) @ normal, out @ back) % (2 * np.pi))


def _direction(edge: DirectedEdge, curves: Sequence[EdgeCurve], *, at_start: bool) -> FloatArray:
    number, forward = edge
    tangent = curves[number].end_tangents[0 if at_start == forward else 1]
    return tangent if forward else -tangent


def _chord(edge: DirectedEdge, curves: Sequence[EdgeCurve], distance: float, at_start: bool) -> FloatArray:
    number, forward = edge
    curve = curves[number]
    share = distance / curve.length
    fractions = np.array([0.0, share] if at_start == forward else [1.0, 1.0 - share])
    points = curve.evaluate(fractions)
    chord = points[1] - points[0]
    return chord / max(float(np.linalg.norm(chord)), 1e-300)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    # numpy's own takes ten times as long for a single pair.
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
