"""Corners of the source cap that are none on the target, and the other way round.

Place in the flow: after the rings, before the source cap's quads. A quad that has a corner of 90 degrees to
itself is flat where the corner ends up straight, however good it is on the source: ``quads``, ``annulus``
and ``mend`` are told the angles here.

Not handled: angles on the layers between the caps, and vertices where a cap has several faces.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..sweep import Sweep

_SAME_ANGLE = np.radians(30)
"""Angles at the two ends of a rail that differ by less ask for the same number of quads."""


def opposite_angles(sweep: Sweep, vertices: IntArray) -> FloatArray:
    """Angles that the ring's nodes have on the target cap, where they differ from those on the source.

    Parameters
    ----------
    vertices : (2, b) int64
        CAD vertex of each node of the first and the last ring, -1 where there is none.

    Returns
    -------
    (b,) float64
        Radians; NaN where the angles differ by less than `_SAME_ANGLE`, or the cap has several faces there.
    """
    angles = np.full(vertices.shape, np.pi)
    for row, cap, own in zip(angles, (sweep.source, sweep.target), vertices, strict=True):
        at_vertex: dict[int, list[float]] = {}
        for f in cap:
            for loop in sweep.solid.faces[f].loops:
                for (edge, forward), angle in zip(loop.directed, loop.angles, strict=True):
                    ends = (sweep.solid.edges[edge].start, sweep.solid.edges[edge].end)
                    at_vertex.setdefault(ends[not forward], []).append(angle)
        for node in np.flatnonzero(own >= 0).tolist():
            found = at_vertex.get(int(own[node]), [np.pi])
            row[node] = found[0] if len(found) == 1 else np.nan
    source, target = angles
    differ = np.abs(source - target) > _SAME_ANGLE
    return np.where(differ & np.isfinite(source), target, np.nan)
