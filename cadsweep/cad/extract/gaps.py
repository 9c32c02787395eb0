"""How far the borders of a face are off the edges that it shares with its neighbours.

Place in the flow: ``extract`` asks for it, and the checks of a mesh allow for it: where faces miss each other, nothing
says better than about the gap times the area what the volume between them is.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ..geometry.curves import EdgeCurve, Ellipse, Line
from ..geometry.face_surface import FaceSurface
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
    places, uv = zip(*(_samples(surface, e, c) for e, c in zip(numbers, curves, strict=True)), strict=True)
    on_face = surface.evaluate(np.concatenate(uv)).reshape(len(numbers), len(_SAMPLES), 3)
    away = np.linalg.norm(np.array(places) - on_face, axis=2)
    for j in np.flatnonzero(away.max(axis=1) > _NOTHING * size):
        away[j] = curves[j].distance(on_face[j])  # the two may run along one line unlike each other
    return numbers, np.asarray(away.max(axis=1))


def _samples(surface: FaceSurface, edge: int, curve: EdgeCurve) -> tuple[FloatArray, FloatArray]:
    """Points (9, 3) of the edge, and the parameters (9, 2) on the face that answer them."""
    parameters = curve.first + _SAMPLES * (curve.last - curve.first)
    points = curve.geometry.derivatives(parameters)[0]
    known, shift = surface.curves[edge].in_parameters
    if known is None:
        return points, surface.project(points)
    return points, known.derivatives(parameters)[0] + shift
