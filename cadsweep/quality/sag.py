"""How far the facets of a boundary lie off the CAD faces, measured there.

Place in the flow: :mod:`cadsweep.quality.cadcheck` asks for it where the turning angles of the mesh cannot
explain a volume or an area: a bend of one layer of hexahedra has no neighbours to turn to.

Method: a chord of length l that lies s off its arc is shorter by a fraction (8 / 3) (s / l)**2, and cuts off
an area of (2 / 3) l s; a facet that lies s off cuts off its area times s.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass

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
    found = {}
    rims: list[_Rim] = []
    for name, quads in boundaries.items():
        if not len(quads):
            found[name] = (0.0, 0.0)
            continue
        corners = points[quads]
        areas = 0.5 * np.linalg.norm(np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1)
        ends = np.roll(corners, -1, axis=1)
        places = np.concatenate([corners.mean(axis=1), ((corners + ends) / 2).reshape(-1, 3)])
        away = np.abs(distance(places, name, np.inf))  # once a face: a model may have hundreds
        volume = float(np.sum(areas * away[: len(quads)]))
        sags = away[len(quads) :].reshape(-1, 4)
        lengths = np.linalg.norm(ends - corners, axis=2)
        ratios = np.minimum(sags / np.where(lengths > 0, lengths, np.inf), 1.0) ** 2
        found[name] = (volume, float(np.sum(areas[:, None] * (8 / 3) * ratios)))
        rims.append(_rim(name, quads, sags, lengths))
    bulges = _rim_bulges(rims, overlapping)
    return {name: (volume, area + bulges.get(name, 0.0)) for name, (volume, area) in found.items()}


@dataclass(frozen=True, kw_only=True, eq=False)
class _Rim:
    """Edges (m, 2) of one quad alone, their ends in rising order, and how far their middles lie off the face."""

    name: str
    edges: IntArray
    sags: FloatArray
    lengths: FloatArray


def _rim(name: str, quads: IntArray, sags: FloatArray, lengths: FloatArray) -> _Rim:
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    unique, first, uses = np.unique(edges, axis=0, return_index=True, return_counts=True)
    alone = first[uses == 1]
    return _Rim(name=name, edges=unique[uses == 1], sags=sags.reshape(-1)[alone], lengths=lengths.reshape(-1)[alone])


def _rim_bulges(rims: Sequence[_Rim], overlapping: Set[tuple[str, str]]) -> dict[str, float]:
    """Area between the rim of every boundary and the faces on its other side."""
    if not rims:
        return {}
    edges = np.concatenate([rim.edges for rim in rims])
    owner = np.repeat(np.arange(len(rims)), [len(rim.edges) for rim in rims])
    sags = np.concatenate([rim.sags for rim in rims])
    lengths = np.concatenate([rim.lengths for rim in rims])
    order = np.lexsort((owner, edges[:, 1], edges[:, 0]))
    edges, owner, sags, lengths = edges[order], owner[order], sags[order], lengths[order]
    apart = np.array([[(one.name, other.name) not in overlapping for other in rims] for one in rims])
    totals = np.zeros(len(rims))
    for step in range(1, len(rims)):
        same = (edges[step:] == edges[:-step]).all(axis=1)
        if not same.any():
            break  # the same edge in several rims stands in one run
        one, other = owner[:-step][same], owner[step:][same]
        # The edge lies off its chord by d. Its distances from the two faces show d only as far as they stand upright
        # on one another; twice their sum bounds it down to angles of 30 degrees between them.
        bulge = (2 / 3) * lengths[step:][same] * 2 * (sags[:-step][same] + sags[step:][same])
        np.add.at(totals, one, np.where(apart[one, other], bulge, 0.0))
        np.add.at(totals, other, np.where(apart[other, one], bulge, 0.0))
    return {rim.name: float(total) for rim, total in zip(rims, totals, strict=True)}
