"""Which nodes of a stack may move on its faces, for smoothing: on flat caps, on walls, and along their rims.

Place in the flow: after :mod:`.blocks`, where the checks ask for smoothing.

Method: a node of a line is on what of the part claims that line on its level: on one curve, along which it may move, or
on several, where it stays. Nodes on caps that are not flat stay, too.
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from ..stack_mesh import Placed, Slides
from .graph import find_claims
from .places import edge_levels

_FLAT = 1e-9
_SAMPLES = np.linspace(0.0, 1.0, 9)
_NONE, _HELD = -1, -2


def find_slides(stack: Stack, levels: Levels, mesh: QuadMesh, built: Placed) -> Slides:
    """Find the nodes that may move on the part's faces, and how.

    Parameters
    ----------
    stack : Stack
    levels : Levels
    mesh : QuadMesh
    built : StackMesh or StraightStack
        What was made of these.
    """
    level_of, place_of = built.levels, built.places
    n = len(level_of)
    curve = _curves_at(stack, levels, mesh)[level_of, place_of]
    caps = np.isin(built.faces, [*stack.source, *stack.target])
    on_cap, on_wall = np.zeros((2, n), dtype=bool)
    on_cap[built.quads[caps]] = True
    on_wall[built.quads[~caps]] = True
    held = curve == _HELD
    for f in {*stack.source, *stack.target}:
        face = stack.solid.faces[f]
        if face.kind != "plane" or abs(face.normal @ stack.direction) < 1.0 - _FLAT:
            held[built.quads[built.faces == f]] = True
    for e, over in stack.arrangement.over.items():
        for station in set(over) & levels.stations.keys():
            # Nodes of a level would leave a station that leans.
            if np.ptp(stack.solid.edges[station].curve.evaluate(_SAMPLES) @ stack.direction) > _FLAT * stack.solid.size:
                own = level_of == levels.stations[station]
                held |= own & np.isin(place_of, mesh.edge_nodes[e])
    # A wall's node that no curve is known of stays.
    held |= on_wall & (curve == _NONE)
    stations = np.isin(level_of, list(levels.stations.values()))
    mask = (on_cap | on_wall) & ~held
    return Slides(
        mask=mask,
        up=stack.direction,
        rises=mask & ~on_cap & ~stations,
        curve=np.where(curve >= 0, curve, -1),
        curves={int(e): stack.solid.edges[e].curve for e in np.unique(curve[curve >= 0])},
    )


def _curves_at(stack: Stack, levels: Levels, mesh: QuadMesh) -> IntArray:
    """Edge of the part that holds a node on a level (n_layers + 1, n_nodes), or what else does."""
    found = np.full((levels.n_layers + 1, len(mesh.points)), _NONE, dtype=np.int64)
    level_of = edge_levels(stack, levels)
    for e in stack.arrangement.over:
        nodes = mesh.edge_nodes[e]
        claims = stack.arrangement.claims.get(e) or find_claims(stack, e)
        if claims is None:
            found[:, nodes] = _HELD
            continue
        for claim in claims:
            between = slice(level_of[claim.low], level_of[claim.high] + 1)
            found[between, nodes[1:-1]] = claim.edge
            for node, at in ((nodes[0], claim.begin), (nodes[-1], claim.end)):
                known = found[between, node]
                is_other = (known != _NONE) & (known != claim.edge)
                found[between, node] = np.where(is_other | (at in {0.0, 1.0}), _HELD, claim.edge)
    return found
