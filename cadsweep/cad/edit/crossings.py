"""Planes where round features cross: through the point, along and square to the plane of both axes.

Place in the flow: candidates of :mod:`.cutters`. Where two bores meet, a hole goes across a round bar, or one bar
leaves another, no face goes on that would part them. Three planes through the point where their axes meet leave eight
cells whose corners have three edges; planes half way between the points on one axis keep them apart.

Not handled: axes that pass each other, and cylinders that do not go all around, as the ends of slots.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, pairwise
from math import pi
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.GeomAbs import GeomAbs_Cylinder

from ...arrays import FloatArray
from ...brep import Solid
from ..shapes import shapes_of
from .central import Cutter, plane_tool

MEET = 1e-4
"""Distance of two axes, as a share of the cell's size, up to which they meet: what CAD programs round to."""
APART = 0.05
"""Distance of two points on an axis, in radii of it, from which a plane between them is worth it."""


FLAT = 1e-4
"""Radians from pi up to which two faces at an edge are one surface."""
WHOLE = 2.0 * pi - 1e-3
"""Radians that the faces of a cylinder go around, together, where it is whole."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Axis:
    """All cylinders about one line."""

    place: FloatArray
    direction: FloatArray
    radius: float
    label: str
    low: float
    high: float
    turn: float
    faces: frozenset[int]
    cylinder: Any


def at_crossings(solid: Solid) -> list[Cutter]:
    """Planes between the points where axes meet, then planes through every one of them."""
    axes = _axes(solid)
    points: dict[int, list[float]] = {}
    through: list[Cutter] = []
    for (i, a), (j, b) in combinations(enumerate(axes), 2):
        place = _meeting(a, b, solid.size)
        if place is None:
            continue
        points.setdefault(i, []).append(float((place - a.place) @ a.direction))
        points.setdefault(j, []).append(float((place - b.place) @ b.direction))
        square = np.cross(a.direction, b.direction)
        square /= np.linalg.norm(square)
        normals = [square, np.cross(square, a.direction), np.cross(square, b.direction)]
        tools = [plane_tool(solid, normal, place) for normal in normals]
        if _is_joint(solid, a, b):
            tools += _extended(solid, min(a, b, key=lambda axis: axis.radius))
        through.append(
            Cutter(
                reason=f"planes where {a.label} and {b.label} cross",
                tools=tuple(tools),
                weight=min(a.radius, b.radius),
                leads=True,
            )
        )
    return [*_between(solid, axes, points), *sorted(through, key=lambda cutter: -cutter.weight)]


def _is_joint(solid: Solid, a: _Axis, b: _Axis) -> bool:
    """Whether bars meet in an inner corner: there is material on the inner side of both cylinders."""
    return any(
        edge.dihedral > pi + FLAT and any(edge.faces[k] in a.faces and edge.faces[1 - k] in b.faces for k in (0, 1))
        for edge in solid.edges
    )


def _extended(solid: Solid, axis: _Axis) -> list[Any]:
    """A cylinder through all of the solid, its seams where it has them."""
    middle, reach = float((solid.vertices.mean(axis=0) - axis.place) @ axis.direction), 1.5 * solid.size
    ends = (middle - reach, middle + reach)
    return [BRepBuilderAPI_MakeFace(axis.cylinder, u, u + pi, *ends).Face() for u in (0.0, pi)]


def _between(solid: Solid, axes: list[_Axis], points: dict[int, list[float]]) -> Iterator[Cutter]:
    """Planes square to an axis, half way between the points where others meet it."""
    for i, along in points.items():
        axis = axes[i]
        places = [0.5 * (a + b) for a, b in pairwise(sorted(along)) if b - a > APART * axis.radius]
        if places:
            yield Cutter(
                reason=f"planes between what crosses {axis.label}",
                tools=tuple(plane_tool(solid, axis.direction, axis.place + t * axis.direction) for t in places),
                weight=axis.radius,
                leads=True,
            )


def _axes(solid: Solid) -> list[_Axis]:
    """The lines about which a solid has whole cylinders, with what of each they reach."""
    holder = shapes_of(solid)
    found: list[_Axis] = []
    at = np.linspace(0.0, 1.0, 5)
    for face in solid.faces:
        adaptor = BRepAdaptor_Surface(holder.faces[face.id])
        if adaptor.GetType() != GeomAbs_Cylinder:
            continue
        cylinder = adaptor.Cylinder()
        axis, location = cylinder.Axis().Direction(), cylinder.Location()
        direction = np.array([axis.X(), axis.Y(), axis.Z()])
        place = np.array([location.X(), location.Y(), location.Z()])
        along = np.concatenate([solid.edges[e].curve.evaluate(at) for e in face.edges]) - place
        low, high = float((along @ direction).min()), float((along @ direction).max())
        turn = adaptor.LastUParameter() - adaptor.FirstUParameter()
        for j, own in enumerate(found):
            if abs(own.direction @ direction) > 1.0 - 1e-9 and _off(own, place) < MEET * solid.size:
                shift, sign = float((place - own.place) @ own.direction), float(np.sign(own.direction @ direction))
                low, high = sorted((shift + sign * low, shift + sign * high))
                found[j] = replace(
                    own,
                    radius=max(own.radius, cylinder.Radius()),
                    low=min(own.low, low),
                    high=max(own.high, high),
                    turn=own.turn + turn,
                    faces=own.faces | {face.id},
                )
                break
        else:
            found.append(
                _Axis(
                    place=place,
                    direction=direction,
                    radius=cylinder.Radius(),
                    label=face.label(),
                    low=low,
                    high=high,
                    turn=turn,
                    faces=frozenset([face.id]),
                    cylinder=cylinder,
                )
            )
    return [axis for axis in found if axis.turn > WHOLE]


def _off(axis: _Axis, place: FloatArray) -> float:
    """Distance of a point from an axis."""
    return float(np.linalg.norm(np.cross(place - axis.place, axis.direction)))


def _meeting(a: _Axis, b: _Axis, size: float) -> FloatArray | None:
    """The point where two axes meet within the reach of what is round about them; None where they do not."""
    cosine = float(a.direction @ b.direction)
    if abs(cosine) > 1.0 - 1e-6:
        return None
    gap = b.place - a.place
    along_a, along_b = float(gap @ a.direction), float(gap @ b.direction)
    t = (along_a - cosine * along_b) / (1.0 - cosine**2)
    s = (cosine * along_a - along_b) / (1.0 - cosine**2)
    place = a.place + t * a.direction
    if np.linalg.norm(place - b.place - s * b.direction) > MEET * size:
        return None
    # A blind bore may end in the one it meets, before its axis.
    reached = a.low - b.radius <= t <= a.high + b.radius and b.low - a.radius <= s <= b.high + a.radius
    return place if reached else None
