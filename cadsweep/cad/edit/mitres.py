"""Mitre planes where bars or tubes of equal radii meet: tees, crosses, Y-pieces.

Place in the flow: candidates of :mod:`.cutters`, for cells where round arms come together in one point.

Method. Cylinders of one radius whose axes meet cross in plane curves, in the planes half way between the arms. Half of
each such plane, from the middle outwards, bounds two arms; half of the plane through an arm's own axis, square to that
of all axes, makes two halves of it, each swept along the arm from its end to one mitre::

         |   :   |            `:` planes along the arms, `\\` and `/` mitres,
         |   :   |            between arms opposite to each other a plane square to both.
         |_  :  _|
           \\ : /
     ....... *  .......       The bores of tubes end on the same mitres where they are alike, too.
             :
     ________:__________

Not handled: arms of unlike radii, which meet in curves that no plane holds (:mod:`.crossings`); arms whose axes lie in
no one plane.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, pi, sin
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid
from .axes import ALIKE, MEET, Axis, find_axes
from .central import Cutter, rectangle_tool
from .crossings import Crossing, find_crossings, is_joint

BEYOND = 1.25
"""How far a mitre goes, as a multiple of where the arms part."""
FLATTEST = 0.2
"""Radians between two arms at least."""


@dataclass(frozen=True, kw_only=True)
class _Arm:
    """A bar from where it meets the others to its end: its angle in the plane of all axes, and its radius."""

    angle: float
    radius: float


def at_mitres(solid: Solid) -> list[Cutter]:
    """Mitre planes and planes along the arms, for every point in which arms of equal radii meet."""
    axes = find_axes(solid)
    crossings = find_crossings(axes)
    return list(_cutters(solid, axes, crossings))


def _cutters(solid: Solid, axes: Sequence[Axis], crossings: Sequence[Crossing]) -> Iterator[Cutter]:
    taken: list[Crossing] = []
    for crossing in crossings:
        if any(known is crossing for known in taken) or not _is_mitred(solid, axes, crossing):
            continue
        same = [
            other
            for other in crossings
            if abs(abs(other.square @ crossing.square) - 1.0) < ALIKE
            and np.linalg.norm(other.on_axes[0] - crossing.on_axes[0]) < MEET * solid.size
            and _is_mitred(solid, axes, other)
        ]
        taken += same
        lines = {line for one in same for line in one.lines}
        tools = _tools(solid, [axis for axis in axes if axis.line in lines], crossing)
        if tools:
            a, b = (axes[i] for i in crossing.axes)
            yield Cutter(
                reason=f"mitre planes where {a.label} and {b.label} meet",
                tools=tuple(tools),
                weight=solid.size,
                leads=True,
            )


def _is_mitred(solid: Solid, axes: Sequence[Axis], crossing: Crossing) -> bool:
    """Whether bars meet there in one point, and every cylinder of one has its like in the other."""
    a, b = (axes[i] for i in crossing.axes)
    if abs(crossing.gap) > MEET * solid.size or not is_joint(solid, a, b):
        return False
    radii = [
        sorted(axis.radius for axis in axes if axis.line == line and _reaches(axis, crossing, k))
        for k, line in enumerate(crossing.lines)
    ]
    if not all(radii) or len(radii[0]) != len(radii[1]):
        return False
    return all(abs(r - s) < ALIKE * r for r, s in zip(*radii, strict=True))


def _reaches(axis: Axis, crossing: Crossing, which: int) -> bool:
    """Whether a cylinder goes as far as the point where the axes meet."""
    at = float((crossing.on_axes[which] - axis.place) @ axis.direction)
    return axis.low - axis.radius < at < axis.high + axis.radius


def _tools(solid: Solid, axes: Sequence[Axis], crossing: Crossing) -> list[Any]:
    """Half planes from the line through the middle, square to all axes; none where two arms are too close."""
    square, middle = crossing.square, crossing.on_axes[0]
    x = axes[0].direction
    frame = np.array([x, np.cross(square, x), square])
    arms: dict[int, _Arm] = {}
    for axis in axes:
        at = float((middle - axis.place) @ axis.direction)
        for sign, length in ((1.0, axis.high - at), (-1.0, at - axis.low)):
            # What ends in the middle of the others, or before it, is no arm that way.
            if length < axis.radius * BEYOND:
                continue
            u, v, _ = sign * (frame @ axis.direction)
            angle = atan2(v, u) % (2.0 * pi)
            known = next((k for k, arm in arms.items() if _between(arm.angle, angle) < ALIKE), len(arms))
            if known not in arms or arms[known].radius < axis.radius:
                arms[known] = _Arm(angle=angle, radius=axis.radius)
    ordered = sorted(arms.values(), key=lambda arm: arm.angle)
    if len(ordered) < 3:
        return []
    around = [*ordered, _Arm(angle=ordered[0].angle + 2.0 * pi, radius=ordered[0].radius)]
    reach = 1.5 * solid.size
    tools = [_half_plane(frame, middle, arm.angle, reach, reach) for arm in ordered]
    for one, other in pairwise(around):
        opening = other.angle - one.angle
        if opening < FLATTEST:
            return []
        far = BEYOND * one.radius / sin(0.5 * min(opening, pi))
        tools.append(_half_plane(frame, middle, 0.5 * (one.angle + other.angle), far, BEYOND * one.radius))
    return tools


def _between(one: float, other: float) -> float:
    """Angle between two directions, radians."""
    return abs((one - other + pi) % (2.0 * pi) - pi)


def _half_plane(frame: FloatArray, middle: FloatArray, angle: float, far: float, aside: float) -> Any:
    """A rectangle from the line through the middle outwards."""
    outwards = cos(angle) * frame[0] + sin(angle) * frame[1]
    normal = np.cross(outwards, frame[2])
    return rectangle_tool(middle, normal, outwards, (0.0, far), (-aside, aside))


__all__ = ["at_mitres"]
