"""The cheapest choices of what faces of several readings are, followed one face at a time.

Place in the flow: :mod:`.bands` asks it for what :mod:`.narrowing` leaves open.

Method: of what is left, the face with the fewest states is given each of them, and what follows is narrowed
again (:meth:`.Narrowed.taken`). What costs least so far goes first, the least that open faces still need included, so
that the first choice with nothing left open is the cheapest there is, the next one the second, and so on.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from heapq import heappop, heappush
from itertools import count
from math import fsum, inf
from typing import NamedTuple

from .corners import Reading
from .narrowing import Narrowed, State

log = logging.getLogger(__name__)

STEP_COST = 1e-3
"""Price of one more class in a band: nothing joins a band that is not needed there."""
TIE = 0.5
"""Right angles by which another choice of corners may be worse than the best and is still tried."""
MAX_SOLUTIONS = 4
"""Ways to read the sides of one band that are kept, the cheapest first."""
MAX_TRIED = 5_000
"""Partial choices that are followed for one band before what was found so far is taken for all there is; no part that
is known needs more than some hundred."""

MAX_TRIED_OF_ALL = 20_000
"""Partial choices that are followed for all bands of a solid together; no part that is known needs more than 3,000."""
FEW_TRIED = 50
"""Partial choices that are followed for a band in any case."""

Choice = dict[int, tuple[Reading, int] | None]


class Tries:
    """How many partial choices may still be followed for all bands of a solid."""

    def __init__(self) -> None:
        self.left = MAX_TRIED_OF_ALL

    def for_band(self) -> Iterator[int]:
        """Count those of one band."""
        for n in range(min(MAX_TRIED, max(FEW_TRIED, self.left))):
            self.left -= 1
            yield n


def cheapest(left: Narrowed, tries: Tries) -> Iterator[tuple[set[int], Choice]]:
    """Classes along the sweep, and what each open face is, of the cheapest choices among what is left open.

    Faces that must be linking sides are chosen, and those that their own classes run into: what no class
    along the sweep meets is no linking side, and costs nothing. No choice has all the linking sides of one before it.
    """
    found: list[set[tuple[int, State]]] = []
    best = inf
    numbers = count()
    # A choice waits twice: as what is to be narrowed, by the least it can cost, and narrowed. Of the same price that
    # goes first in which less is open, then the one that was made first.
    start = _Step(left, frozenset(left.linking_faces()))
    waiting: list[tuple[float, float, int, _Step, tuple[int, State] | None]] = [
        (_least(left, start), 0, next(numbers), start, None)
    ]
    for _ in tries.for_band():
        if not waiting:
            return
        cost, _, number, step, taken = heappop(waiting)
        if cost > best + TIE:
            return
        if taken is not None:
            after = _taken(left, step, *taken)
            if after is not None:
                n_open = sum(after.at.bits[f].bit_count() - left.bits[f].bit_count() for f in after.reached)
                heappush(waiting, (_least(left, after), n_open, number, after, None))
            continue
        own = {f: step.at.states_of(f) for f in sorted(step.reached)}
        sides = {f: states[0] for f, states in own.items() if len(states) == 1 and states[0].read is not None}
        if any(before <= sides.items() for before in found):
            continue
        must = [f for f, states in own.items() if len(states) > 1 and all(s.read is not None for s in states)]
        if not must:
            best = min(best, cost)
            found.append(set(sides.items()))
            yield step.at.along - left.along, {f: state.read for f, state in sides.items()}
            if len(found) == MAX_SOLUTIONS or not sides:
                return
            continue
        face = min(must, key=lambda f: len(own[f]))
        least = min(state.cost for state in own[face])
        for state in own[face]:
            heappush(waiting, (cost - least + state.cost, -inf, next(numbers), step, (face, state)))
    log.debug("choices of %d faces are not followed to the end", len(left.bits))


class _Step(NamedTuple):
    """What is left after some choices, and the faces that were open at first and are, or may be, linking sides now."""

    at: Narrowed
    reached: frozenset[int]


def _taken(left: Narrowed, step: _Step, face: int, state: State) -> _Step | None:
    """A step further: one face is what one of its states says; None where that cannot be."""
    at = step.at.taken(face, state)
    if at is None:
        return None
    known = at.said.keys() - step.at.said.keys()
    beside = (f for k in known for f in at.open.at_class[k] if left.bits[f].bit_count() > 1)
    return _Step(at, step.reached.union(beside))


def _least(left: Narrowed, step: _Step) -> float:
    """What a choice costs at least, compared with what was left at first."""
    at = step.at
    n_along = sum(at.said.values()) - sum(left.said.values())
    return fsum(at.least_of(f) for f in step.reached) + STEP_COST * n_along
