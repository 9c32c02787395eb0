"""The cylinders of a solid about each line: its bores, shafts and round ends.

Place in the flow: what the makers of cutters (:mod:`.crossings`, :mod:`.ports`, :mod:`.axial`, ...) ask of a cell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cylinder

from ...arrays import FloatArray
from ...brep import Face, Solid
from ..shapes import shapes_of

MEET = 1e-4
"""Distance of two axes, as a share of the cell's size, up to which they meet: what CAD programs round to."""
ALIKE = 1e-4
"""Difference of two radii, as a share of them, up to which they are one."""
WHOLE = 2.0 * pi - 1e-3
"""Radians that the faces of a cylinder go around, together, where it is whole."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Axis:
    """All cylinders of one radius about one line.

    Attributes
    ----------
    place, direction : (3,) float64
    radius : float
    label : str
        Of a face of it.
    low, high : float
        Its reach along the direction, from `place`.
    turn : float
        Radians that its faces go around, together.
    faces : frozenset of int
    cylinder : gp_Cylinder
    line : int
        The same for all radii about one line.
    """

    place: FloatArray
    direction: FloatArray
    radius: float
    label: str
    low: float
    high: float
    turn: float
    faces: frozenset[int]
    cylinder: Any
    line: int


def find_axes(solid: Solid, *, least_turn: float = WHOLE) -> list[Axis]:
    """Cylinders of a solid that go around whole, or `least_turn` radians; those of one radius on a line are one.

    Each solid is read once.
    """
    known = _axes_of.get(solid)
    if known is None:
        known = _axes_of[solid] = tuple(_read_axes(solid))
    return [axis for axis in known if axis.turn > least_turn]


_axes_of: WeakKeyDictionary[Solid, tuple[Axis, ...]] = WeakKeyDictionary()
"""Seven kinds of cutters ask for them."""


def _read_axes(solid: Solid) -> list[Axis]:
    holder = shapes_of(solid)
    found: list[Axis] = []
    places, directions = np.empty((len(solid.faces), 3)), np.empty((len(solid.faces), 3))
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
        # A plate has hundreds of bores: all lines are asked at once.
        lines = directions[: len(found)]
        off = np.linalg.norm(np.cross(place - places[: len(found)], lines), axis=1)
        beside = np.flatnonzero((np.abs(lines @ direction) > 1.0 - 1e-9) & (off < MEET * solid.size)).tolist()
        alike = [j for j in beside if abs(found[j].radius - cylinder.Radius()) < ALIKE * found[j].radius]
        if alike:
            own = found[alike[0]]
            shift, sign = float((place - own.place) @ own.direction), float(np.sign(own.direction @ direction))
            low, high = sorted((shift + sign * low, shift + sign * high))
            found[alike[0]] = replace(
                own,
                low=min(own.low, low),
                high=max(own.high, high),
                turn=own.turn + turn,
                faces=own.faces | {face.id},
            )
            continue
        places[len(found)], directions[len(found)] = place, direction
        found.append(
            Axis(
                place=place,
                direction=direction,
                radius=cylinder.Radius(),
                label=face.label(),
                low=low,
                high=high,
                turn=turn,
                faces=frozenset([face.id]),
                cylinder=cylinder,
                line=found[beside[0]].line if beside else len(found),
            )
        )
    return found


def is_hollow(face: Face, point: FloatArray, place: FloatArray, direction: FloatArray) -> bool:
    """Whether a round face about an axis, with a point of it, is seen from inside: that of a hole."""
    arm = point - place
    arm -= (arm @ direction) * direction
    return bool(face.surface.normals(face.surface.project(point[None]))[0] @ arm < 0.0)


__all__ = ["ALIKE", "MEET", "WHOLE", "Axis", "find_axes", "is_hollow"]
