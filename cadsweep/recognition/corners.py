"""Logical corners: how a face can be read as a rectangle.

Place in the flow: first step of :mod:`cadsweep.recognition`. A linking side must be a logical
rectangle, so four of its vertices are *ends* (about 90 degrees) and all others *sides* (about 180
degrees). A reading is one such choice; its cost is the deviation of the measured angles from the
chosen ones. Most faces have one reasonable reading, some several: which of them holds is settled
for all faces together in :mod:`.bands`.

A *folded* reading also takes a vertex of 90 or 270 degrees for a side: a sheet bent sharply and
swept through its thickness has such faces. They are tried only where nothing else is found.

Not handled: faces that would have to be decomposed into several rectangles.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from math import comb, pi

from ..brep import Face

RIGHT = pi / 2
MAX_READINGS = 24
"""Choices of four corners of a face that are tried, the most rectangular first."""
MAX_CHOICES = 12
"""Choices beyond which a face has no corners to speak of: it looks like a circle."""
MAX_FOLDED_CHOICES = 500
"""Choices of corners of a folded face that are looked at; a face with more is no side."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """A face read as a rectangle.

    Attributes
    ----------
    chains : four tuples of int
        Edge ids of the four sides, in the direction and order of the face's loop.
    cost : float
        Sum of the deviations of all angles from those of a rectangle, in right angles.
    """

    chains: tuple[tuple[int, ...], ...]
    cost: float


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Angles, in degrees, within which a vertex may be an end or a side."""

    end_low: float
    end_high: float
    side_low: float
    side_high: float


STRICT = Limits(end_low=8.0, end_high=165.0, side_low=130.0, side_high=230.0)
QUADRANGLE = Limits(end_low=3.0, end_high=177.0, side_low=130.0, side_high=230.0)
FOLDED = Limits(end_low=3.0, end_high=186.0, side_low=45.0, side_high=315.0)


def read_rectangles(face: Face, *, folded: bool = False) -> tuple[Reading, ...]:
    """Return the readings of a face as a rectangle, cheapest first; none if it cannot be one.

    Parameters
    ----------
    face : Face
    folded : bool
        Allow sharp folds in the middle of a side, and ends whose edges are tangent.
    """
    if len(face.loops) != 1 or len(face.loops[0].edges) < 4:
        return ()
    loop = face.loops[0]
    n = len(loop.edges)
    limits = FOLDED if folded else (QUADRANGLE if n == 4 else STRICT)
    degrees = [a * 180.0 / pi for a in loop.angles]
    may_end = [limits.end_low <= a <= limits.end_high for a in degrees]
    may_side = [limits.side_low <= a <= limits.side_high for a in degrees]
    if not all(e or s for e, s in zip(may_end, may_side, strict=True)):
        return ()
    must = [i for i in range(n) if not may_side[i]]
    free = [i for i in range(n) if may_end[i] and may_side[i]]
    n_free = 4 - len(must)
    if n_free < 0 or n_free > len(free) or comb(len(free), n_free) > (MAX_FOLDED_CHOICES if folded else MAX_CHOICES):
        return ()

    as_end = [abs(a - RIGHT) / RIGHT for a in loop.angles]
    as_side = [abs(a - pi) / RIGHT for a in loop.angles]
    base = sum(as_side) + sum(as_end[i] - as_side[i] for i in must)
    choices = sorted(
        (base + sum(as_end[i] - as_side[i] for i in chosen), chosen) for chosen in combinations(free, n_free)
    )
    margin = 4.0 if folded else 1.4
    return tuple(
        Reading(chains=_cut(loop.edges, sorted((*must, *chosen))), cost=cost)
        for cost, chosen in choices[:MAX_READINGS]
        if cost <= choices[0][0] + margin
    )


def _cut(edges: tuple[int, ...], ends: list[int]) -> tuple[tuple[int, ...], ...]:
    """Cut the cycle of edges where the edges with the positions `ends` begin."""
    chains = []
    for a, b in zip(ends, [*ends[1:], ends[0] + len(edges)], strict=True):
        chains.append(tuple(edges[i % len(edges)] for i in range(a, b)))
    return tuple(chains)


def why_no_rectangle(face: Face) -> str:
    """Say why a face cannot be a linking side, as the end of a sentence about it."""
    if len(face.loops) > 1:
        n = len(face.loops) - 1
        return f"has {n} hole{'s' if n > 1 else ''} in it"
    angles = [a * 180.0 / pi for a in face.loops[0].angles]
    if len(angles) < 4:
        return f"has only {len(angles)} corners, hexes would collapse there"
    n_ends = sum(a < STRICT.side_low for a in angles)
    n_reentrant = sum(a > STRICT.side_high for a in angles)
    if n_reentrant:
        return f"has {n_reentrant} re-entrant corner{'s' if n_reentrant > 1 else ''}"
    if n_ends > 4:
        return f"has {n_ends} corners instead of 4"
    return f"has {len(angles)} vertices of which no 4 make the corners of a rectangle"
