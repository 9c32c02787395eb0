"""Loops: the counts of the edges along the loops and inside the caps.

Place in the flow: third step of :mod:`cadsweep.intervals`. Edges that must have equal counts (single
edges at the bottom and top of a linking side, inner edges of the caps that answer each other) are
one unknown. What is left are the sides whose bottom or top are several edges, and the loops of the
source cap's faces, whose sums must be even for a mesh of quads alone. One integer programme finds
the counts nearest to the wanted ones, in the sum of relative deviations.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise
from math import pi

import numpy as np

from ..brep import Face, Loop, Solid, quarter_turns
from ..sweep import DirectedEdge, Sweep
from .symmetry import find_symmetry, needs_even_sides, symmetric_pairs

SAME_PLACE = 0.1
"""Vertices in the bottom and the top of a side are joined where their fractions differ by less."""

STRAIGHT = 5.0 * pi / 6.0
"""Angle from which a vertex of a cap's face is taken for straight."""
UNEQUAL = 1.6
"""Ratio of wanted counts up to which opposite sides of a four-sided cap get equal ones."""
SAME_COUNT = 1e-6
"""Relative difference of wanted counts that rounding explains: the edges are of one length."""
EVEN = 1.15
"""Ratio of wanted counts up to which the ways there and back of an L, a T or a cross get equal ones: they are equal
but for what rounds the counts, unless its sides lean."""
UNEQUAL_WALL = 2.5
"""Ratio of wanted counts up to which the loops of a wall without corners get equal ones."""


def loop_edges(sweep: Sweep) -> list[int]:
    """All edges that are not along the sweep, ids in ascending order."""
    rails = set(sweep.rails)
    return [edge.id for edge in sweep.solid.edges if edge.id not in rails]


def opposite_sides(loops: Sequence[Loop], wanted: dict[int, float]) -> list[tuple[list[int], list[int]]]:
    """Opposite sides of a four-sided face of the cap; none where their wanted counts are far apart.

    Equal counts there let the face be filled with a regular grid.
    """
    if len(loops) != 1:
        return []
    loop = loops[0]
    corners = [k for k, angle in enumerate(loop.angles) if angle < STRAIGHT]
    if len(corners) != 4 or max(loop.angles) > 2.0 * pi - STRAIGHT:
        return []
    n = len(loop.edges)
    ends = [*corners, corners[0] + n]
    sides = [[loop.edges[k % n] for k in range(ends[i], ends[i + 1])] for i in range(4)]
    totals = [sum(wanted[e] for e in side) for side in sides]
    if any(max(a, b) > UNEQUAL * min(a, b) for a, b in (totals[0::2], totals[1::2])):
        return []
    return [(sides[0], sides[2]), (sides[1], sides[3])]


def submapped_sides(loops: Sequence[Loop], wanted: dict[int, float]) -> list[tuple[list[int], list[int]]]:
    """Edges of a cap that run one way and those that run back, where all its corners are right or re-entrant ones.

    Equal sums there let an L, a T or a plate with holes be filled with a regular grid. None where the wanted counts
    are far from it, and none for four corners without holes, which are :func:`opposite_sides`' concern.
    """
    pairs: list[tuple[list[int], list[int]]] = []
    for loop in loops:
        turns = quarter_turns(loop.angles)
        if turns is None or (len(loops) == 1 and turns.count(1) <= 4):
            return []
        if loop is not loops[0] and not any(turns):
            continue  # a round hole
        if sum(turns) != (4 if loop is loops[0] else -4):
            return []
        ways: list[list[int]] = [[], [], [], []]
        way = 0
        for edge, turn in zip(loop.edges, turns, strict=True):
            way += turn
            ways[way % 4].append(edge)
        totals = [sum(wanted[e] for e in edges) for edges in ways]
        if any(max(totals[k], totals[k + 2]) > EVEN * min(totals[k], totals[k + 2]) for k in (0, 1)):
            return []
        pairs += [(ways[0], ways[2]), (ways[1], ways[3])]
        # Edges of one length, too: what is symmetric is to stay so where the counts are rounded.
        for one, back in ((ways[0], ways[2]), (ways[1], ways[3])):
            ordered = sorted([*one, *back], key=lambda e: wanted[e])
            pairs += [([a], [b]) for a, b in pairwise(ordered) if wanted[b] - wanted[a] < SAME_COUNT * wanted[b]]
    return pairs


def _fan_corners(face: Face) -> list[int]:
    """Places of the corners of a flat face that may be filled with grids meeting in its middle; none of other faces."""
    loops = face.loops
    if face.kind != "plane":
        return []
    corners = [k for k, angle in enumerate(loops[0].angles) if angle < STRAIGHT]
    if len(loops) != 1 or len(corners) not in {3, 5, 6} or max(loops[0].angles) > 2.0 * pi - STRAIGHT:
        return []
    return corners


def fan_sides(face: Face, wanted: dict[int, float]) -> list[tuple[list[int], list[int]]]:
    """Pairs of edges of one length of a face of three, five or six corners: its middle stays in the middle."""
    ordered = sorted(face.loops[0].edges, key=lambda e: wanted[e]) if _fan_corners(face) else []
    return [([a], [b]) for a, b in pairwise(ordered) if wanted[b] - wanted[a] < SAME_COUNT * wanted[b]]


