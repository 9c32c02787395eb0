"""What is chosen for faces of several readings is the cheapest that agrees: held against trying everything."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from cadsweep.recognition.choices import STEP_COST, cheapest
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


def cheapest_of_all(states: dict[int, list[State]], pairs: list[tuple[int, int]], seed: int) -> float | None:
    """Least price of states that say the same of every class, the seed being along the sweep; None: there are none."""
    prices = []
    for chosen in product(*states.values()):
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
        wanted = cheapest_of_all(states, pairs, seed)
        left = start.told([(seed, True)])
        found = None if left is None else next(cheapest(left), None)
        if found is None:
            assert wanted is None
            continue
        assert left is not None
        chosen, reads = found
        settled = {f: own[0].read for f, own in left.states.items() if len(own) == 1}
        price = sum(read[0].cost for read in (settled | reads).values() if read is not None)
        assert price + STEP_COST * len(left.along | chosen) == pytest.approx(wanted)
