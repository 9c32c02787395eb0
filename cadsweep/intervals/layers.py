"""Layers: the counts of the edges along the sweep.

Place in the flow: second step of :mod:`cadsweep.intervals`. An edge along the sweep gets the difference of the
places of its two levels (:mod:`.levels`), so opposite sides of every linking side agree by construction and only the
places are unknown: an integer programme over a few differences, whose matrix is a network's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import FloatArray
from ..errors import InputError
from ..sweep import Sweep
from .balance import FIRM, balance
from .demands import Demand, find_conflict, name_demands
from .levels import Levels, find_levels, n_least


def assign_layers(
    sweep: Sweep, *, n_wanted: float, n_fixed: int | None, wanted: dict[int, float], demands: Sequence[Demand]
) -> dict[int, tuple[int, int]]:
    """Choose between which layers every edge along the sweep runs.

    Parameters
    ----------
    n_wanted : float
        Layers wanted in all.
    n_fixed : int or None
        Layers demanded in all.
    wanted : dict of int to float
        Wanted counts of single rails; the others share the layers by length.
    demands : sequence of Demand
        Demanded counts of rails.

    Returns
    -------
    dict of int to (int, int)
        Node layers in which every rail begins and ends; the last of all is the number of layers.

    Raises
    ------
    InputError
        Fewer layers than spans, or demands that contradict each other or `n_fixed`.
    """
    choices = find_levels(sweep)
    if not choices:
        raise InputError("the stacked linking sides of this sweep contradict each other: no layer fits them all")
    for levels in choices:
        least = n_least(levels)
        if n_fixed is not None and n_fixed < least:
            continue
        n_start = max(float(least), n_wanted) if n_fixed is None else float(n_fixed)
        if levels.n == 2 and not demands and not wanted:
            n = n_fixed if n_fixed is not None else max(1, round(n_start))
            return dict.fromkeys(levels.rails, (0, n))
        # The total that the size asks for gives way to what the user asks of the spans.
        total = n_fixed is not None or not (demands or wanted)
        place = _place_levels(_make_problem(sweep, levels, n_start, wanted, total=total), demands, n_fixed)
        if place is not None:
            return {e: (place[a], place[b]) for e, (a, b) in levels.rails.items()}
    least = min(n_least(levels) for levels in choices)
    if n_fixed is not None and n_fixed < least:
        back = " (two where it turns back)" if any(max(levels.least.values()) > 1 for levels in choices) else ""
        raise InputError(
            f"layers={n_fixed} is fewer than the {least} that the spans of this sweep need{back}{_stations(sweep)}"
        )
    raise InputError(_contradiction(sweep, choices[-1], demands, n_fixed))


@dataclass(frozen=True, kw_only=True, eq=False)
class _Problem:
    """Levels to place: wanted differences of pairs of levels, and which of them the user has wished for."""

    levels: Levels
    pairs: list[tuple[int, int]]
    want: FloatArray
    firm: FloatArray


def _make_problem(sweep: Sweep, levels: Levels, n_layers: float, wanted: dict[int, float], *, total: bool) -> _Problem:
    """Mean wanted count between every pair of levels that a rail joins; `total`: and between the caps."""
    totals = {e: sum(ls) for loop, ls in zip(sweep.spans, sweep.span_lengths, strict=True) for s in loop for e in s}
    found: dict[tuple[int, int], list[float]] = {}
    wished: dict[tuple[int, int], list[float]] = {}
    for e, pair in levels.rails.items():
        if e in wanted:
            wished.setdefault(pair, []).append(wanted[e])
        found.setdefault(pair, []).append(n_layers * sweep.solid.edges[e].length / totals[e])
    groups = {pair: sum(values) / len(values) for pair, values in (found | wished).items()}
    if total:
        groups.setdefault((0, levels.n - 1), n_layers)
    return _Problem(
        levels=levels,
        pairs=list(groups),
        want=np.array(list(groups.values())),
        firm=np.array([pair in wished for pair in groups]),
    )


def _rows(levels: Levels, pairs: Sequence[Sequence[tuple[int, int]]]) -> FloatArray:
    """Sums of differences of levels (m, n), as a matrix on the places of the levels."""
    rows = np.zeros((len(pairs), levels.n))
    for i, row in enumerate(pairs):
        for a, b in row:
            rows[i, a] -= 1.0
            rows[i, b] += 1.0
    return rows


def _place_levels(problem: _Problem, demands: Sequence[Demand], n_fixed: int | None) -> list[int] | None:
    """Place the levels: least sum of relative deviations from the wanted differences; None where there is no way."""
    levels, want, firm = problem.levels, problem.want, problem.firm
    last = levels.n - 1
    differences = _rows(levels, [[pair] for pair in problem.pairs])
    demanded = _rows(levels, [[levels.rails[e] for e in demand.edges] for demand in demands])
    counts = np.array([float(demand.count) for demand in demands])
    if demands or firm.any():
        fixed = np.eye(levels.n)[[0] if n_fixed is None else [0, last]]
        want = balance(
            differences,
            np.maximum(want, 1.0),
            firm,
            np.vstack([demanded, fixed]),
            np.concatenate([counts, [0.0] if n_fixed is None else [0.0, float(n_fixed)]]),
        )
    n, n_pairs = levels.n, len(want)
    apart = np.hstack([differences, np.zeros((n_pairs, n_pairs))])
    slack = np.hstack([np.zeros((n_pairs, n)), np.eye(n_pairs)])
    constraints = [
        scipy.optimize.LinearConstraint(scipy.sparse.csr_array(apart - slack), -np.inf, want),
        scipy.optimize.LinearConstraint(scipy.sparse.csr_array(-apart - slack), -np.inf, -want),
        scipy.optimize.LinearConstraint(
            scipy.sparse.csr_array(apart), [levels.least.get(pair, 1) for pair in problem.pairs], np.inf
        ),
    ]
    if demands:
        both = np.hstack([demanded, np.zeros((len(demands), n_pairs))])
        constraints.append(scipy.optimize.LinearConstraint(scipy.sparse.csr_array(both), counts, counts))
    upper, lower = np.full(n + n_pairs, np.inf), np.zeros(n + n_pairs)
    upper[0] = 0.0
    if n_fixed is not None:
        lower[last] = upper[last] = n_fixed
    result = scipy.optimize.milp(
        np.concatenate([np.zeros(n), np.where(firm, FIRM, 1.0) / np.maximum(want, 1.0)]),
        integrality=np.concatenate([np.ones(n), np.zeros(n_pairs)]),
        bounds=scipy.optimize.Bounds(lower, upper),
        constraints=constraints,
        options={"time_limit": 10.0},
    )
    return None if result.x is None else [round(v) for v in result.x[:n]]


def _contradiction(sweep: Sweep, levels: Levels, demands: Sequence[Demand], n_fixed: int | None) -> str:
    """Say which demands contradict each other."""
    problem = _make_problem(sweep, levels, float(levels.n), {}, total=False)
    if n_fixed is not None and _place_levels(problem, demands, None) is None:
        n_fixed = None  # they contradict each other whatever the total
    guilty = find_conflict(demands, lambda some: _place_levels(problem, some, n_fixed) is not None)
    beside = "" if n_fixed is None else f" with {n_fixed} layers in all"
    return (
        f"no layers fit the counts demanded{beside}: {name_demands(sweep.solid, guilty)}; edges along the "
        "sweep between the same stations need equal sums, and the spans from source to target add up to all layers"
        f"{_stations(sweep)}; change or drop one of them"
    )


def _stations(sweep: Sweep) -> str:
    """Name the stations, for a message."""
    if not sweep.stations:
        return ""
    named = "; ".join(
        f"station {k + 1} of edges {', '.join(map(str, ring[:6]))}{', ...' if len(ring) > 6 else ''}"
        for k, ring in enumerate(sweep.stations)
    )
    return f"; a layer must meet {named}"