def symmetric_sides(solid: Solid, face: int, wanted: dict[int, float]) -> list[tuple[list[int], list[int]]]:
    """Pairs of edges of a face of the cap that its symmetry carries to each other."""
    symmetry = find_symmetry(solid, solid.faces[face])
    return [] if symmetry is None else symmetric_pairs(symmetry, wanted, SAME_COUNT)


def even_by_symmetry(solid: Solid, face: int) -> list[list[int]]:
    """Sets of edges of a face of the cap that must be even, each together, so that its quads can be symmetric."""
    symmetry = find_symmetry(solid, solid.faces[face])
    if symmetry is None or not needs_even_sides(solid.faces[face], symmetry):
        return []
    return symmetry.even_sets()


def every_second_side(face: Face) -> list[list[int]]:
    """Edges of every second side of a face of six corners: an even sum there lets grids meet in its middle."""
    corners, edges = _fan_corners(face), face.loops[0].edges
    if len(corners) != 6:
        return []
    n = len(edges)
    ends = [*corners, corners[0] + n]
    return [[edges[k % n] for i in (0, 2, 4) for k in range(ends[i], ends[i + 1])]]


def across_wall(sweep: Sweep, face: int, wanted: dict[int, float]) -> list[tuple[list[int], list[int]]]:
    """The two loops of a wall without corners, such as a tube's; none where their wanted counts are far apart.

    Equal counts there let the wall be filled with rings of quads. On the way to the target they stay beside
    each other only if the rings between, too, are divided alike inside and outside.
    """
    solid = sweep.solid
    loops = solid.faces[face].loops
    if len(loops) != 2 or any(not STRAIGHT < a < 2.0 * pi - STRAIGHT for loop in loops for a in loop.angles):
        return []
    outer, hole = (list(loop.edges) for loop in loops)
    totals = [sum(wanted[e] for e in loop) for loop in (outer, hole)]
    if max(totals) > UNEQUAL_WALL * min(totals):
        return []
    pairs = _beside(solid, outer, hole) or [(outer, hole)]
    rings = [_rings_over(sweep, loop) for loop in (outer, hole)]
    if len(rings[0]) == len(rings[1]):
        pairs += [pair for one, other in zip(*rings, strict=True) for pair in _beside(solid, one, other)]
    return pairs


def squeezes(one: Sequence[int], other: Sequence[int], wanted: dict[int, float], wished: Collection[int]) -> bool:
    """Whether equal sums of two loops would leave edges without a wish too few segments for those with one.

    A bore that has its size all around says how many segments the rim gets: if the rim's corners have theirs, too, all
    that is missing would be taken from the straight edges between them.
    """
    for a, b in ((one, other), (other, one)):
        free = sum(wanted[e] for e in a if e not in wished)
        if free and all(e in wished for e in b):
            left = sum(wanted[e] for e in b) - sum(wanted[e] for e in a if e in wished)
            if EVEN * left < free:
                return True
    return False


def _beside(solid: Solid, outer: Sequence[int], hole: Sequence[int]) -> list[tuple[list[int], list[int]]]:
    """Edges of two rings that lie beside each other, where every edge has its own; none else."""
    middles = np.array([solid.edges[e].midpoint for e in hole])
    nearest = [int(np.argmin(np.linalg.norm(middles - solid.edges[e].midpoint, axis=1))) for e in outer]
    if not len(outer) == len(hole) == len(set(nearest)):
        return []
    return [([e], [hole[j]]) for e, j in zip(outer, nearest, strict=True)]


def _rings_over(sweep: Sweep, edges: Sequence[int]) -> list[list[int]]:
    """The rings of edges over a loop of the source: its stations in order, and the loop of the target."""
    loop = next((j for j, one in enumerate(sweep.source_loops) if {e for e, _ in one} == set(edges)), None)
    if loop is None:
        return []
    ends = [{v for e in span for v in _vertices(sweep.solid, e)} for span in sweep.spans[loop]]
    rings = []
    for below, above in pairwise(ends):
        for ring in sweep.stations:
            own = {v for e in ring for v in _vertices(sweep.solid, e)}
            if own & below and own & above:  # not always at one vertex: rails may end beside those that go on
                rings.append(list(ring))
    return [*rings, [e for e, _ in sweep.target_loops[loop]]]


def _vertices(solid: Solid, edge: int) -> set[int]:
    return {solid.edges[edge].start, solid.edges[edge].end}


def alike(solid: Solid, bottom: Sequence[DirectedEdge], top: Sequence[DirectedEdge]) -> bool:
    """Whether two chains of several edges have their vertices at about the same places."""
    places = []
    for chain in (bottom, top):
        lengths = np.array([solid.edges[e].length for e, _ in chain])
        places.append(np.cumsum(lengths) / lengths.sum())
    return bool(np.abs(places[0] - places[1]).max() < SAME_PLACE)


def least_counts(solid: Solid, faces: Collection[int]) -> dict[int, int]:
    """Segments that the edges of loops of less than four edges need, so that quads fit into them."""
    least: dict[int, int] = {}
    for loop in (loop for f in faces for loop in solid.faces[f].loops):
        n = -(-4 // len(loop.edges))
        if n > 1:
            least |= {e: max(least.get(e, 1), n) for e in loop.edges}
    return least
