"""Layers along caps that are walls, kept at their heights between the rails.

Place in the flow: the last step on the sides, where wall layers are asked for at a cap.

Method: rails are divided by heights, and nodes between them stand where their side's parameters have them, which is
not as high: on a bend they are at the mean of the rails' angles, and angles of one height go with one over the radius.
Each node is moved along its column to its height above the cap, and onto its side again; above the layers what they
were moved by fades.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Surface
from ..sweep import Sweep

_STEPS = 3
"""Newton steps to a height; a column is nearly straight over a few of them."""
_LEAST_SLANT = 0.2
"""Sine of the angle between a column and a cap below which nodes stay where they are."""
_MOST = 0.3
"""Part of a layer by which its nodes are moved at most."""


def keep_heights(
    sweep: Sweep, rings: FloatArray, side_faces: IntArray, node_edges: IntArray, heights: Mapping[bool, FloatArray]
) -> None:
    """Move ring nodes inside the sides, in place, to their heights above the caps.

    Parameters
    ----------
    rings : (n_layers + 1, b, 3) float64
    side_faces : (n_layers, b) int64
    node_edges : (n_layers + 1, b) int64
        Edges on which ring nodes lie, -1 inside a face; those on edges stay.
    heights : mapping of bool to (n,) float64
        Of the layers along the source (True) and along the target.
    """
    n_layers = len(side_faces)
    for at_source, wanted in heights.items():
        cap = sweep.source if at_source else sweep.target
        # From the cap on; views, so that what is set here is set in the rings.
        along, edges = (rings, node_edges) if at_source else (rings[::-1], node_edges[::-1])
        faces = np.concatenate([side_faces, side_faces[-1:]] if at_source else [side_faces[::-1], side_faces[:1]])
        surfaces = [sweep.solid.faces[f].surface for f in cap]
        n = len(wanted)
        fade = min(n, n_layers - n - 1)
        shifts = np.zeros(along.shape[1])
        before = along.copy()
        for k in range(1, n + 1 + fade):
            free = np.flatnonzero(edges[k] < 0)
            toward = (
                before[k + 1, free] - before[k - 1, free] if k < n_layers else before[k, free] - before[k - 1, free]
            )
            room = np.linalg.norm(before[k, free] - before[k - 1, free], axis=1)
            toward = toward / np.linalg.norm(toward, axis=1)[:, None]
            if k <= n:
                shifts[:] = 0.0
                shifts[free] = _shift(surfaces, before[k, free], toward, float(wanted[k - 1]))
                shifts[free] = np.clip(shifts[free], -_MOST * room, _MOST * room)
                step = shifts[free]
            else:
                step = shifts[free] * (1.0 - (k - n) / (fade + 1))
            moved = before[k, free] + step[:, None] * toward
            for f in np.unique(faces[k, free]).tolist():
                mine = faces[k, free] == f
                own = sweep.solid.faces[f].surface
                along[k, free[mine]] = own.evaluate(own.project(moved[mine]))


def _shift(surfaces: Sequence[Surface], points: FloatArray, toward: FloatArray, height: float) -> FloatArray:
    """Way (m,) along unit vectors from points (m, 3) to a height above the nearest of some surfaces."""
    way = np.zeros(len(points))
    for _ in range(_STEPS):
        at = points + way[:, None] * toward
        feet = np.stack([surface.evaluate(surface.project(at)) for surface in surfaces])
        away = np.linalg.norm(at - feet, axis=2)
        nearest = away.argmin(axis=0)
        off, foot = away[nearest, np.arange(len(at))], feet[nearest, np.arange(len(at))]
        slant = np.einsum("md,md->m", at - foot, toward) / np.where(off > 0.0, off, 1.0)
        way += np.where(slant > _LEAST_SLANT, (height - off) / np.maximum(slant, _LEAST_SLANT), 0.0)
    return way
