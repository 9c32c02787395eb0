"""Caps of a refined mesh: their new nodes moved where the quads at a rim have got worse than they must be.

Place in the flow: :mod:`.refinement` comes here with the halved boundary, before the layers are placed.

What happens at a rim. Coarse nodes stay, and new nodes of the rim lie on the curve, so at a coarse node of the rim,
where two segments turn by an angle t, the first and the last segment turn towards the tangent: by t/4 at the first
level, by t/2 in all. The two quads beside the rim take all of that where the new nodes lie in the middles of the
coarse segments; the others at that node keep their angles. Where that makes a cap clearly worse than it was, the new
nodes inside the face move along its surface and share it out; coarse nodes, and all nodes on edges, stay. A quad with
two segments on one smooth curve has nobody to share with: its angle tends to two right ones, and its sine halves with
every level.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..blocks.halves import Halved
from ..brep import Surface
from ..mesh import SurfaceMesh
from ..projection.caps import boundary_loops
from ..projection.target import GOOD_ENOUGH, relaxed_cap, sweep_normals, worst_corner
from ..surface.spacing import fit_linear_parts
from ..sweep import Sweep


def share_out(points: FloatArray, halved: Halved, sweep: Sweep, coarse: SurfaceMesh) -> None:
    """Move new nodes of both caps, in place.

    Parameters
    ----------
    points : (n_layers + 1, n, 3) float64
        All nodes of the fine sweep, working units.
    halved : Halved
    sweep : Sweep
    coarse : SurfaceMesh
        Whose source cap has a face for every quad.
    """
    solid, answers = sweep.solid, dict(sweep.target_faces)
    if len(sweep.source) == len(sweep.target) == 1:
        answers = {sweep.source[0]: sweep.target[0]}
    owners = np.repeat(coarse.source.faces, 4)
    for face in np.unique(owners).tolist():
        quads_here = halved.structure.quads[owners == face]
        nodes, local = np.unique(quads_here, return_inverse=True)
        quads = local.reshape(-1, 4).astype(np.int64)
        own, there = points[0][nodes], points[-1][nodes]
        loops = boundary_loops(quads, own)
        known = np.concatenate(loops)
        surface, beyond = solid.faces[face].surface, solid.faces[answers[face]].surface if face in answers else None
        before = _worst(own, quads, surface)
        old = coarse.source.quads[coarse.source.faces == face]
        wanted = GOOD_ENOUGH * _worst(points[0], old, surface)
        if before >= wanted or beyond is None:
            continue
        kept = np.union1d(known, np.flatnonzero(nodes < halved.n_coarse))
        moved = relaxed_cap(own, own, quads, loops, surface, fixed=kept, wanted=wanted)
        if moved is None or _worst(moved, quads, surface) <= before:
            continue
        free = np.setdiff1d(np.arange(len(nodes)), kept)
        linear = fit_linear_parts(own[known], there[known][None])[0]
        carried = there.copy()
        carried[free] = beyond.evaluate(beyond.project(there[free] + (moved - own)[free] @ linear.T))
        if _worst(carried, quads, beyond) < min(_worst(there, quads, beyond), wanted):
            continue
        points[0][nodes[free]], points[-1][nodes[free]] = moved[free], carried[free]


def _worst(points: FloatArray, quads: IntArray, surface: Surface) -> float:
    return worst_corner(points, quads, sweep_normals(points, quads, surface))
