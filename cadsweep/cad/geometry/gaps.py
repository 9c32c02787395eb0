"""How far the borders of a face are off the edges that it shares with its neighbours.

Place in the flow: ``extract`` asks for it, and the checks of a mesh allow for it: where faces miss each other, nothing
says better than about the gap times the area what the volume between them is.
"""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from .face_surface import FaceSurface

_SAMPLES = np.linspace(0.0, 1.0, 9)
"""Shares of an edge's range at which its gap is measured: its ends, its middle, and three between each."""
_NOTHING = 1e-9
"""Distance, as a share of the part's size, that rounding explains."""


def border_gaps(surface: FaceSurface, size: float) -> dict[int, float]:
    """The largest distance of each edge from its line on the face.

    Parameters
    ----------
    surface : FaceSurface
    size : float
        Of the part, working units.
    """
    numbers = list(surface.curves)
    if not numbers:
        return {}
    places, uv = zip(*(_samples(surface, e) for e in numbers), strict=True)
    on_face = surface.evaluate(np.concatenate(uv)).reshape(len(numbers), len(_SAMPLES), 3)
    gaps = {}
    for e, points, others in zip(numbers, places, on_face, strict=True):
        away = np.linalg.norm(points - others, axis=1)
        if away.max() > _NOTHING * size:
            # The two may run along one line unlike each other.
            away = surface.curves[e][0].distance(others)
        gaps[e] = float(away.max())
    return gaps


def _samples(surface: FaceSurface, edge: int) -> tuple[FloatArray, FloatArray]:
    """Points (9, 3) of the edge, and the parameters (9, 2) on the face that answer them."""
    curve, in_parameters, shift = surface.curves[edge]
    parameters = curve.first + _SAMPLES * (curve.last - curve.first)
    points = curve.geometry.derivatives(parameters)[0]
    if in_parameters is None:
        return points, surface.project(points)
    return points, in_parameters.derivatives(parameters)[0] + shift
