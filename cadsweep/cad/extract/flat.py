"""Areas and centroids of plane faces between lines and conics, all of a solid's at once.

Place in the flow: called by ``solids``; faces with other edges, and curved ones, are integrated one by one by
:mod:`cadsweep.cad.geometry.measure`.

Method: Green's theorem in space. About a point p of the plane, ``(x - p) x dx / 2`` along the loops adds up to the
face's vector area, and ``2/3 (x - p)`` of it to the first moment. Straight edges are exact; arcs take Gauss-Legendre
sums, which are exact to rounding for up to a full turn.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray, IntArray
from ...brep import Loop
from ..geometry.curves import EdgeCurve
from ..geometry.measure import Measure
from ..geometry.parametric import Ellipse, Line
from .sampling import EdgeSamples

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_NODES, _WEIGHTS = (_NODES + 1) / 2, _WEIGHTS / 2


def is_exact(curve: EdgeCurve) -> bool:
    """Whether the edge's curve is one of those that are integrated here."""
    return isinstance(curve.geometry, Line | Ellipse)


def measure_flat(
    faces: Sequence[Sequence[Loop]], normals: FloatArray, curves: Sequence[EdgeCurve], edges: EdgeSamples
) -> list[Measure | None]:
    """Measure plane faces.

    Parameters
    ----------
    faces : sequence of n sequences of Loop
        The loops of each face; of their edges `is_exact` holds.
    normals : (n, 3) float64
        Outward unit normals.
    curves, edges
        The curves of the solid's edges, and where these begin and end.

    Returns
    -------
    list of Measure or None
        None for a face without a positive area: its loops run the wrong way round, or are none.
    """
    uses = [(f, e, forward) for f, loops in enumerate(faces) for loop in loops for e, forward in loop.directed]
    if not uses:
        return [None] * len(faces)
    of_face, number, forward = (np.array(column) for column in zip(*uses, strict=True))
    sense = np.where(forward, 1.0, -1.0)
    first_use = np.searchsorted(of_face, np.arange(len(faces)))
    origins = edges.points[number[np.minimum(first_use, len(uses) - 1)], 0]
    start, end = edges.points[number, 0] - origins[of_face], edges.points[number, 2] - origins[of_face]
    normal = normals[of_face]
    areas = np.einsum("md,md->m", np.cross(start, end), normal) / 2.0 * sense
    moments = areas[:, None] * (start + end) / 3.0
    arcs = np.flatnonzero([not isinstance(curves[e].geometry, Line) for e in number])
    if len(arcs):
        areas[arcs], moments[arcs] = _arcs(number[arcs], sense[arcs], origins[of_face[arcs]], normal[arcs], curves)
    area = np.bincount(of_face, areas, len(faces))
    moment = np.stack([np.bincount(of_face, column, len(faces)) for column in moments.T], axis=1)
    out: list[Measure | None] = []
    for f in range(len(faces)):
        if not area[f] > 0:
            out.append(None)
            continue
        center = origins[f] + moment[f] / area[f]
        vector = area[f] * normals[f]
        out.append(Measure(float(area[f]), center, float(center @ vector) / 3.0, vector))
    return out


def _arcs(
    numbers: IntArray, sense: FloatArray, origins: FloatArray, normals: FloatArray, curves: Sequence[EdgeCurve]
) -> tuple[FloatArray, FloatArray]:
    """Areas (m,) and first moments (m, 3) between the origins and arcs of circles and ellipses."""
    conics = [curves[e].geometry for e in numbers]
    center, x_axis, y_axis = (
        np.array([getattr(conic, name) for conic in conics])[:, None] for name in ("center", "x_axis", "y_axis")
    )
    first, last = np.array([(curves[e].first, curves[e].last) for e in numbers]).T
    width = (last - first) * sense
    at = (first[:, None] + (last - first)[:, None] * _NODES)[..., None]
    arm = center - origins[:, None] + np.cos(at) * x_axis + np.sin(at) * y_axis
    slope = np.cos(at) * y_axis - np.sin(at) * x_axis
    share = np.einsum("mgd,md->mg", np.cross(arm, slope), normals) * (_WEIGHTS * width[:, None]) / 2.0
    return share.sum(axis=1), 2.0 / 3.0 * np.einsum("mg,mgd->md", share, arm)
