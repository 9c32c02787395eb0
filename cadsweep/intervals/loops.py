"""Loops: the counts of the edges along the loops and inside the caps.

Place in the flow: third step of :mod:`cadsweep.intervals`. Edges that must have equal counts (single
edges at the bottom and top of a linking side, inner edges of the caps that answer each other) are
one unknown. What is left are the sides whose bottom or top are several edges, and the loops of the
source cap's faces, whose sums must be even for a mesh of quads alone. One integer programme finds
the counts nearest to the wanted ones, in the sum of relative deviations.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from ..errors import SurfaceMeshError
from ..topology import DirectedEdge, Solid, Sweep
from .naming import name_edges

SAME_PLACE = 0.1
"""Vertices in the bottom and the top of a side are joined where their fractions differ by less."""


def loop_edges(sweep: Sweep) -> list[int]:
    """All edges that are not along the sweep, ids in ascending order."""
    rails = set(sweep.rails)
    return [edge.id for edge in sweep.solid.edges if edge.id not in rails]


def assign_loops(sweep: Sweep, *, wanted: dict[int, float], fixed: dict[int, int]) -> dict[int, int]:
    """Choose the counts of all edges that are not along the sweep.

    Parameters
    ----------
    wanted : dict of int to float
        Wanted count of every one of these edges.
    fixed : dict of int to int
        Demanded counts.

    Raises
    ------
    SurfaceMeshError
        The demanded counts contradict each other; names the edges.
    """
    for align in (True, False):
        classes, sums = _tie(sweep, wanted, align=align)
        members: dict[int, list[int]] = {}
        for e, c in classes.items():
            members.setdefault(c, []).append(e)
        demanded: dict[int, int] = {}
        clash = ""
        for e, n in fixed.items():
            if e in classes and demanded.setdefault(classes[e], n) != n:
                clash = name_edges(sweep.solid, [k for k in fixed if classes.get(k) == classes[e]])
        if clash and not align:
            raise SurfaceMeshError(f"{clash} must have equal counts, and different ones are demanded")
        if clash:
            continue
        evens = _even_sums(sweep, classes)
        column = {c: j for j, c in enumerate(members)}
        counts = _solve(column, members, wanted, demanded, sums, evens)
        if counts is not None:
            return {e: counts[column[c]] for e, c in classes.items()}
    named = [e for e in fixed if e in wanted]
    if named:
        raise SurfaceMeshError(
            f"no mesh of quads has the counts demanded of {name_edges(sweep.solid, named)}: opposite sides of a "
            "linking side must have equal sums and the loops of the source cap even ones; change or drop one of them"
        )
    sides = [e for row in sums for e in row]
    raise SurfaceMeshError(
        f"no counts fit the linking sides along {name_edges(sweep.solid, [members[c][0] for c in sides])}"
    )


def _tie(sweep: Sweep, edges: dict[int, float], *, align: bool) -> tuple[dict[int, int], list[dict[int, float]]]:
    """Classes of edges of equal count, and the sums over classes that must vanish."""
    parent = {e: e for e in edges}

    def find(e: int) -> int:
        while parent[e] != e:
            parent[e] = parent[parent[e]]
            e = parent[e]
        return e

    several = []
    for side in sweep.linking_sides:
        bottom, top = side.bottom, side.top
        if len(bottom) == len(top) and (len(bottom) == 1 or (align and _alike(sweep.solid, bottom, top))):
            for (a, _), (b, _) in zip(bottom, top, strict=True):
                parent[find(a)] = find(b)
        else:
            several.append(side)
    for a, (b, _) in sweep.target_edges.items():
        parent[find(a)] = find(b)
    sums = []
    for side in several:
        row: dict[int, float] = {}
        for sign, chain in ((1.0, side.bottom), (-1.0, side.top)):
            for e, _ in chain:
                row[find(e)] = row.get(find(e), 0.0) + sign
        row = {c: v for c, v in row.items() if v}
        if row:
            sums.append(row)
    return {e: find(e) for e in edges}, sums


def _alike(solid: Solid, bottom: Sequence[DirectedEdge], top: Sequence[DirectedEdge]) -> bool:
    """Whether two chains of several edges have their vertices at about the same places."""
    places = []
    for chain in (bottom, top):
        lengths = np.array([solid.edges[e].length for e, _ in chain])
        places.append(np.cumsum(lengths) / lengths.sum())
    return bool(np.abs(places[0] - places[1]).max() < SAME_PLACE)


def _even_sums(sweep: Sweep, classes: dict[int, int]) -> list[dict[int, int]]:
    """For every loop of every face of the source cap: how often each class occurs in it."""
    rows = []
    for f in sweep.source:
        for loop in sweep.solid.faces[f].loops:
            row: dict[int, int] = {}
            for e in loop.edges:
                row[classes[e]] = row.get(classes[e], 0) + 1
            odd = {c: n for c, n in row.items() if n % 2}
            if odd:
                rows.append(odd)
    return rows


def _solve(
    column: dict[int, int],
    members: dict[int, list[int]],
    wanted: dict[int, float],
    demanded: dict[int, int],
    sums: list[dict[int, float]],
    evens: list[dict[int, int]],
) -> list[int] | None:
    """Counts of all classes; None where there are none.

    Unknowns: counts (n), deviations (n), halves of the even sums.
    """
    n = len(column)
    want = np.array([np.exp(np.mean(np.log([wanted[e] for e in members[c]]))) for c in column])
    n_columns = 2 * n + len(evens)
    rows: list[dict[int, float]] = []
    low: list[float] = []
    high: list[float] = []
    for j in range(n):
        rows += [{j: 1.0, n + j: -1.0}, {j: -1.0, n + j: -1.0}]
        low += [-np.inf, -np.inf]
        high += [want[j], -want[j]]
    for row in sums:
        rows.append({column[c]: v for c, v in row.items()})
        low.append(0.0)
        high.append(0.0)
    for k, odd in enumerate(evens):
        rows.append({column[c]: float(v) for c, v in odd.items()} | {2 * n + k: -2.0})
        low.append(0.0)
        high.append(0.0)
    lower = np.concatenate([np.ones(n), np.zeros(n_columns - n)])
    upper = np.full(n_columns, np.inf)
    for c, value in demanded.items():
        lower[column[c]] = upper[column[c]] = value
    weight = np.array([len(members[c]) for c in column]) / want
    cost = np.concatenate([np.zeros(n), weight, np.zeros(len(evens))])
    whole = np.concatenate([np.ones(n), np.zeros(n), np.ones(len(evens))])
    entries = [(i, j, v) for i, row in enumerate(rows) for j, v in row.items()]
    i, j, v = (np.array(x) for x in zip(*entries, strict=True))
    result = milp(
        cost,
        integrality=whole,
        bounds=Bounds(lower, upper),
        constraints=LinearConstraint(csr_array((v, (i, j)), shape=(len(rows), n_columns)), low, high),
        options={"time_limit": 10.0, "mip_rel_gap": 1e-3},
    )
    return None if result.x is None else [round(x) for x in result.x[:n]]
