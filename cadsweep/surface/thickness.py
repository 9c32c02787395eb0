"""Walls of a cap that are one quad thick: such a wall bends as if it were much stiffer.

Place in the flow: the surface stage notes them; ``pipeline`` divides a part finer where nobody asked for so few.

Method: a segment inside the cap that joins two nodes of its outline which are far apart along it goes right across.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..polygons import next_corners

_ALONG = 3
"""Nodes of a loop up to which a segment cuts a corner off and does not cross a wall."""


def thin_share(points: FloatArray, quads: IntArray, loops: Sequence[IntArray]) -> float:
    """Part of a cap's outline, by length, along which the wall is one quad thick.

    Parameters
    ----------
    points : (n, 3) float64
    quads : (q, 4) int64
    loops : sequence of int64 arrays
        Boundary nodes in cyclic order.

    Returns
    -------
    float
        From 0 to 1.
    """
    loop_of = np.full(len(points), -1, dtype=np.int64)
    place = np.zeros(len(points), dtype=np.int64)
    sizes = np.array([len(loop) for loop in loops])
    for j, loop in enumerate(loops):
        loop_of[loop], place[loop] = j, np.arange(len(loop))
    a, b = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2).T
    on_rim = (loop_of[a] >= 0) & (loop_of[b] >= 0)
    a, b = a[on_rim], b[on_rim]
    gap = np.abs(place[a] - place[b])
    gap = np.minimum(gap, sizes[loop_of[a]] - gap)
    across = (loop_of[a] != loop_of[b]) | (gap > _ALONG)
    thin = np.zeros(len(points), dtype=bool)
    thin[a[across]] = thin[b[across]] = True
    begin = np.concatenate(loops)
    end = begin[next_corners(loops)]
    steps = np.linalg.norm(points[end] - points[begin], axis=1)
    return float((steps * (thin[begin].astype(float) + thin[end])).sum() / (2.0 * steps.sum()))
