"""Planes where round features cross: through the point, along and square to the plane of both axes.

Place in the flow: candidates of :mod:`.cutters`. Where two bores meet, a hole goes across a round bar, or one bar
leaves another, no face goes on that would part them. Three planes through the point where their axes meet leave eight
cells whose corners have three edges; planes half way between the points on one axis keep them apart.

Axes may pass each other: two planes go along one axis each, square to the other, the third lies half way through what
both cylinders have in common. At four points of the curve in which the cylinders meet it turns back, and each of these
lies on one of the planes, so every piece of it has its corners at its ends. Cylinders of one radius whose axes meet
touch at two points, where two curves cross; two planes between the axes, in which these lie, part the cells there.
A bore that ends inside of the other is carried on as a cylinder through the material, and a plane lies in its floor.

Slots (:mod:`.slots`) cross as bores do that are spread out (:mod:`.slot_crossings`).

Not handled: other cylinders that do not go all around, and those that only graze each other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace

from ...arrays import FloatArray
from ...brep import Face, Solid
from .axes import ALIKE, MEET, Axis
from .central import Cutter, plane_tool
from .slot_crossings import FAR, INSIDE, Plane, along_slots, is_one
from .slots import find_passages

GRAZE = 0.15
"""What two cylinders have in common between their axes, in radii of the smaller one, from which on they cross."""
OFF = 0.3
"""Distance of two axes, in radii of the smaller bore, from which on there is room between planes on both."""
BOTH = 0.6
"""The same, in radii of the wider one, up to which these two planes are enough."""
NEAR_FLOOR = 0.7
"""Distance of the floor of a bore from the axis of another, in its radii, up to which the plane along the axis lies in
the floor instead."""
PASSES = 0.1
"""Distance of a plane from a vertex of the curve in which two cylinders meet, in the smaller radius, from which on what
is left of the curve between them is an edge like any other. The vertex may be wherever the CAD program began."""
APART = 0.05
"""Distance of two points on an axis, in radii of it, from which a plane between them is worth it."""
FLAT = 1e-4
"""Radians from pi up to which two faces at an edge are one surface."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Crossing:
    """Cylinders about two lines that meet.

    Attributes
    ----------
    axes : (int, int)
        The widest about each line.
    lines : (int, int)
    on_axes : (2, 3) float64
        The points of the axes next to each other.
    square : (3,) float64
        Unit vector across both axes.
    common : (float, float)
        What all of the cylinders that meet have in common along `square`, from the first axis.
    """

    axes: tuple[int, int]
    lines: tuple[int, int]
    on_axes: FloatArray
    square: FloatArray
    common: tuple[float, float]

    @property
    def gap(self) -> float:
        """Distance of the second axis from the first, along `square`."""
        return float((self.on_axes[1] - self.on_axes[0]) @ self.square)

    def through(self, order: Sequence[int]) -> float:
        """A place well inside what the cylinders have in common, along `square`, from the first axis.

        On one of the axes where that may be, those first whose line comes first in an order; else half way.
        """
        low, high = self.common
        places = dict(zip(self.lines, (0.0, self.gap), strict=True))
        for line in sorted(self.lines, key=order.index):
            if low + INSIDE * (high - low) <= places[line] <= high - INSIDE * (high - low):
                return places[line]
        return 0.5 * (low + high)

    def shared(self, planes: Sequence[Plane]) -> float | None:
        """Place of a plane that is there already, where it lies well inside of what the cylinders have in common."""
        low, high = self.common
        margin = INSIDE * (high - low)
        places = [float((at - self.on_axes[0]) @ self.square) for normal, at in planes if is_one(normal, self.square)]
        return min((at for at in places if low + margin <= at <= high - margin), key=abs, default=None)


