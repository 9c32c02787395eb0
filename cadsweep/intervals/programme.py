"""The integer programme of the loops: counts near the wanted ones, given sums that vanish or are even.

Place in the flow: called by :mod:`.loops`. Classes that share no sum are solved apart. Where sums
only have to be even, every odd one is mended along the cheapest chain of classes to another odd sum
or to a class that occurs in no other sum; only where sums must vanish, ``scipy.optimize.milp`` runs.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush

import numpy as np
import scipy

from ..arrays import FloatArray, sparse
from ..disjoint import DisjointSets
from .balance import balance

_NEAR = 2.0
"""Segments more or less than wanted among which counts are looked for first."""
FREE = -1
"""The node that a class which occurs in one even sum alone leads to."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Programme:
    """Counts of classes 0 to n - 1.

    Attributes
    ----------
    want, weight : (n,) float64
        Wanted counts, and the price of one segment more or less.
    demanded : mapping of int to int
    firm : collection of int
        Classes whose wanted count is the user's.
    sums : sequence of mapping of int to float
        Class to coefficient; each sum must vanish.
    evens : sequence of mapping of int to int
        Class to an odd multiplicity; each sum must be even.
    least : mapping of int to int
        Least counts of classes that need more than one segment; what is demanded goes before it.
    """

    want: FloatArray
    weight: FloatArray
    demanded: Mapping[int, int]
    firm: Collection[int]
    sums: Sequence[Mapping[int, float]]
    evens: Sequence[Mapping[int, int]]
    least: Mapping[int, int] = field(default_factory=dict)

    def solve(self) -> list[int] | None:
        """Counts of all classes, None where there are none."""
        counts = [self.demanded.get(j, max(self.least.get(j, 1), round(w))) for j, w in enumerate(self.want)]
        for group, sums, evens in self._groups():
            found = None
            if not sums and all(sum(j in odd for odd in evens) <= 2 for j in group):
                found = self._mend(counts, evens)
            if found is None and (sums or evens):
                found = self._solve_group(group, sums, evens)
                if found is None:
                    return None
            for j, count in (found or {}).items():
                counts[j] = count
        return counts

    def _groups(self) -> Iterator[tuple[list[int], list[Mapping[int, float]], list[Mapping[int, int]]]]:
        """Classes that hang together, with their sums."""
        sets = DisjointSets(range(len(self.want)))
        for row in [*self.sums, *self.evens]:
            members = list(row)
            for j in members[1:]:
                sets.merge(j, members[0])
        groups: dict[int, tuple[list[int], list[Mapping[int, float]], list[Mapping[int, int]]]] = {}
        for j in range(len(self.want)):
            groups.setdefault(sets.find(j), ([], [], []))[0].append(j)
        for row in self.sums:
            groups[sets.find(next(iter(row)))][1].append(row)
        for odd in self.evens:
            groups[sets.find(next(iter(odd)))][2].append(odd)
        yield from groups.values()

    def _step(self, j: int, count: int) -> tuple[int, float]:
        """The cheaper of one segment more and one less for class j, and its price."""
        options = [
            (self.weight[j] * (abs(count + step - self.want[j]) - abs(count - self.want[j])), step)
            for step in (1, -1)
            if count + step >= self.least.get(j, 1)
        ]
        price, step = min(options)
        return step, max(float(price), 0.0)

    def _mend(self, start: Sequence[int], evens: Sequence[Mapping[int, int]]) -> dict[int, int] | None:
        """Make all sums even by steps of one along cheapest chains; None where that fails."""
        counts = {j: start[j] for odd in evens for j in odd}
        ends: dict[int, list[int]] = {}
        for k, odd in enumerate(evens):
            for j in odd:
                ends.setdefault(j, []).append(k)
        uneven = {k for k, odd in enumerate(evens) if sum(counts[j] for j in odd) % 2}
        while uneven:
            first = min(uneven)
            chain = self._chain(first, uneven - {first}, counts, evens, ends)
            if chain is None:
                return None
            last, path = chain
            for j in path:
                counts[j] += self._step(j, counts[j])[0]
            uneven -= {first, last}
        return counts

    def _chain(
        self,
        first: int,
        others: set[int],
        counts: Mapping[int, int],
        evens: Sequence[Mapping[int, int]],
        ends: Mapping[int, Sequence[int]],
    ) -> tuple[int, list[int]] | None:
        """Cheapest chain of classes from sum `first` to another uneven sum or out (Dijkstra)."""
        best: dict[int, float] = {first: 0.0}
        came: dict[int, tuple[int, int]] = {}
        heap = [(0.0, first)]
        while heap:
            price, k = heappop(heap)
            if k == FREE or k in others:
                path = []
                node = k
                while node != first:
                    node, j = came[node]
                    path.append(j)
                return k, path
            if price > best[k]:
                continue
            for j in evens[k]:
                if j in self.demanded:
                    continue
                far = FREE if len(ends[j]) == 1 else ends[j][ends[j][0] == k]
                total = price + self._step(j, counts[j])[1]
                if total < best.get(far, np.inf):
                    best[far] = total
                    came[far] = (k, j)
                    heappush(heap, (total, far))
        return None

    def _balanced(self, group: Sequence[int], sums: Sequence[Mapping[int, float]]) -> FloatArray:
        """Wanted counts, spread over the sums where the user asks for some of them."""
        want = self.want[list(group)]
        fixed = [k for k, j in enumerate(group) if j in self.demanded]
        firm = np.array([j in self.firm for j in group])
        if not sums or not (fixed or firm.any()):
            return want
        column = {j: k for k, j in enumerate(group)}
        rows = [{column[j]: value for j, value in row.items()} for row in sums] + [{k: 1.0} for k in fixed]
        totals = np.array([0.0] * len(sums) + [float(self.demanded[group[k]]) for k in fixed])
        return balance(want, firm, sparse(rows, len(group)), totals)

    def _solve_group(
        self, group: Sequence[int], sums: Sequence[Mapping[int, float]], evens: Sequence[Mapping[int, int]]
    ) -> dict[int, int] | None:
        """Counts by an integer programme.

        Each count is the next one below what is wanted, plus one or none, plus segments more, less
        segments fewer: prices then bend at integers alone, so that most programmes are solved by their
        relaxation. Unknowns are these three (n each) and the halves of the even sums.
        """
        n = len(group)
        column = {j: k for k, j in enumerate(group)}
        want, weight = self._balanced(group, sums), self.weight[list(group)]
        free = np.array([j not in self.demanded for j in group])
        least = np.array([self.demanded.get(j, self.least.get(j, 1)) for j in group], dtype=float)
        below = np.where(free, np.maximum(np.floor(want), least), least)
        up = np.clip(1.0 - 2.0 * (want - below), -1.0, 1.0)
        members = [{column[j]: float(v) for j, v in row.items()} for row in (*sums, *evens)]
        halves: list[dict[int, float]] = [{} for _ in sums] + [{3 * n + k: -2.0} for k in range(len(evens))]
        rows = [
            row | {n + k: v for k, v in row.items()} | {2 * n + k: -v for k, v in row.items()} | half
            for row, half in zip(members, halves, strict=True)
        ]
        total = np.array([-sum(v * below[k] for k, v in row.items()) for row in members])
        # Counts near the wanted ones do nearly always, and are found many times as fast among few.
        for most in (_NEAR, np.inf):
            steps = [free, np.where(free, most, 0.0), np.minimum(below - least, most), np.full(len(evens), np.inf)]
            result = scipy.optimize.milp(
                np.concatenate([weight * up, weight, weight, np.zeros(len(evens))]),
                integrality=np.ones(3 * n + len(evens)),
                bounds=scipy.optimize.Bounds(0.0, np.concatenate(steps)),
                constraints=scipy.optimize.LinearConstraint(sparse(rows, 3 * n + len(evens)), total, total),
                options={"time_limit": 10.0, "mip_rel_gap": 1e-2},
            )
            if result.x is not None:
                one, more, fewer = np.round(result.x[: 3 * n]).reshape(3, n)
                return {j: int(count) for j, count in zip(group, below + one + more - fewer, strict=True)}
        return None
