"""Whole circles at which a solid is re-entrant, or that are imprinted on its plane faces: floors of holes, bosses.

Place in the flow: :mod:`.blind` and :mod:`.cushions` put cells under them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_IN

from ...arrays import FloatArray
from ...brep import Edge, Face, Solid
from ..shapes import shapes_of
from .central import SAME

ROUND = 1e-3
"""Share of its radius by which points of a whole circle, its middle taken from 64 of each arc, may be off it."""

IsInside = Callable[[FloatArray], bool]


@dataclass(frozen=True, kw_only=True, eq=False)
class Rim:
    """A whole circle on a plane face, the material on the other side of the face."""

    center: FloatArray
    normal: FloatArray
    radius: float
    start: FloatArray
    length: float
    face: Face


def find_rims(solid: Solid, flat: float) -> list[Rim]:
    """The circles, the largest first.

    Parameters
    ----------
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    return sorted(_rims(solid, flat), key=lambda rim: -rim.radius)


def inside_of(solid: Solid) -> IsInside:
    """Tell whether a point (3,) lies in the material."""
    classifier = BRepClass3d_SolidClassifier(shapes_of(solid).shape)

    def is_inside(point: FloatArray) -> bool:
        classifier.Perform(gp_Pnt(*map(float, point)), SAME * solid.size)
        return bool(classifier.State() == TopAbs_IN)

    return is_inside


def _rims(solid: Solid, flat: float) -> Iterator[Rim]:
    taken: list[FloatArray] = []
    for face in solid.faces:
        if face.kind != "plane":
            continue
        for loop in face.loops:
            edges = [solid.edges[e] for e in loop.edges]
            if any(edge.kind != "circle" or edge.dihedral < pi - flat for edge in edges):
                continue
            found = _circle(edges)
            if found is None or any(np.abs(found[0] - other).max() < SAME * solid.size for other in taken):
                continue
            taken.append(found[0])
            center, radius = found
            yield Rim(
                center=center, normal=face.normal, radius=radius, start=solid.vertices[edges[0].start],
                length=sum(edge.length for edge in edges), face=face,
            )  # fmt: skip


def _circle(edges: Sequence[Edge]) -> tuple[FloatArray, float] | None:
    """Centre and radius, where the edges of a loop are one whole circle."""
    length = sum(edge.length for edge in edges)
    radius = length / (2.0 * pi)
    rows = [edge.curve.evaluate((np.arange(64) + 0.5) / 64) for edge in edges]
    # The middle of a circle is the mean of its points, every arc as heavy as it is long.
    center = np.average([row.mean(axis=0) for row in rows], axis=0, weights=[edge.length for edge in edges])
    off = np.abs(np.linalg.norm(np.concatenate(rows) - center, axis=1) - radius).max()
    return (center, radius) if off < ROUND * radius else None


__all__ = ["Rim", "find_rims", "inside_of"]
