"""How far the facets of a boundary lie off the CAD faces, measured there.

Place in the flow: :mod:`cadsweep.quality.cadcheck` asks for it where the turning angles of the mesh cannot
explain a volume or an area: a bend of one layer of hexahedra has no neighbours to turn to.

Method: a chord of length l that lies s off its arc is shorter by a fraction (8 / 3) (s / l)**2, and cuts off
an area of (2 / 3) l s; a facet that lies s off cuts off its area times s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set

import numpy as np

from ..arrays import FloatArray, IntArray


def measure_slack(
    points: FloatArray,
    boundaries: Mapping[str, IntArray],
    distance: Callable[[FloatArray, str, float], FloatArray],
    overlapping: Set[tuple[str, str]] = frozenset(),
) -> dict[str, tuple[float, float]]:
    """Volume and area that the facets of each boundary can gain or lose.

    Parameters
    ----------
    points : (n, 3) float64
    boundaries : mapping of name to (q, 4) int64
    distance : callable
        See :class:`cadsweep.quality.report.CadReference`.
    overlapping : set of (str, str)
        Boundaries that share quads: neither lies on the other side of the other's rim.

    Returns
    -------
    dict of str to (float, float)
    """
    rims = {name: _rim(quads) for name, quads in boundaries.items()}
    found = {}
    for name, quads in boundaries.items():
        if not len(quads):
            found[name] = (0.0, 0.0)
            continue
        corners = points[quads]
        areas = 0.5 * np.linalg.norm(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)
        volume = float(np.sum(areas * np.abs(distance(corners.mean(axis=1), name, np.inf))))
        ends = np.roll(corners, -1, axis=1)
        sags = np.abs(distance(((corners + ends) / 2).reshape(-1, 3), name, np.inf)).reshape(-1, 4)
        lengths = np.linalg.norm(ends - corners, axis=2)
        ratios = np.minimum(sags / np.where(lengths > 0, lengths, np.inf), 1.0) ** 2
        area = float(np.sum(areas[:, None] * (8 / 3) * ratios))
        beside = {other: rim for other, rim in rims.items() if (name, other) not in overlapping}
        found[name] = (volume, area + _rim_bulge(points, name, beside, distance))
    return found


def _rim(quads: IntArray) -> IntArray:
    """Edges (m, 2) of one quad alone, their ends in rising order."""
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    return unique[uses == 1]


def _rim_bulge(
    points: FloatArray,
    name: str,
    rims: Mapping[str, IntArray],
    distance: Callable[[FloatArray, str, float], FloatArray],
) -> float:
    """Area between the rim of a boundary and the faces on its other side."""
    total = 0.0
    mine = {tuple(edge) for edge in rims[name].tolist()}
    for other, rim in rims.items():
        if other == name:
            continue
        shared = np.array([edge for edge in rim.tolist() if tuple(edge) in mine], dtype=np.int64).reshape(-1, 2)
        if len(shared):
            start, end = points[shared[:, 0]], points[shared[:, 1]]
            middles = (start + end) / 2
            # The edge lies off its chord by d. Its distances from the two faces show d only as far as they stand
            # upright on one another; twice their sum bounds it down to angles of 30 degrees between them.
            sags = 2 * (np.abs(distance(middles, other, np.inf)) + np.abs(distance(middles, name, np.inf)))
            total += float(np.sum((2 / 3) * np.linalg.norm(end - start, axis=1) * sags))
    return total
