"""Vectors of three as tuples: what the search multiplies is far too small for arrays.

Place in the flow: used by the planar complex (:mod:`.planar`, :mod:`.tracing`, :mod:`.dividing`). A cross product of
tuples takes a fiftieth of numpy's.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import atan2, pi, sqrt

Vector = tuple[float, float, float]


def plus(a: Vector, b: Vector) -> Vector:
    """Sum."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def minus(a: Vector, b: Vector) -> Vector:
    """Difference."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def times(s: float, a: Vector) -> Vector:
    """Product with a number."""
    return (s * a[0], s * a[1], s * a[2])


def dot(a: Vector, b: Vector) -> float:
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Outer product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def norm(a: Vector) -> float:
    """Length."""
    return sqrt(dot(a, a))


def unit(a: Vector) -> Vector:
    """The vector, one long."""
    return times(1.0 / norm(a), a)


def distance(a: Vector, b: Vector) -> float:
    """Distance of two points."""
    return norm(minus(a, b))


def between(a: Vector, b: Vector, share: float) -> Vector:
    """The point at a share of the way from a to b."""
    return (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2]))


def to_vector(values: Iterable[float]) -> Vector:
    """Three numbers of an array."""
    x, y, z = values
    return (float(x), float(y), float(z))


def turn(start: Vector, towards: Vector, direction: Vector) -> float:
    """Angle in [0, 2 pi) of a direction in the plane of two unit vectors square to each other, from the first."""
    return atan2(dot(direction, towards), dot(direction, start)) % (2.0 * pi)
