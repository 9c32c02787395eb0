"""Where over the plane every node is on every level, after outlines were laid together in it.

Place in the flow: after :mod:`.levels`, before :mod:`.nodes` finds the heights there.

Method: on the levels of a wall, and of an edge between caps, the nodes of its line are on the part's own outline. How
far that is from the line is carried over all other nodes of the level by one harmonic function.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from .graph import find_claims
from .harmonic import carried


def find_places(stack: Stack, levels: Levels, mesh: QuadMesh) -> FloatArray:
    """Find the places of all nodes on all levels.

    Returns
    -------
    (n_layers + 1, n_nodes, 3) float64
        Without their heights; one plane, seen from every level, where no outline was moved. Those that the mesh has
        already, where it was mended.
    """
    if mesh.places is not None:
        return mesh.places
    flat = mesh.points - np.outer(mesh.points @ stack.direction, stack.direction)
    shape = (levels.n_layers + 1, len(flat))
    if not stack.arrangement.claims:
        return np.broadcast_to(flat, (*shape, 3))
    fixed = np.zeros(shape, dtype=bool)
    points = np.repeat(flat[None], shape[0], axis=0)
    level_of = edge_levels(stack, levels)
    across = np.eye(3) - np.outer(stack.direction, stack.direction)
    for e in stack.arrangement.over:
        nodes = mesh.edge_nodes[e]
        own = stack.arrangement.claims.get(e)
        if own:
            fractions = _fractions(flat[nodes])
            for claim in own:
                at = claim.begin + (claim.end - claim.begin) * fractions
                where = stack.solid.edges[claim.edge].curve.evaluate(at) @ across
                between = slice(level_of[claim.low], level_of[claim.high] + 1)
                points[between, nodes] = where
                fixed[between, nodes] = True
            continue
        exact = find_claims(stack, e)
        if exact is None:
            fixed[:, nodes] = True
        for claim in exact or ():
            fixed[level_of[claim.low] : level_of[claim.high] + 1, nodes] = True
    off = points - flat
    for k in range(shape[0]):
        if fixed[k].any() and np.abs(off[k]).max() > 0.0:
            points[k] = flat + carried(off[k], fixed[k], mesh.quads, flat)
    return points


def edge_levels(stack: Stack, levels: Levels) -> dict[int, int]:
    """Level of every edge of the part that bounds a cap or is a station."""
    found = dict(levels.stations)
    for edge in stack.solid.edges:
        for f in edge.faces:
            if f in levels.caps:
                found[edge.id] = levels.caps[f]
    return found


def _fractions(points: FloatArray) -> FloatArray:
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return np.asarray(run / run[-1])
