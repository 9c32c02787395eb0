"""Polygons of a plane graph: faces traced from directed edges, with their holes.

Place in the flow: used by :mod:`.dividing` for the pieces of a face along a line, and for the face of a cut.

Method: every directed edge has the region on its left. At a vertex the boundary of that region goes on with the next
edge clockwise from where it came. Loops that turn counter-clockwise are outlines, the others holes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from math import atan2, pi

from .vectors import Vector, cross, dot, minus, plus, times, unit

Loop = tuple[int, ...]
"""Vertices of a closed polygon, in order."""
Flat = tuple[float, float]


class TracingError(Exception):
    """The directed edges close to no regions."""


def area_vector(points: Sequence[Vector]) -> tuple[Vector, Vector]:
    """Area times normal of a closed polygon, and its first point."""
    base = points[0]
    total = (0.0, 0.0, 0.0)
    for a, b in pairwise(points[1:]):
        total = plus(total, cross(minus(a, base), minus(b, base)))
    return times(0.5, total), base


def basis(normal: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors that span the plane, right-handed with the normal."""
    least = min(range(3), key=lambda k: abs(normal[k]))
    axis = (float(least == 0), float(least == 1), float(least == 2))
    first = unit(cross(axis, normal))
    return first, cross(normal, first)


def flattened(points: Sequence[Vector], vertices: Iterable[int], normal: Vector) -> dict[int, Flat]:
    """Coordinates in the plane of a normal."""
    one, other = basis(normal)
    return {v: (dot(points[v], one), dot(points[v], other)) for v in vertices}


def is_inside(point: Flat, loops: Iterable[Sequence[Flat]]) -> bool:
    """Whether a point lies inside an odd number of loops."""
    x, y = point
    inside = False
    for loop in loops:
        for (x0, y0), (x1, y1) in zip(loop, [*loop[1:], loop[0]], strict=True):
            if (y0 > y) != (y1 > y) and x < x0 + (y - y0) * (x1 - x0) / (y1 - y0):
                inside = not inside
    return inside


def trace(pairs: Iterable[tuple[int, int]], flat: Mapping[int, Flat]) -> list[list[Loop]]:
    """Regions on the left of directed edges.

    Parameters
    ----------
    pairs : iterable of (int, int)
        Directed edges, each with a region on its left.
    flat : mapping
        Plane coordinates of every vertex.

    Returns
    -------
    list of list of tuple of int
        For every region its loops, the outer one first.

    Raises
    ------
    TracingError
        An edge leads nowhere, a loop has two vertices, or a hole lies in no outline.
    """
    leaving: dict[int, list[int]] = {}
    left = set(pairs)
    for a, b in left:
        leaving.setdefault(a, []).append(b)
    outer: list[Loop] = []
    holes: list[Loop] = []
    while left:
        first = min(left)
        left.discard(first)
        loop = [first[0]]
        a, b = first
        while b != first[0] or _next(a, b, leaving, flat) != first[1]:
            c = _next(a, b, leaving, flat)
            if (b, c) not in left:
                raise TracingError("a loop does not close")
            left.discard((b, c))
            loop.append(b)
            a, b = b, c
        if len(loop) < 3:
            raise TracingError("a loop of two edges")
        (outer if _signed_area([flat[v] for v in loop]) > 0 else holes).append(tuple(loop))
    regions = [[loop] for loop in outer]
    for hole in holes:
        x, y = ((flat[hole[0]][k] + flat[hole[1]][k]) / 2.0 for k in (0, 1))
        around = [r for r in regions if is_inside((x, y), [[flat[v] for v in r[0]]])]
        if not around:
            raise TracingError("a hole in nothing")
        min(around, key=lambda r: _signed_area([flat[v] for v in r[0]])).append(hole)
    return regions


def _next(a: int, b: int, leaving: Mapping[int, Sequence[int]], flat: Mapping[int, Flat]) -> int:
    """Where the boundary goes on from edge a to b."""
    choices = leaving.get(b, ())
    if not choices:
        raise TracingError("an edge leads nowhere")
    if len(choices) == 1:
        return choices[0]
    back = _heading(flat[b], flat[a])
    return min(choices, key=lambda c: (back - _heading(flat[b], flat[c]) - 1e-9) % (2.0 * pi))


def _heading(start: Flat, end: Flat) -> float:
    return atan2(end[1] - start[1], end[0] - start[0])


def _signed_area(points: Sequence[Flat]) -> float:
    return 0.5 * sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(points, [*points[1:], points[0]], strict=True))


__all__ = ["Loop", "TracingError", "area_vector", "basis", "flattened", "is_inside", "trace"]
