"""Layers: the counts of the edges along the sweep.

Place in the flow: second step of :mod:`cadsweep.intervals`. All vertices that edges along the
loops join lie on one *level*; the source cap is level 0, the target cap level ``n_layers``. An edge
along the sweep gets the difference of its two levels, so opposite sides of every linking side agree
by construction and only the levels are unknown: an integer programme over a few differences, whose
matrix is a network's.

Where a linking side is one face beside columns that are divided (a mitre seen from its plane side),
vertices that answer each other on its left and right are put on one level too, if that can be.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from ..errors import InputError
from ..topology import DirectedEdge, LinkingSide, Solid, Sweep
from .naming import name_edges

SAME_PLACE = 0.25
"""Vertices on opposite rails are put on one level where their fractions of the rail differ by less."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Levels:
    """Levels of the vertices of a sweep.

    Attributes
    ----------
    n : int
        Number of levels; 0 is the source, ``n - 1`` the target.
    rails : dict of int to (int, int)
        Lower and upper level of every edge along the sweep.
    """

    n: int
    rails: dict[int, tuple[int, int]]


def directed_ends(solid: Solid, directed: DirectedEdge) -> tuple[int, int]:
    """First and last vertex of a directed edge."""
    edge = solid.edges[directed[0]]
    return (edge.start, edge.end) if directed[1] else (edge.end, edge.start)


def find_levels(sweep: Sweep) -> Levels:
    """Group the vertices of a sweep into levels."""
    aligned = _levels(sweep, align=True)
    return aligned if aligned is not None and _heights(aligned) is not None else _must(_levels(sweep, align=False))


def _must(levels: Levels | None) -> Levels:
    assert levels is not None
    return levels


def _levels(sweep: Sweep, *, align: bool) -> Levels | None:
    solid = sweep.solid
    parent = list(range(len(solid.vertices)))

    def find(v: int) -> int:
        while parent[v] != v:
            parent[v] = parent[parent[v]]
            v = parent[v]
        return v

    def join(a: int, b: int) -> None:
        parent[find(a)] = find(b)

    for loops in (sweep.source_loops, sweep.target_loops):
        first = directed_ends(solid, loops[0][0])[0]
        for loop in loops:
            for d in loop:
                join(first, directed_ends(solid, d)[0])
    for side in sweep.linking_sides:
        for d in side.bottom + side.top:
            join(*directed_ends(solid, d))
        if align:
            for a, b in _answering(solid, side):
                join(a, b)
    source = find(directed_ends(solid, sweep.source_loops[0][0])[0])
    target = find(directed_ends(solid, sweep.target_loops[0][0])[0])
    number = {source: 0}
    rails: dict[int, tuple[int, int]] = {}
    for side in sweep.linking_sides:
        for d in side.left + side.right:
            low, high = (find(v) for v in directed_ends(solid, d))
            for level in (low, high):
                if level != target:
                    number.setdefault(level, len(number))
            rails[d[0]] = (low, high)
    number[target] = len(number)
    if source == target or any(low == high for low, high in rails.values()):
        return None
    return Levels(n=len(number), rails={e: (number[a], number[b]) for e, (a, b) in rails.items()})


def _answering(solid: Solid, side: LinkingSide) -> list[tuple[int, int]]:
    """Pairs of inner vertices of the left and right chain at about the same place."""
    if len(side.left) == 1 or len(side.left) != len(side.right):
        return []
    pairs = []
    for k in range(1, len(side.left)):
        place = [_fraction(solid, chain, k) for chain in (side.left, side.right)]
        if abs(place[0] - place[1]) < SAME_PLACE:
            pairs.append((directed_ends(solid, side.left[k])[0], directed_ends(solid, side.right[k])[0]))
    return pairs


def _fraction(solid: Solid, chain: Sequence[DirectedEdge], k: int) -> float:
    lengths = [solid.edges[e].length for e, _ in chain]
    return sum(lengths[:k]) / sum(lengths)


def _heights(levels: Levels) -> list[int] | None:
    """Least number of layers below every level; None where a level would have to lie above itself."""
    pairs = set(levels.rails.values())
    height = [0] * levels.n
    for _ in range(levels.n + 1):
        changed = False
        for low, high in pairs:
            if height[high] < height[low] + 1:
                height[high] = height[low] + 1
                changed = True
        if not changed:
            return height
    return None


