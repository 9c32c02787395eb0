"""Planes where a slot crosses a bore or another slot.

Place in the flow: :mod:`.crossings` asks for them where :mod:`.slots` found what crosses to be one.

Method: a slot is a bore that is spread out. Where the bore across it ends in its flat sides, planes beside the bore
leave cells that are swept along the bore. Where the bore goes on beyond an end, that is parted as a crossing of two
bores is: planes through the middle of both, and one along the axis of the end::

        |           :          |
    ----+-----------:----------+----      through the axis of the end
        |        . -:- .       |
        |     (  bore   )      |
        |        ' -:- '       |
    ----+---+       :      +---+----      beside the bore, through the flat sides
        |   |     slot     |   |

Not handled: slots of which each is spread out across both axes, bores that end in a round end next to the flat sides,
and those that take the tip of an end away alone.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...arrays import FloatArray
from .axes import Axis

INSIDE = 0.25
"""Share of what two cylinders have in common that lies on either side of a plane through it, at least."""
FAR = 0.5
"""Distance of the plane through what two cylinders have in common from the axis of one, in radii of it, from which on a
plane goes through the axis, too: on one side of both less than a quarter more than half of the wall would be left."""
WIDTHS = (0.35, 0.2)
"""Distance of a plane from the side of a bore that ends in the flat sides of a slot, in its radius."""
BENT = 0.4
"""Distance of that plane from where a slot's flat sides end, in the radius of its end, up to which both are flat."""
TIGHT = 1e-6
"""Share of a length up to which a place lies on its end."""
AT_TIP = 0.25
"""Distance of a plane from the tip of a slot, in the radius of its end, below which it is as good as tangent there."""
AT_SIDE = 0.1
"""Distance of a plane through a slot's end from the side of the bore, in its radius, below which it is as good as
tangent there."""

Plane = tuple[FloatArray, FloatArray]
"""Normal and place."""


def is_one(normal: FloatArray, other: FloatArray) -> bool:
    """Whether two planes have one normal."""
    return abs(float(normal @ other)) > 1.0 - 1e-9


def along_slots(
    a: Axis, b: Axis, on_axes: FloatArray, square: FloatArray, known: Sequence[Plane]
) -> list[Plane] | None:  # fmt: skip
    """List the planes that part a crossing; None where they are not known.

    Parameters
    ----------
    a, b : Axis
        At least one of them a slot.
    on_axes : (2, 3) float64
        Points of their axes next to each other.
    square : (3,) float64
        Unit vector across both axes.
    known : sequence of Plane
        Those of other crossings, taken where they fit.
    """
    on_a, on_b = on_axes
    if any(b.span(square)):
        a, b, on_a, on_b = b, a, on_b, on_a
    if any(b.span(square)):
        return None
    at, there = float(on_b @ square), [float(place @ square) for normal, place in known if is_one(normal, square)]
    is_between = False
    if any(a.span(square)):
        ends = [float(on_a @ square) + shift for shift in a.span(square)]
        read = [_at_end(sign * end, a.radius, sign * at, b.radius) for end, sign in zip(ends, (-1, 1), strict=True)]
        if any(own is None for own in read):
            return None
        levels = [sign * level for own, sign in zip(read, (-1.0, 1.0), strict=True) for level in own or ()]
        is_between = not levels
        for end, sign, own in zip(ends, (-1.0, 1.0), read, strict=True):
            levels += [] if own else _beside(sign * end, a.radius, b.radius, (at, sign), (levels, there))
    else:
        levels = [_in_common(float(on_a @ square), a.radius, at, b.radius, there)]
    found = [(square, on_b + (level - at) * square) for level in levels]
    if is_between:
        return found  # what ends in the flat sides alone is swept along itself
    for axis, own, other in ((a, on_a, b), (b, on_b, a)):
        found += [(other.direction, own + shift * other.direction) for shift in sorted(set(axis.span(other.direction)))]
    return found


def _in_common(at: float, radius: float, other: float, width: float, there: Sequence[float]) -> float:
    """A place well inside of what two cylinders have in common: of a plane that is there, else on one of the axes."""
    low, high = max(at - radius, other - width), min(at + radius, other + width)
    margin = (INSIDE - TIGHT) * (high - low)
    return next((place for place in (*there, at, other) if low + margin <= place <= high - margin), 0.5 * (low + high))


def _at_end(end: float, radius: float, at: float, width: float) -> list[float] | None:
    """Places of planes at an end of a slot, in the direction from its middle to this end.

    Parameters
    ----------
    end, radius : float
        Place of the end's axis, and its radius.
    at, width : float
        Those of the bore.

    Returns
    -------
    list of float or None
        None of them where the bore ends before, in what is flat or nearly so; None where it ends in what is bent, or
        where the end's axis does not go through the bore: rims that are carried on leave better cells there.
    """
    low, high = at - width, at + width
    if high + WIDTHS[-1] * width <= end + BENT * radius:
        return []
    if high < end + INSIDE * width:
        return None
    tip = end + radius
    if end < low + AT_SIDE * width:
        return None
    levels = [end]
    if at - end > FAR * width:
        levels.append(max(at, tip + AT_TIP * radius) if abs(at - tip) < AT_TIP * radius else at)
    return levels


def _beside(
    end: float, radius: float, width: float, side: tuple[float, float], there: tuple[Sequence[float], Sequence[float]]
) -> list[float]:  # fmt: skip
    """The plane beside a bore that ends before the end of a slot; none where one of its own lies there already.

    Parameters
    ----------
    end, radius : float
        As in :func:`_at_end`.
    width : float
        Radius of the bore.
    side : (float, float)
        Place of the bore's axis, and the sign of the direction to the end.
    there : (sequence of float, sequence of float)
        Planes of this crossing, and of others.
    """
    at, sign = side
    high, most = sign * at + width, end + BENT * radius
    if any(high + WIDTHS[-1] * width <= sign * level <= most for level in there[0]):
        return []
    near = [sign * level for level in there[1] if high + WIDTHS[-1] * width <= sign * level <= most]
    wanted = next(level for level in (high + share * width for share in WIDTHS) if level <= most)
    return [sign * min(near, default=wanted)]


__all__ = ["FAR", "INSIDE", "Plane", "along_slots", "is_one"]