def find_crossings(axes: Sequence[Axis]) -> list[Crossing]:
    """List where cylinders meet, once for two lines, the smallest last."""
    found: dict[tuple[int, int], Crossing] = {}
    for pair in sorted(_near(axes), key=lambda pair: -sum(axes[k].radius for k in pair)):
        i, j = sorted(pair, key=lambda k: axes[k].line)
        lines = axes[i].line, axes[j].line
        met = _meeting(axes[i], axes[j])
        if met is None:
            continue
        on_axes, square, (low, high) = met
        known = found.get(lines)
        if known is None:
            found[lines] = Crossing(axes=(i, j), lines=lines, on_axes=on_axes, square=square, common=(low, high))
            continue
        if square @ known.square < 0.0:
            low, high = -high, -low
        if min(high, known.common[1]) > max(low, known.common[0]):
            found[lines] = replace(known, common=(max(low, known.common[0]), min(high, known.common[1])))
    return sorted(found.values(), key=lambda one: -min(axes[k].radius for k in one.axes))


def at_crossings(solid: Solid) -> list[Cutter]:
    """Planes between the points where axes meet, then planes through every one of them."""
    axes = find_passages(solid)
    points: dict[int, list[float]] = {}
    through: list[Cutter] = []
    crossings = find_crossings(axes)
    order = _order(axes, crossings)
    for crossing in crossings:
        a, b = (axes[i] for i in crossing.axes)
        for i, place in zip(crossing.axes, crossing.on_axes, strict=True):
            points.setdefault(i, []).append(float((place - axes[i].place) @ axes[i].direction))
        ends = _ends(solid, axes, crossing)
        floors = [[at for own in one.values() for at in own] for one in ends]
        if a.is_slot or b.is_slot:
            planes = along_slots(a, b, crossing.on_axes, crossing.square, ()) if not any(ends) else None
            if planes is None:
                continue
        else:
            middle = _middle(solid, axes, crossing, order)
            planes = _sides(a, b, crossing, middle, solid.size, floors=floors)
        tools = [plane_tool(solid, normal, place) for normal, place in planes]
        if is_joint(solid, a, b):
            tools += _extended(solid, min(a, b, key=lambda axis: axis.radius))
        tools += [tool for one in ends for i in one for tool in _extended(solid, axes[i])]
        through.append(
            Cutter(
                reason=f"planes where {a.label} and {b.label} cross",
                tools=tuple(tools),
                weight=min(a.radius, b.radius),
                # Through what goes another way these planes do harm: that is parted first, where it can be.
                leads=len(crossings) == 1 and all(axis.line in crossing.lines for axis in axes),
            )
        )
    return [*_between(solid, axes, points), *through]


def plain_planes(
    solid: Solid, axes: Sequence[Axis], crossings: Sequence[Crossing]
) -> list[list[tuple[FloatArray, FloatArray]]] | None:  # fmt: skip
    """Normals and places of the planes through every crossing; None where planes alone do not part one.

    Parameters
    ----------
    axes, crossings : sequence
        Of :func:`.slots.find_passages` and :func:`find_crossings`.
    """
    order = _order(axes, crossings)
    found: dict[Crossing, list[Plane]] = {}
    for crossing in sorted(crossings, key=lambda one: _freedom(axes, one)):
        a, b = (axes[i] for i in crossing.axes)
        if is_joint(solid, a, b) or any(_ends(solid, axes, crossing)):
            return None
        known = [plane for planes in found.values() for plane in planes]
        if a.is_slot or b.is_slot:
            slotted = along_slots(a, b, crossing.on_axes, crossing.square, known)
            if slotted is None:
                return None
            found[crossing] = slotted
            continue
        middle = crossing.shared(known)
        if middle is None:
            middle = _middle(solid, axes, crossing, order)
        planes = _sides(a, b, crossing, middle, solid.size, floors=((), ()))
        if OFF * min(a.radius, b.radius) < abs(crossing.gap) < BOTH * max(a.radius, b.radius):
            # With a plane on either axis no piece has more than a quarter of a wall.
            square = crossing.square
            planes = [plane for plane in planes if abs(float(plane[0] @ square)) < 0.5]
            planes += [(square, place) for place in crossing.on_axes]
        found[crossing] = planes
    return [found[crossing] for crossing in crossings]


