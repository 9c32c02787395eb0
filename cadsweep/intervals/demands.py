"""Counts that a user demands, and which of them contradict each other.

Place in the flow: used by :mod:`.whole`, which knows what is feasible.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

_Demand = TypeVar("_Demand")


def find_conflict(demands: Sequence[_Demand], is_feasible: Callable[[Sequence[_Demand]], bool]) -> list[_Demand]:
    """Find demands that contradict each other, none of which could be left out.

    Parameters
    ----------
    demands : sequence
        Not feasible together.
    is_feasible : callable
        Whether demands can be met together.

    Returns
    -------
    list
        Empty where nothing is feasible even without demands.

    References
    ----------
    Junker, "QuickXplain: preferred explanations and relaxations for over-constrained problems", AAAI 2004.
    """

    def explain(base: Sequence[_Demand], changed: bool, rest: Sequence[_Demand]) -> list[_Demand]:
        if changed and not is_feasible(base):
            return []
        if len(rest) == 1:
            return list(rest)
        half = len(rest) // 2
        second = explain([*base, *rest[:half]], True, rest[half:])
        first = explain([*base, *second], bool(second), rest[:half])
        return first + second

    if not demands or not is_feasible([]):
        return []
    return explain([], False, demands)
