"""Walls that are bent: two roundings one thickness apart, which replace no edge.

Place in the flow: :mod:`.finding` leaves them out.

Method: seen from the borders of the one along its normals, into the solid, lie the borders of the other, at one
distance all along.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..brep import Solid
from .springs import Side

_ACROSS = 0.999
"""Cosine of the angle to the normal, at least, under which the other border is seen."""
_EVEN = 0.02
"""How much the thickness may vary, as a share of itself."""
_MOST = 0.75
"""Share of a border that must have the other one behind it: holes and notches may take some."""


def bent_walls(solid: Solid, roundings: Sequence[tuple[bool, Sequence[Side], Sequence[int]]]) -> set[int]:
    """Which roundings are the inside or the outside of a bend.

    Parameters
    ----------
    solid : Solid
    roundings : sequence of (convex, sides, edges)
        What is known at the borders of each, and the ids of the edges there.
    """
    found = set()
    for i, (convex, sides, edges) in enumerate(roundings):
        for j, (other_convex, other_sides, other_edges) in enumerate(roundings):
            if convex and not other_convex and (
                _behind(solid, sides, other_edges) or _behind(solid, other_sides, edges)
            ):  # fmt: skip
                found |= {i, j}
    return found


def _behind(solid: Solid, sides: Sequence[Side], edges: Sequence[int]) -> bool:
    """Whether edges lie behind most of some borders, at one distance."""
    depths = []
    for side in sides:
        near = np.array([solid.edges[e].curve.nearest(side.points) for e in edges])  # (edges, m, 3)
        offsets = near - side.points
        distances = np.linalg.norm(offsets, axis=2)
        deep = -np.einsum("eij,ij->ei", offsets, side.normals)
        straight = (deep > _ACROSS * distances) & (distances > 0)
        depths.append(np.where(straight, distances, np.inf).min(axis=0))
    all_depths = np.concatenate(depths)
    seen = all_depths[np.isfinite(all_depths)]
    if len(seen) < _MOST * len(all_depths):
        return False
    middle = float(np.median(seen))
    return bool((abs(seen - middle) <= _EVEN * middle).sum() >= _MOST * len(all_depths))


__all__ = ["bent_walls"]
