"""Nodes on the inner edges of a target cap of several faces.

Place in the flow: the last step of the surface stage, where recognition found which edge of the
target answers to which of the source.

Method: as on the rings: an edge divides itself as the affine image of the source edge does.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray
from ..mesh import QuadMesh
from ..sweep import Sweep
from .spacing import Fit, divide_like, finer

_N_CHORDS = 16
"""Chords that stand for a curved edge's segment."""


def divide_target_edges(
    sweep: Sweep, source: QuadMesh, fractions: Mapping[int, FloatArray], rings: FloatArray, fit: Fit
) -> dict[int, FloatArray]:
    """Points of the nodes of inner target edges, by target edge id, from its start to its end.

    `fractions` are those of the source's edges.
    """
    on_loops = {edge for loop in sweep.source_loops for edge, _ in loop}
    inner = [e for e in source.edge_nodes if e not in on_loops and e in sweep.target_edges]
    if not inner:
        return {}
    solid = sweep.solid
    linear = fit(rings[0], rings[-1:])[0]
    points: dict[int, FloatArray] = {}
    for e in inner:
        n = len(source.edge_nodes[e]) - 1
        fine = solid.edges[e].curve.evaluate(finer(fractions[e], _N_CHORDS))
        along = divide_like(np.diff(fine, axis=0).reshape(n, _N_CHORDS, 3), linear)
        target, same_direction = sweep.target_edges[e]
        edge = solid.edges[target]
        nodes = np.array(edge.curve.evaluate(along if same_direction else (1.0 - along)[::-1]))
        nodes[0], nodes[-1] = solid.vertices[edge.start], solid.vertices[edge.end]
        points[target] = nodes
    return points