def assign_layers(
    sweep: Sweep, *, n_wanted: float, n_fixed: int | None, wanted: dict[int, float], fixed: dict[int, int]
) -> tuple[dict[int, int], int]:
    """Choose the counts of all edges along the sweep.

    Parameters
    ----------
    n_wanted : float
        Layers wanted in all.
    n_fixed : int or None
        Layers demanded in all.
    wanted : dict of int to float
        Wanted counts of single rails; the others share the layers by length.
    fixed : dict of int to int
        Demanded counts of single rails.

    Returns
    -------
    dict of int to int, int
        Count of every rail, and the number of layers.

    Raises
    ------
    InputError
        Fewer layers than spans, or demands that contradict each other.
    """
    levels = find_levels(sweep)
    heights = _heights(levels)
    if heights is None:
        raise InputError("the stacked linking sides of this sweep contradict each other: no layer fits them all")
    least = max(heights[levels.n - 1], 1)
    if n_fixed is not None and n_fixed < least:
        raise InputError(f"layers={n_fixed} is fewer than the {least} spans of this sweep{_stations(sweep)}")
    n_start = max(float(least), n_wanted) if n_fixed is None else float(n_fixed)
    groups = _group_rails(sweep, levels, n_start, wanted)
    demands: dict[tuple[int, int], int] = {}
    for e, n in fixed.items():
        if e in levels.rails and demands.setdefault(levels.rails[e], n) != n:
            others = [k for k in fixed if levels.rails.get(k) == levels.rails[e]]
            raise InputError(f"{name_edges(sweep.solid, others)} need equal counts, and different ones are demanded")
    if levels.n == 2:
        n = demands.get((0, 1), n_fixed if n_fixed is not None else max(1, round(groups[0, 1])))
        if n_fixed is not None and n != n_fixed:
            raise InputError(f"layers={n_fixed}, but {name_edges(sweep.solid, list(fixed))} demand {n}")
        return dict.fromkeys(levels.rails, n), n
    place = _solve(levels.n, groups, demands, n_fixed, n_start)
    if place is None:
        raise InputError(
            f"no layers fit the counts demanded of {name_edges(sweep.solid, [e for e in fixed if e in levels.rails])}"
            + (f" with layers={n_fixed}" if n_fixed is not None else "")
            + _stations(sweep)
        )
    return {e: place[b] - place[a] for e, (a, b) in levels.rails.items()}, place[-1]


def _group_rails(
    sweep: Sweep, levels: Levels, n_layers: float, wanted: dict[int, float]
) -> dict[tuple[int, int], float]:
    """Mean wanted count between every pair of levels that a rail joins."""
    totals = {e: sum(ls) for loop, ls in zip(sweep.spans, sweep.span_lengths, strict=True) for s in loop for e in s}
    found: dict[tuple[int, int], list[float]] = {}
    demanded: dict[tuple[int, int], list[float]] = {}
    for e, pair in levels.rails.items():
        if e in wanted:
            demanded.setdefault(pair, []).append(wanted[e])
        found.setdefault(pair, []).append(n_layers * sweep.solid.edges[e].length / totals[e])
    groups = {pair: sum(values) / len(values) for pair, values in (found | demanded).items()}
    groups.setdefault((0, levels.n - 1), n_layers)
    return groups


def _solve(
    n: int,
    groups: dict[tuple[int, int], float],
    demands: dict[tuple[int, int], int],
    n_fixed: int | None,
    n_start: float,
) -> list[int] | None:
    """Place the levels: least sum of relative deviations from the wanted differences."""
    pairs = list(groups)
    n_pairs = len(pairs)
    A = np.zeros((2 * n_pairs, n + n_pairs))
    B = np.zeros((n_pairs, n + n_pairs))
    want = np.array([groups[p] for p in pairs])
    for i, (a, b) in enumerate(pairs):
        B[i, [a, b]] = -1.0, 1.0
        A[i, [a, b, n + i]] = -1.0, 1.0, -1.0
        A[n_pairs + i, [a, b, n + i]] = 1.0, -1.0, -1.0
    low = np.array([float(demands.get(p, 1)) for p in pairs])
    high = np.array([float(demands.get(p, np.inf)) for p in pairs])
    upper = np.full(n + n_pairs, np.inf)
    lower = np.zeros(n + n_pairs)
    upper[0] = 0.0
    if n_fixed is not None:
        lower[n - 1] = upper[n - 1] = n_fixed
    result = milp(
        np.concatenate([np.zeros(n), 1.0 / np.maximum(want, 1.0)]),
        integrality=np.concatenate([np.ones(n), np.zeros(n_pairs)]),
        bounds=Bounds(lower, upper),
        constraints=[
            LinearConstraint(csr_array(A), -np.inf, np.concatenate([want, -want])),
            LinearConstraint(csr_array(B), low, high),
        ],
        options={"time_limit": 10.0},
    )
    return None if result.x is None else [round(v) for v in result.x[:n]]


def _stations(sweep: Sweep) -> str:
    """Name the stations, for a message."""
    if not sweep.stations:
        return ""
    named = "; ".join(
        f"station {k + 1} of edges {', '.join(map(str, ring[:6]))}{', ...' if len(ring) > 6 else ''}"
        for k, ring in enumerate(sweep.stations)
    )
    return f", which a layer must meet: {named}"
