"""What is chosen for faces of several readings is the cheapest that agrees, one after the other: all are tried."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from cadsweep.recognition.choices import (
    FEW_TRIED,
    MAX_SOLUTIONS,
    MAX_TRIED,
    MAX_TRIED_OF_ALL,
    STEP_COST,
    TIE,
    Tries,
    cheapest,
)
from cadsweep.recognition.corners import Reading
from cadsweep.recognition.narrowing import State, narrow


def random_states(random: np.random.Generator, n_faces: int, n_classes: int) -> dict[int, list[State]]:
    """Faces that meet some classes, each with states of its own price, and that of no linking side."""
    states: dict[int, list[State]] = {}
    for f in range(n_faces):
        on_face = frozenset(random.choice(n_classes, size=random.integers(2, 5), replace=False).tolist())
        own = [State(read=None, along=frozenset(), on_face=on_face, cost=0.0)]
        for _ in range(int(random.integers(1, 5))):
            along = frozenset(k for k in on_face if random.random() < 0.5)
            cost = float(random.integers(1, 5)) + 0.01 * random.random()
            own.append(
                State(read=(Reading(chains=((), (), (), ()), cost=cost), 0), along=along, on_face=on_face, cost=cost)
            )
        states[f] = own
    return states


Sides = frozenset[tuple[int, object]]
"""Faces that are linking sides, and how they are read."""


def cheapest_of_all(
    states: dict[int, list[State]], pairs: list[tuple[int, int]], seed: int, before: list[Sides]
) -> float | None:
    """Least price of states that say the same of every class, the seed being along the sweep; None: there are none.

    Choices that have all the linking sides of one `before` do not count.
    """
    prices = []
    for chosen in product(*states.values()):
        sides = {(f, state.read) for f, state in zip(states, chosen, strict=True) if state.read}
        if any(old <= sides for old in before):
            continue
        along = frozenset.union(*(state.along for state in chosen))
        agree = all(state.along == along & state.on_face for state in chosen)
        if agree and seed in along and not any(a in along and b in along for a, b in pairs):
            prices.append(sum(state.cost for state in chosen) + STEP_COST * len(along))
    return min(prices, default=None)


@pytest.mark.parametrize("number", range(12))
def test_choices_are_the_cheapest_of_all(number):
    random = np.random.default_rng(number)
    states = random_states(random, n_faces=5, n_classes=7)
    pairs = [(0, 1), (2, 5)]
    start = narrow(states, pairs)
    assert start is not None, "no linking side at all is a choice"
    for seed in sorted({k for own in states.values() for k in own[0].on_face}):
        left = start.told([(seed, True)])
        found = [] if left is None else list(cheapest(left, Tries()))
        before: list[Sides] = []
        for chosen, reads in found:
            settled = {f: own[0].read for f, own in left.states.items() if len(own) == 1}
            sides = {f: read for f, read in (settled | reads).items() if read is not None}
            price = sum(read[0].cost for read in sides.values())
            wanted = cheapest_of_all(states, pairs, seed, before)
            assert price + STEP_COST * len(left.along | chosen) == pytest.approx(wanted)
            before.append(frozenset(sides.items()))
        if len(found) < MAX_SOLUTIONS:
            dearer = cheapest_of_all(states, pairs, seed, before)
            assert dearer is None or (found and dearer > first_price(states, pairs, seed) + TIE)


def first_price(states: dict[int, list[State]], pairs: list[tuple[int, int]], seed: int) -> float:
    """Least price of all choices."""
    price = cheapest_of_all(states, pairs, seed, [])
    assert price is not None
    return price


def test_what_all_bands_of_a_solid_may_try_is_bounded() -> None:
    tries = Tries()
    counts = [sum(1 for _ in tries.for_band()) for _ in range(10)]
    assert counts[0] == MAX_TRIED  # one band takes no more than its own
    assert sum(counts) <= MAX_TRIED_OF_ALL + 10 * FEW_TRIED  # and all together no more than the solid's, but for
    assert counts[-1] == FEW_TRIED  # a few, without which a band that is clear would not be found