def _freedom(axes: Sequence[Axis], crossing: Crossing) -> int:
    """Which crossings have to take planes of others, where they can: the ends of slots leave no choice, sides most."""
    slots = [axes[i] for i in crossing.axes if axes[i].is_slot]
    if not slots:
        return 1
    return 0 if any(any(slot.span(crossing.square)) for slot in slots) else 2


def _middle(solid: Solid, axes: Sequence[Axis], crossing: Crossing, order: Sequence[int]) -> float:
    """The place of the plane square to both axes; where it would pass by a vertex of the curve, through that."""
    middle = crossing.through(order)
    if middle in {0.0, crossing.gap}:
        return middle
    a, b = (axes[i] for i in crossing.axes)
    met = (e for e in solid.edges if any(e.faces[k] in a.faces and e.faces[1 - k] in b.faces for k in (0, 1)))
    ends = [solid.vertices[v] for e in met for v in (e.start, e.end)]
    places = [float((end - crossing.on_axes[0]) @ crossing.square) for end in ends]
    near = min(places, key=lambda place: abs(place - middle), default=np.inf)
    return near if abs(near - middle) < PASSES * min(a.radius, b.radius) else middle


def _order(axes: Sequence[Axis], crossings: Sequence[Crossing]) -> list[int]:
    """Lines of axes; what crosses one bore is parted by the same planes along it, so these come first."""
    met = Counter(line for crossing in crossings for line in crossing.lines)
    widest = {line: max(axis.radius for axis in axes if axis.line == line) for line in met}
    return sorted(met, key=lambda line: (-met[line], -widest[line], line))


def _ends(solid: Solid, axes: Sequence[Axis], crossing: Crossing) -> list[dict[int, list[FloatArray]]]:
    """For either line of a crossing the axes that end inside of the other bore, with their floors."""
    a, b = (axes[i] for i in crossing.axes)
    return [
        {i: at for i, axis in enumerate(axes) if axis.line == line and (at := _floors(solid, axis, other, place))}
        for line, other, place in zip(crossing.lines, (b, a), crossing.on_axes, strict=True)
    ]


def _floors(solid: Solid, axis: Axis, other: Axis, place: FloatArray) -> list[FloatArray]:
    """A point of every floor, of different height, at which a bore ends inside of the one that it crosses."""
    found: list[FloatArray] = []
    for edge in solid.edges:
        if edge.dihedral < pi + FLAT or abs((edge.midpoint - place) @ axis.direction) > other.radius:
            continue
        if any(edge.faces[k] in axis.faces and _is_across(solid.faces[edge.faces[1 - k]], axis) for k in (0, 1)):
            is_new = all(abs((edge.midpoint - at) @ axis.direction) > MEET * solid.size for at in found)
            found += [edge.midpoint] if is_new else []
    return found


def _is_across(face: Face, axis: Axis) -> bool:
    return face.kind == "plane" and abs(float(face.normal @ axis.direction)) > 1.0 - 1e-9


def _sides(
    a: Axis, b: Axis, crossing: Crossing, middle: float, size: float, *, floors: Sequence[Sequence[FloatArray]]
) -> list[tuple[FloatArray, FloatArray]]:  # fmt: skip
    """Normals and places of the planes that part a crossing, one of them at `middle` along the normal of both axes.

    The plane along one bore goes through the floor of the other, where that ends inside of the first.
    """
    on_a, on_b = crossing.on_axes
    square = crossing.square
    found = [(square, on_a + middle * square)]
    for axis, own, ends, other in ((a, on_a, floors[1], b), (b, on_b, floors[0], a)):
        normal = np.cross(square, axis.direction)
        near = [at for at in ends if abs((at - own) @ other.direction) < NEAR_FLOOR * axis.radius]
        found += [(normal, at) for at in ends]
        if not near:
            found.append((normal, own))
    gap = crossing.gap
    found += [
        (square, place)
        for axis, place, off in ((a, on_a, middle), (b, on_b, middle - gap))
        if abs(off) > FAR * axis.radius
    ]
    if abs(a.radius - b.radius) < ALIKE * a.radius and abs(gap) < MEET * size:
        found += [(a.direction + sign * b.direction, on_a) for sign in (-1.0, 1.0)]
    return [(normal / np.linalg.norm(normal), place) for normal, place in found]


