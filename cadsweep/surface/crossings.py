"""Whether loops in the plane cross themselves or one another.

Place in the flow: ``gmsh_quads`` asks before it calls gmsh, whose meshers go on for ever between
boundaries that cross.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from ..arrays import FloatArray
from ..polygons import next_corners

_ROUNDING = 1e-14
"""Error of a coordinate, as a share of the largest: a few dozen roundings on its way from a curve to the chart."""


def loops_cross(loops: Sequence[FloatArray]) -> bool:
    """Tell whether two segments that are no neighbours meet.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Closed polygons.

    Returns
    -------
    bool
    """
    starts = np.concatenate(loops)
    after = next_corners(loops)
    ends = starts[after]
    # Segments that meet have middles no farther apart than the longer of them.
    reach = float(np.sqrt(np.max(((ends - starts) ** 2).sum(axis=1))))
    pairs = scipy.spatial.cKDTree((starts + ends) / 2).query_pairs(reach * (1 + 1e-9), output_type="ndarray")
    i, j = pairs[:, 0], pairs[:, 1]
    apart = (after[i] != j) & (after[j] != i)
    i, j = i[apart], j[apart]
    a, b, c, d = starts[i], ends[i], starts[j], ends[j]
    blur = _ROUNDING * float(np.abs(starts).max())
    sides = np.stack([_side(a, b, c, blur), _side(a, b, d, blur), _side(c, d, a, blur), _side(c, d, b, blur)])
    across = (sides[0] * sides[1] <= 0) & (sides[2] * sides[3] <= 0)
    # Of segments in one line, one after the other, rounding may put some ends in line and others beside it.
    first, last = np.maximum(np.minimum(a, b), np.minimum(c, d)), np.minimum(np.maximum(a, b), np.maximum(c, d))
    overlap = (first <= last + blur).all(axis=1)
    return bool((across & overlap).any())


def _side(start: FloatArray, end: FloatArray, point: FloatArray, blur: float) -> FloatArray:
    """Sign of the turn from a segment to a point, zero where they are in line to the `blur` of coordinates."""
    a, b = end - start, point - start
    turn = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    reach = np.sqrt((a**2).sum(axis=1)), np.sqrt((b**2).sum(axis=1))
    rounding = 1e-14 * reach[0] * reach[1] + blur * (reach[0] + reach[1])
    return np.where(np.abs(turn) <= rounding, 0.0, np.sign(turn))
