"""The cheapest choices of what faces of several readings are: small integer programmes.

Place in the flow: :mod:`.bands` asks it for what :mod:`.narrowing` leaves open.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy

from ..arrays import FloatArray
from .corners import Reading
from .narrowing import Narrowed

STEP_COST = 1e-3
"""Price of one more class in a band: nothing joins a band that is not needed there."""
TIE = 0.5
"""Right angles by which another choice of corners may be worse than the best and is still tried."""
MAX_SOLUTIONS = 4
"""Ways to read the sides of one band that are kept, the cheapest first; each costs an integer programme."""


def cheapest(
    left: Narrowed,
) -> Iterator[tuple[set[int], dict[int, tuple[Reading, int] | None]]]:
    """Classes along the sweep, and what each open face is, of the cheapest choices among what is left open.

    A programme has the faces that must be linking sides, and those only that its own answers run into: what no class
    along the sweep meets is no linking side, and costs nothing.
    """
    faces = dict.fromkeys(left.linking_faces())
    forbidden: list[list[tuple[int, int]]] = []
    best = np.inf
    while len(forbidden) < MAX_SOLUTIONS:
        answer = _choose(left, list(faces), forbidden)
        if answer is None or answer.cost > best + TIE:
            return
        beside = {f: None for k in answer.along for f in left.at_class[k] if len(left.states[f]) > 1}
        if beside.keys() - faces.keys():
            faces |= beside
            continue
        best = min(best, answer.cost)
        reads = {f: left.states[f][j].read for f, j in answer.states}
        yield answer.along, reads
        # next time one of these faces must be read otherwise
        forbidden.append([(f, j) for f, j in answer.states if reads[f] is not None])
        if not forbidden[-1]:
            return


class _Answer(NamedTuple):
    """Classes along the sweep, the number of each face's state, and what that costs."""

    along: set[int]
    states: list[tuple[int, int]]
    cost: float


def _choose(left: Narrowed, faces: list[int], forbidden: list[list[tuple[int, int]]]) -> _Answer | None:
    """The cheapest states of some faces, but for choices that are forbidden as a whole; None where there are none."""
    if not faces:
        return None if forbidden else _Answer(set(), [], 0.0)
    known = left.along | left.across
    classes = sorted({k for f in faces for k in left.states[f][0].on_face} - known)
    column = {k: j for j, k in enumerate(classes)}
    cost = [STEP_COST] * len(classes)
    unknown: dict[tuple[int, int], int] = {}
    rows: list[dict[int, float]] = []
    right: list[float] = []
    for f in faces:
        agree = {k: {column[k]: -1.0} for k in sorted(left.states[f][0].on_face - known)}
        one: dict[int, float] = {}
        for j, state in enumerate(left.states[f]):
            at = unknown[f, j] = len(cost)
            one[at] = 1.0
            for k in state.along & agree.keys():
                agree[k][at] = 1.0
            cost.append(state.cost)
        rows += [one, *agree.values()]
        right += [1.0] + [0.0] * len(agree)
    n_equal = len(rows)
    rows += [{column[a]: 1.0, column[b]: 1.0} for a in classes for b in left.rivals.get(a, []) if a < b and b in column]
    right += [1.0] * (len(rows) - n_equal)
    rows += [{unknown[choice]: 1.0 for choice in choices} for choices in forbidden]
    right += [len(choices) - 1.0 for choices in forbidden]
    prices = np.array(cost)
    on = _solve(prices, rows, np.array(right), n_equal)
    if on is None:
        return None
    return _Answer(
        {k for k in classes if on[column[k]]}, [c for c, at in unknown.items() if on[at]], float(prices @ on)
    )


def _solve(
    cost: FloatArray, rows: list[dict[int, float]], bound: FloatArray, n_equal: int
) -> npt.NDArray[np.bool_] | None:
    """Least cost of binary unknowns: the first `n_equal` rows equal their bound, others stay below."""
    entries = [(r, c, v) for r, row in enumerate(rows) for c, v in row.items()]
    r, c, v = (np.array(x) for x in zip(*entries, strict=True))
    result = scipy.optimize.milp(
        cost,
        integrality=np.ones(len(cost)),
        bounds=scipy.optimize.Bounds(0.0, 1.0),
        constraints=scipy.optimize.LinearConstraint(
            scipy.sparse.csr_array((v, (r, c)), shape=(len(rows), len(cost))),
            np.where(np.arange(len(rows)) < n_equal, bound, -np.inf),
            bound,
        ),
    )
    return None if result.x is None else result.x > 0.5
