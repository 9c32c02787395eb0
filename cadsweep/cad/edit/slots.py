"""Slots of a solid as what they are for cuts: bores that are spread out between two lines.

Place in the flow: :mod:`.crossings` and :mod:`.axial` ask here for all that may cross.

Method: two halves of hollow cylinders of one radius that face each other, and the flat sides that go on from both.

Not handled: slots that are open at an end, whose ends are rounded in part, or that run askew to what they cross.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from math import pi
from weakref import WeakKeyDictionary

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid
from .axes import ALIKE, WHOLE, Axis, find_axes

_HALF = pi - 1e-3
"""Radians that the faces of an end go around, at least."""
_SQUARE = 1e-6
"""Cosine of two directions that are square to each other."""
_FLAT = 1e-4
"""Radians from pi up to which two faces at an edge are one surface."""


def find_passages(solid: Solid) -> list[Axis]:
    """List the whole bores and shafts of a solid, then its slots; each solid is read once."""
    known = _passages_of.get(solid)
    if known is None:
        known = _passages_of[solid] = (*find_axes(solid), *_read_slots(solid))
    return list(known)


_passages_of: WeakKeyDictionary[Solid, tuple[Axis, ...]] = WeakKeyDictionary()


def _read_slots(solid: Solid) -> Iterator[Axis]:
    halves = [axis for axis in find_axes(solid, least_turn=_HALF) if axis.turn < WHOLE and axis.is_bore]
    line = 1 + max((axis.line for axis in find_axes(solid, least_turn=0.0)), default=0)
    for a, b in combinations(halves, 2):
        if abs(a.radius - b.radius) > ALIKE * a.radius or abs(a.direction @ b.direction) < 1.0 - 1e-9:
            continue
        shift = float((b.place - a.place) @ a.direction)
        spread = b.place - a.place - shift * a.direction
        length = float(np.linalg.norm(spread))
        if length < ALIKE * solid.size or not _face_each_other(solid, a, b, spread / length):
            continue
        sides = _sides(solid, a, b, spread / length)
        if not sides:
            continue
        sign = float(np.sign(a.direction @ b.direction))
        ends = sorted(shift + sign * t for t in (b.low, b.high))
        yield replace(
            a,
            low=min(a.low, ends[0]),
            high=max(a.high, ends[1]),
            turn=2.0 * pi,
            faces=a.faces | b.faces | sides,
            line=line,
            spread=spread,
        )
        line += 1


def _face_each_other(solid: Solid, a: Axis, b: Axis, way: FloatArray) -> bool:
    """Whether each of two ends lies on the side of its axis that is away from the other."""
    at = np.linspace(0.0, 1.0, 5)
    for axis, sign in ((a, -1.0), (b, 1.0)):
        points = np.concatenate([solid.edges[e].curve.evaluate(at) for f in axis.faces for e in solid.faces[f].edges])
        if float((sign * (points - axis.place) @ way).min()) < -_FLAT * axis.radius:
            return False
    return True


def _sides(solid: Solid, a: Axis, b: Axis, way: FloatArray) -> frozenset[int]:
    """The plane faces that go on from the ends; none where one of these has none."""
    found: set[int] = set()
    for axis in (a, b):
        own = {
            f
            for edge in solid.edges
            if axis.faces.intersection(edge.faces) and abs(edge.dihedral - pi) < _FLAT
            for f in edge.faces
            if solid.faces[f].kind == "plane" and abs(float(solid.faces[f].normal @ way)) < _SQUARE
        }
        if not own:
            return frozenset()
        found |= own
    return frozenset(found)


__all__ = ["find_passages"]
