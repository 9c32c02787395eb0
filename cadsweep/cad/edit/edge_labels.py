"""Names and keys of edges, found again by place in a solid that was cut open.

Place in the flow: called by :mod:`.rings` and :mod:`.closed`, whose new edges have no history.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve

from ...brep import Edge, Solid
from ..extract.labels import EdgeLabel

_SAME_EDGE = 1e-6
"""Distance, as a share of the part's size, up to which a new edge lies on an old one."""


def find_edge_labels(solid: Solid, shapes: Sequence[Any]) -> list[EdgeLabel]:
    """Label every new edge as the old one that it lies on; edges of a cut lie on none.

    Parameters
    ----------
    solid : Solid
        Before the cut.
    shapes : sequence of TopoDS_Edge
        The new edges.
    """
    # Inner points: at its ends an edge also lies on its neighbours.
    points = np.array([_inner_points(shape) for shape in shapes])
    pieces: dict[str, list[Edge]] = {}
    for edge in solid.edges:
        if edge.key:
            pieces.setdefault(edge.key, []).append(edge)
    labels = [EdgeLabel()] * len(shapes)
    for key, edges in pieces.items():
        # A ring is cut elsewhere than where its closed edges were divided.
        nearest = [edge.curve.evaluate(edge.curve.project(points.reshape(-1, 3))) for edge in edges]
        away = np.min([np.linalg.norm(near - points.reshape(-1, 3), axis=1) for near in nearest], axis=0)
        for j in np.flatnonzero(away.reshape(-1, 2).max(axis=1) < _SAME_EDGE * solid.size):
            labels[j] = EdgeLabel(key, edges[0].names)
    return labels


def _inner_points(shape: Any) -> list[tuple[float, float, float]]:
    curve = BRepAdaptor_Curve(shape)
    first, last = curve.FirstParameter(), curve.LastParameter()
    points = [curve.Value(first + at * (last - first)) for at in (0.3, 0.7)]
    return [(point.X(), point.Y(), point.Z()) for point in points]
