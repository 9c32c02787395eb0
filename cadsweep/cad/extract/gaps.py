"""How far the borders of a face are off the edges that it shares with its neighbours.

Place in the flow: ``extract`` asks for it, and the checks of a mesh allow for it: where faces miss each other, nothing
says better than about the gap times the area what the volume between them is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arrays import FloatArray
from ..geometry.curves import EdgeCurve
from ..geometry.face_surface import FaceSurface
from ..geometry.parametric import Ellipse, Line
from ..geometry.record_kernels import borders_apart
from ..geometry.surfaces import Plane
from .sampling import EdgeSamples

_SAMPLES = np.linspace(0.0, 1.0, 9)
"""Shares of an edge's range at which its gap is measured: its ends, its middle, and three between each."""
_NOTHING = 1e-9
"""Distance, as a share of the part's size, that rounding explains."""


def border_gaps(surface: FaceSurface, edges: EdgeSamples, size: float) -> tuple[list[int], FloatArray]:
    """The edges of a face, and the largest distance (m,) of each from its line on the face.

    Parameters
    ----------
    surface : FaceSurface
    edges : EdgeSamples
        Of the whole solid. A plane between lines and conics is bounded by these themselves, dropped on it.
    size : float
        Of the part, working units.
    """
    numbers = list(surface.curves)
    curves = [surface.curves[e].curve for e in numbers]
    if isinstance(surface.geometry, Plane) and all(isinstance(c.geometry, Line | Ellipse) for c in curves):
        frame = surface.geometry.frame
        return numbers, np.abs((edges.points[numbers] - frame.origin) @ frame.z).max(axis=1)
    parameters = np.array([curve.first + _SAMPLES * (curve.last - curve.first) for curve in curves])
    away, on_face = _apart(surface, curves, parameters)
    for j in np.flatnonzero(away > _NOTHING * size):
        # The two may run along one line unlike each other.
        away[j] = curves[j].distance(on_face[j]).max()
    return numbers, away


def _apart(surface: FaceSurface, curves: Sequence[EdgeCurve], parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Greatest distance (n,) of edges from their lines on the face at parameters (n, m); points (n, m, 3) of these."""
    record, lines = surface.record, surface.edge_records
    records = [curve.record for curve in curves]
    found = [own for own in records if own is not None]
    if record is not None and lines is not None and len(found) == len(records):
        on_face, away = np.empty((*parameters.shape, 3)), np.empty(len(curves))
        space_starts = np.cumsum([0] + [len(own) for own in found[:-1]])
        edges_in_space = np.concatenate(found), space_starts
        in_parameters = lines.values, lines.starts, lines.shifts
        borders_apart(record, edges_in_space, in_parameters, parameters, on_face, away)
        return away, on_face
    places, uv = zip(*(_samples(surface, e, at) for e, at in zip(surface.curves, parameters, strict=True)), strict=True)
    on_face = surface.evaluate(np.concatenate(uv)).reshape(*parameters.shape, 3)
    return np.linalg.norm(np.array(places) - on_face, axis=2).max(axis=1), on_face


def _samples(surface: FaceSurface, edge: int, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (m, 3) of the edge, and the parameters (m, 2) on the face that answer them."""
    points = surface.curves[edge].curve.geometry.derivatives(parameters)[0]
    known, shift = surface.curves[edge].in_parameters
    if known is None:
        return points, surface.project(points)
    return points, known.derivatives(parameters)[0] + shift
