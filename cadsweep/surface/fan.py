r"""Quads of a face of three, five or six corners: one grid at each corner, all of which meet in the middle.

Place in the flow: one of the ways of :mod:`.filling`, and of :mod:`.symmetric` for the wedge between two mirrors.

Method: midpoint subdivision (Li, McKeag and Armstrong, "Hexahedral meshing using midpoint subdivision and integer
programming", 1995). Each side is divided in two where its corners' grids meet; what a grid has across it has its
neighbour, too, so that the first parts of side i and of side i + 2 are as many segments as side i has::

        o
       / \           the middle is a node of three quads, the
      o   o          only irregular one
     / \_/ \
    o---o---o

Not handled: counts that allow no division, more corners (what meets in the middle would be sharp).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from .embedding import embedded
from .outline import STRAIGHT

_CORNERS = (3, 5, 6)
"""Corners of faces that are filled so; with four they are a grid."""
_SHARPEST = np.radians(140)
"""Interior angle of a polygon below which it has a corner."""


def fan_of_polygon(polygon: FloatArray) -> tuple[FloatArray, IntArray] | None:
    """Inner places, and quads in ids of a polygon's corners (n, 2), counter-clockwise, then of these; None if none."""
    ahead = np.roll(polygon, -1, axis=0) - polygon
    back = np.roll(polygon, 1, axis=0) - polygon
    cross = ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0]
    angles = np.mod(np.arctan2(cross, (ahead * back).sum(axis=1)), 2.0 * np.pi)
    if angles.max() > STRAIGHT[1]:
        return None
    found = fan_of(len(polygon), np.flatnonzero(angles < _SHARPEST).tolist())
    if found is None:
        return None
    return embedded(polygon, *found)[len(polygon) :], found[1]


def fan_of(n: int, corners: Sequence[int]) -> tuple[int, IntArray] | None:
    """Number of inner nodes, and quads, of grids at the corners of a loop of n nodes; None where counts forbid them."""
    k = len(corners)
    if k not in _CORNERS:
        return None
    sides = np.diff([*corners, corners[0] + n])
    # As many equations as sides: a[i] + a[i + 2] = sides[i].
    equations = np.eye(k) + np.roll(np.eye(k), 2, axis=1)
    halves = np.linalg.solve(equations, sides)
    first = np.rint(halves).astype(np.int64)
    if np.abs(halves - first).max() > 1.0 / 4.0 or (first < 1).any() or (sides - first < 1).any():
        return None
    number, quads = n + 1, []
    spokes = []
    for i in range(k):  # from the middle to the division of side i
        inner = int(first[(i + 1) % k]) - 1
        end = (corners[i] + int(first[i])) % n
        spokes.append(np.concatenate([[n], number + np.arange(inner), [end]]))
        number += inner
    for i in range(k):
        across, up = int(first[i]), int(sides[i - 1] - first[i - 1])
        grid = np.empty((across + 1, up + 1), dtype=np.int64)
        grid[:, 0], grid[0, :] = spokes[i - 1], spokes[i]
        grid[1:-1, 1:-1] = number + np.arange((across - 1) * (up - 1)).reshape(across - 1, up - 1)
        number += (across - 1) * (up - 1)
        grid[across, :] = (corners[i] - up + np.arange(up + 1)) % n
        grid[:, up] = (corners[i] + across - np.arange(across + 1)) % n
        quads.append(np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4))
    return number - n, np.concatenate(quads)
