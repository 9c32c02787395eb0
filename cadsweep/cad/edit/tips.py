"""Tips of faces: corners where two edges meet at next to no angle, and which neighbour would get them.

Place in the flow: :mod:`.bridging` ends faces before them.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from math import cos, pi

import numpy as np
from scipy.optimize import brentq

from ...arrays import FloatArray
from ...brep import Face, Solid
from .corners import SHARP

_FLATTEST = cos(pi / 3)
"""Least cosine between the normals of a tip's face and of the neighbour that gets it: its quads bend by this angle."""
_ONE_PLANE = 1.0 - 1e-9
"""Cosine above which both are in one plane: what only divides one is merged or not followed, and does better so."""
_MOST = 0.45
"""Greatest share of either edge that may be bridged: the face goes on, and another tip may be at its other end."""
_SAMPLES = 65
"""Places along each edge at which its distance to the other is looked at."""


@dataclass(frozen=True, eq=False)
class Tip:
    """A corner of a face that is bridged.

    Attributes
    ----------
    face, neighbour : int
        Its face, and the one that gets it.
    corner : int
        Its vertex.
    ends : (int, float), (int, float)
        The edges that meet at the corner, each with the place on it where the short edge ends, in fractions of length.
    """

    face: int
    neighbour: int
    corner: int
    ends: tuple[tuple[int, float], tuple[int, float]]


def find_tips(solid: Solid, length: float, kept: Collection[int] = frozenset()) -> list[Tip]:
    """Corners of faces whose edges meet at next to no angle and are `length` apart, working units, before they end.

    Faces that are `kept` have none.
    """
    found = []
    for face in solid.faces:
        for loop in face.loops if face.id not in kept else ():
            for j, angle in enumerate(loop.angles):
                if angle < SHARP and len(loop.edges) > 1:
                    tip = _tip(solid, face, loop.directed[j - 1], loop.directed[j], length)
                    if tip is not None:
                        found.append(tip)
    return found


def _tip(solid: Solid, face: Face, before: tuple[int, bool], after: tuple[int, bool], length: float) -> Tip | None:
    """The corner of a face between two directed edges, where it can be bridged."""
    if before[0] == after[0]:
        return None
    legs = (before[0], not before[1]), after

    def along(away: FloatArray) -> list[FloatArray]:
        shares = [away / solid.edges[edge].length for edge, _ in legs]
        return [share if forward else 1.0 - share for share, (_, forward) in zip(shares, legs, strict=True)]

    def apart(away: FloatArray) -> FloatArray:
        first, second = (solid.edges[e].curve.evaluate(f) for (e, _), f in zip(legs, along(away), strict=True))
        return np.linalg.norm(first - second, axis=1)

    away = np.linspace(0.0, _MOST, _SAMPLES) * min(solid.edges[edge].length for edge, _ in legs)
    wide = np.flatnonzero(apart(away) >= length)
    if not len(wide):
        return None
    at = brentq(lambda x: apart(np.array([x]))[0] - length, away[wide[0] - 1], away[wide[0]])
    ends = [(edge, float(f[0])) for (edge, _), f in zip(legs, along(np.array([at])), strict=True)]
    middle = np.mean([solid.edges[edge].curve.evaluate(np.array([f])) for edge, f in ends], axis=0)
    own = face.surface.normals(face.surface.project(middle))[0]
    beside = {other for edge, _ in legs for other in solid.edges[edge].faces} - {face.id}
    surfaces = {other: solid.faces[other].surface for other in beside}
    flat = {other: float(own @ of.normals(of.project(middle))[0]) for other, of in surfaces.items()}
    neighbour = max(flat, key=lambda other: flat[other], default=-1)
    if neighbour < 0 or not _FLATTEST <= flat[neighbour] <= _ONE_PLANE:
        return None
    return Tip(face.id, neighbour, solid.first_vertex(after), (ends[0], ends[1]))


__all__ = ["Tip", "find_tips"]
