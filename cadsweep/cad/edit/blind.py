"""Cones under the ends of blind round holes and under round bosses, so that their circle goes no further.

Place in the flow: candidates of :mod:`.cutters`. The circle at the end of a hole divides whatever is swept through it,
and with it every cell beyond, where other features ask for other divisions. A cone from the circle to a point in the
material, with two planes through its axis, leaves cells with corners of three edges::

      |   |     |   |        ring around the hole: four prisms, swept along it
    --+   |     |   +--
      |   +-----+   |        the circle
      |    \\   /    |        four cells between cone and disc, four around the cone: a block at every corner,
      |     \\ /     |        and outside of these plane rectangles only
      +-------------+

Not handled: circles that are not whole, and where the point would not lie well inside the material.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.Geom import Geom_ConicalSurface
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt
from OCP.TopAbs import TopAbs_IN

from ...arrays import FloatArray
from ...brep import Edge, Face, Solid
from ..shapes import shapes_of
from .central import SAME, Cutter, plane_tool

DEPTHS = (0.8, 0.5, 0.3)
"""Depths of the point below the circle, in radii, that are tried: the first that has enough material below."""
ENOUGH = 1.8
"""Depth, in those of the cone, down to which there must be material: a little more than :data:`BELOW`."""
BELOW = 1.5
"""Depth, in those of the cone, of a plane that keeps the cells around it from what is further below."""
ROUND = 1e-3
"""Share of its radius by which points of a whole circle, its middle taken from 64 of each arc, may be off it."""
ASIDE = 1.2
"""Radius, in those of the circle, up to which there must be material around it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Rim:
    """A whole circle on a plane face, the material on the other side of the face."""

    center: FloatArray
    normal: FloatArray
    radius: float
    start: FloatArray
    length: float
    face: Face


def under_circles(solid: Solid, flat: float) -> Iterator[Cutter]:
    """Cones under the circles at which a solid is re-entrant, or that are imprinted on its faces.

    Parameters
    ----------
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    holder = shapes_of(solid)
    rims = sorted(_rims(solid, flat), key=lambda rim: -rim.radius)
    if not rims:
        return
    classifier = BRepClass3d_SolidClassifier(holder.shape)

    def is_inside(point: FloatArray) -> bool:
        classifier.Perform(gp_Pnt(*map(float, point)), SAME * solid.size)
        return bool(classifier.State() == TopAbs_IN)

    for rim in rims:
        depth = next((d * rim.radius for d in DEPTHS if _fits(rim, d * rim.radius, is_inside)), None)
        if depth is None:
            continue
        out = rim.start - rim.center
        out /= np.linalg.norm(out)
        planes = [(np.cross(rim.normal, out), rim.center), (out, rim.center), (rim.normal, rim.center)]
        planes.append((rim.normal, rim.center - BELOW * depth * rim.normal))
        yield Cutter(
            reason=f"a cone under the circle on {rim.face.label()}",
            tools=(_cone(rim, out, depth), *(plane_tool(solid, normal, place) for normal, place in planes)),
            weight=rim.length,
        )


def _rims(solid: Solid, flat: float) -> Iterator[_Rim]:
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
            yield _Rim(
                center=center, normal=face.normal, radius=radius, start=solid.vertices[edges[0].start],
                length=sum(edge.length for edge in edges), face=face,
            )  # fmt: skip


def _circle(edges: list[Edge]) -> tuple[FloatArray, float] | None:
    """Centre and radius, where the edges of a loop are one whole circle."""
    length = sum(edge.length for edge in edges)
    radius = length / (2.0 * pi)
    rows = [edge.curve.evaluate((np.arange(64) + 0.5) / 64) for edge in edges]
    # The middle of a circle is the mean of its points, every arc as heavy as it is long.
    center = np.average([row.mean(axis=0) for row in rows], axis=0, weights=[edge.length for edge in edges])
    off = np.abs(np.linalg.norm(np.concatenate(rows) - center, axis=1) - radius).max()
    return (center, radius) if off < ROUND * radius else None


def _fits(rim: _Rim, depth: float, is_inside: Any) -> bool:
    """Whether there is material around a circle, and below the point of its cone."""
    across = np.linalg.svd(rim.normal[None])[2][1:]
    angles = np.linspace(0.0, 2.0 * pi, 9)[:-1]
    around = np.cos(angles)[:, None] * across[0] + np.sin(angles)[:, None] * across[1]
    below = rim.center - depth * rim.normal
    ring = rim.center - 0.1 * depth * rim.normal + ASIDE * rim.radius * around
    places = [below, rim.center - ENOUGH * depth * rim.normal, *ring, *(below + rim.radius * around)]
    return all(is_inside(place) for place in places)


def _cone(rim: _Rim, out: FloatArray, depth: float) -> Any:
    """The cone from a circle to its point, which lies `depth` below."""
    frame = gp_Ax3(gp_Pnt(*map(float, rim.center)), gp_Dir(*map(float, rim.normal)), gp_Dir(*map(float, out)))
    half_angle = float(np.arctan2(rim.radius, depth))
    surface = Geom_ConicalSurface(frame, half_angle, rim.radius)
    return BRepBuilderAPI_MakeFace(surface, 0.0, 2.0 * pi, -depth / np.cos(half_angle), 0.0, 1e-7).Face()
