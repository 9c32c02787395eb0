"""Labels mended where a face has one quad in a wide corner: it would be flat there, or worse, and no sheet helps.

At a vertex where a face turns by more than `_WIDE` it must have two quads. Quads there are given to another face that
is at the vertex, one or all of one face, while the topology stays that of the model: the vertex moves by a cell along
an edge, or the corner gets another quad.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import radians

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Solid
from ..errors import SurfaceMeshError
from .topology import match_topology

_WIDE = radians(150.0)
"""Angle of a face at a vertex from which on it must have two quads there: the sine of it bounds the quality of one."""


def turn_corners(  # noqa: PLR0917
    solid: Solid,
    angles: Mapping[tuple[int, int], float],
    points: FloatArray,
    quads: IntArray,
    labels: IntArray,
    size: float,
) -> tuple[IntArray, dict[int, IntArray]]:
    """Labels (q,) with two quads in every wide corner where that can be had, and the nodes of every edge.

    Parameters
    ----------
    solid : Solid
    angles : mapping of (vertex, face) to float
    points : (n, 3) float64
    quads : (q, 4) int64
    labels : (q,) int64
    size : float

    Raises
    ------
    SurfaceMeshError
        The labels as they are have not the topology of the solid.
    """
    chains = match_topology(solid, points, quads, labels, size)
    wide = [place for place, angle in angles.items() if angle > _WIDE]
    narrow = _narrow(solid, wide, quads, labels, chains)
    for place in list(narrow):
        if place not in narrow:
            continue
        for tried in _changed(_node(solid, place[0], chains), quads, labels):
            try:
                found = match_topology(solid, points, quads, tried, size)
            except SurfaceMeshError:
                continue
            left = _narrow(solid, wide, quads, tried, found)
            if len(left) < len(narrow):
                labels, chains, narrow = tried, found, left
                break
    return labels, chains


def _node(solid: Solid, vertex: int, chains: dict[int, IntArray]) -> int:
    """The node of a vertex, -1 where no edge ends there."""
    for edge, chain in chains.items():
        for end, node in ((solid.edges[edge].start, chain[0]), (solid.edges[edge].end, chain[-1])):
            if end == vertex:
                return int(node)
    return -1


def _narrow(
    solid: Solid, wide: list[tuple[int, int]], quads: IntArray, labels: IntArray, chains: dict[int, IntArray]
) -> dict[tuple[int, int], None]:
    """Vertices and faces with a wide corner of fewer than two quads."""
    nodes = np.array([_node(solid, vertex, chains) for vertex, _ in wide], dtype=np.int64)
    at = np.isin(quads, nodes).any(axis=1)
    near, own = quads[at], labels[at]
    counts = [
        int(((near == node).any(axis=1) & (own == face)).sum()) for node, (_, face) in zip(nodes, wide, strict=True)
    ]
    return {
        place: None for place, node, n in zip(wide, nodes.tolist(), counts, strict=True) if node >= 0 and n < 2
    }


def _changed(node: int, quads: IntArray, labels: IntArray) -> Iterator[IntArray]:
    """Labels with one quad at a node, or all of one face, given to another face that is there."""
    around = np.flatnonzero((quads == node).any(axis=1))
    own = np.unique(labels[around]).tolist()
    single = [around[[j]] for j in range(len(around))]
    every = [around[labels[around] == face] for face in own]
    for chosen in [*single, *(some for some in every if len(some) > 1)]:
        for face in own:
            if face != labels[chosen[0]]:
                tried = labels.copy()
                tried[chosen] = face
                yield tried