def is_joint(solid: Solid, a: Axis, b: Axis) -> bool:
    """Whether bars meet in an inner corner: there is material on the inner side of both cylinders."""
    return any(
        edge.dihedral > pi + FLAT and any(edge.faces[k] in a.faces and edge.faces[1 - k] in b.faces for k in (0, 1))
        for edge in solid.edges
    )


def _extended(solid: Solid, axis: Axis) -> list[Any]:
    """A cylinder through all of the solid, its seams where it has them."""
    middle, reach = float((solid.vertices.mean(axis=0) - axis.place) @ axis.direction), 1.5 * solid.size
    ends = (middle - reach, middle + reach)
    return [BRepBuilderAPI_MakeFace(axis.cylinder, u, u + pi, *ends).Face() for u in (0.0, pi)]


def _between(solid: Solid, axes: list[Axis], points: dict[int, list[float]]) -> Iterator[Cutter]:
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


def _near(axes: Sequence[Axis]) -> list[tuple[int, int]]:
    """Pairs, first ones first, that are near enough to each other to meet: others of a thousand take seconds."""
    if not axes:
        return []
    radii = np.array([axis.radius for axis in axes])
    spread = np.array([np.linalg.norm(axis.spread) for axis in axes])
    reach = np.array([0.5 * (axis.high - axis.low) for axis in axes]) + 2.0 * radii + spread
    middles = np.array([axis.place + 0.5 * (axis.low + axis.high) * axis.direction for axis in axes])
    pairs: list[tuple[int, int]] = []
    for i in range(len(axes) - 1):
        far = np.linalg.norm(middles[i + 1 :] - middles[i], axis=1)
        near = np.flatnonzero(far <= (reach[i + 1 :] + reach[i]) * (1.0 + ALIKE))
        pairs += [(i, i + 1 + int(j)) for j in near]
    return pairs


def _meeting(a: Axis, b: Axis) -> tuple[FloatArray, FloatArray, tuple[float, float]] | None:
    """`on_axes`, `square` and `common` of a :class:`Crossing`; None where two cylinders do not meet, or only graze."""
    cosine = float(a.direction @ b.direction)
    if abs(cosine) > 1.0 - 1e-6:
        return None
    gap = b.place - a.place
    along_a, along_b = float(gap @ a.direction), float(gap @ b.direction)
    t = (along_a - cosine * along_b) / (1.0 - cosine**2)
    s = (cosine * along_a - along_b) / (1.0 - cosine**2)
    on_axes = np.array([a.place + t * a.direction, b.place + s * b.direction])
    if (a.is_slot or b.is_slot) and (abs(cosine) > 1e-6 or not (a.is_bore and b.is_bore)):
        return None  # a keyway is no crossing
    square = np.cross(a.direction, b.direction)
    square /= np.linalg.norm(square)
    apart = float((on_axes[1] - on_axes[0]) @ square)
    (below, above), (other_below, other_above) = a.span(square), b.span(square)
    low = max(below - a.radius, apart + other_below - b.radius)
    high = min(above + a.radius, apart + other_above + b.radius)
    if high - low < GRAZE * min(a.radius, b.radius):
        return None
    # A blind bore may end in the one it meets, before its axis.
    for axis, at, other in ((a, t, b), (b, s, a)):
        first, last = other.span(axis.direction)
        if not (axis.low - other.radius <= at + last and at + first <= axis.high + other.radius):
            return None
    return on_axes, square, (low, high)


__all__ = ["Crossing", "at_crossings", "find_crossings", "is_joint", "plain_planes"]
