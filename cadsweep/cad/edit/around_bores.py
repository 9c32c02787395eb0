"""Planes through the axis of a bore, half way between the sides around it that carry features of their own.

Place in the flow: candidates of :mod:`.cutters`. The hub of a spider has a pin on each of its sides and a bore across
all of them: no extended face and no carried rim parts the pins, as each would run into the bore, or into the next pin::

      \\____|____/       Each piece is swept from its side, with the outline of the pin on it, to its part of the bore;
      |\\   _   /|       the planes are walls of both neighbours.
    --| > (_) < |--
      |/_______\\|
      /    |    \\

Not handled: sides of one hub that lean to its bore; what opens into the bore (:mod:`.crossings`).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import atan2, cos, pi, sin

import numpy as np

from ...brep import Solid
from .axes import Axis, find_axes, is_hollow
from .central import Cutter, plane_tool

SQUARE = 1e-6
"""Cosine of the angle of two directions up to which they are square to each other."""
LEAST, WIDEST = pi / 6.0, 2.0 * pi / 3.0
"""Angles between neighbouring sides: a sharper piece makes poor hexahedra, a wider one is no sweep to the bore."""


def around_bores(solid: Solid) -> list[Cutter]:
    """Planes through the axis of each bore that has features on sides all around it."""
    return list(_cutters(solid))


def _cutters(solid: Solid) -> Iterator[Cutter]:
    for axis in find_axes(solid):
        if not _is_bore(solid, axis):
            continue
        x = np.cross(axis.direction, np.eye(3)[int(np.abs(axis.direction).argmin())])
        x /= np.linalg.norm(x)
        y = np.cross(axis.direction, x)
        angles: list[float] = []
        for face in solid.faces:
            if face.kind != "plane" or len(face.loops) < 2 or abs(float(face.normal @ axis.direction)) > SQUARE:
                continue
            angle = atan2(float(face.normal @ y), float(face.normal @ x)) % (2.0 * pi)
            if all(min(abs(angle - a), 2.0 * pi - abs(angle - a)) > SQUARE for a in angles):
                angles.append(angle)
        angles.sort()
        if len(angles) < 3:
            continue
        steps = [b - a for a, b in pairwise([*angles, angles[0] + 2.0 * pi])]
        if min(steps) < LEAST or max(steps) > WIDEST:
            continue
        halves = sorted({round((a + 0.5 * step) % pi, 9) for a, step in zip(angles, steps, strict=True)})
        normals = [cos(half) * y - sin(half) * x for half in halves]
        yield Cutter(
            reason=f"planes through the axis of {axis.label}, between the sides around it",
            tools=tuple(plane_tool(solid, normal, axis.place) for normal in normals),
            weight=solid.size,
            leads=True,
        )


def _is_bore(solid: Solid, axis: Axis) -> bool:
    """Whether a cylinder is seen from inside, and nothing but plane ends meets it."""
    beside = {f for own in axis.faces for e in solid.faces[own].edges for f in solid.edges[e].faces} - axis.faces
    if any(solid.faces[f].kind != "plane" for f in beside):
        return False
    face = solid.faces[min(axis.faces)]
    return is_hollow(face, solid.edges[face.edges[0]].midpoint, axis.place, axis.direction)


__all__ = ["around_bores"]
