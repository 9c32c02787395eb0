"""What one class of rails settles by itself: states of faces that cannot be, and classes that must be along or across.

Place in the flow: :mod:`.bands` narrows the choices of each class, and :mod:`.choices` does with each state it tries.

Method: a state of a face names the classes that it has along the sweep; all others that meet the face run across it.
A state that says otherwise than what is known of a class is taken out, and a class that all states left of a face say
the same of is known: over and over, each face only when something has become known beside it. A face without a state
ends it. Which states are left of a face are the bits of a number: the same few sets of them come up again and again,
and what each says is read once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from .corners import Reading


@dataclass(frozen=True, kw_only=True, eq=False)
class State:
    """What a face may be.

    Attributes
    ----------
    read : tuple of Reading and int, or None
        As a linking side, its reading and which of its chains are rails; None where it is no linking side.
    along : frozenset of int
        Classes that are along the sweep then.
    on_face : frozenset of int
        All classes that meet the face.
    cost : float
    """

    read: tuple[Reading, int] | None
    along: frozenset[int]
    on_face: frozenset[int]
    cost: float


class _Left(NamedTuple):
    """What some states of a face have in common.

    Attributes
    ----------
    states : tuple of State
    news : tuple of (int, bool)
        Classes that all of them say the same of, and what.
    least : float
        Cost of the cheapest.
    """

    states: tuple[State, ...]
    news: tuple[tuple[int, bool], ...]
    least: float


class Open:
    """Faces of several states, and the classes that meet them: what stays as it is while they are narrowed.

    Parameters
    ----------
    states : mapping of int to sequence of State
        By face.
    pairs : iterable of (int, int)
        Classes of which one at most is along the sweep.
    """

    def __init__(self, states: Mapping[int, Sequence[State]], pairs: Iterable[tuple[int, int]]) -> None:
        self.states = {f: tuple(own) for f, own in states.items()}
        self.at_class: dict[int, list[int]] = {}
        self.with_along: dict[tuple[int, int], int] = {}
        for f, own in self.states.items():
            for k in own[0].on_face:
                self.at_class.setdefault(k, []).append(f)
                self.with_along[f, k] = sum(1 << j for j, state in enumerate(own) if k in state.along)
        self.rivals: dict[int, list[int]] = {}
        for a, b in pairs:
            self.rivals.setdefault(a, []).append(b)
            self.rivals.setdefault(b, []).append(a)
        self._read: dict[tuple[int, int], _Left] = {}

    def read(self, face: int, bits: int) -> _Left:
        """What the states of a face that are left have in common."""
        found = self._read.get((face, bits))
        if found is None:
            own = tuple(state for j, state in enumerate(self.states[face]) if bits >> j & 1)
            always = frozenset.intersection(*(state.along for state in own))
            never = own[0].on_face - frozenset.union(*(state.along for state in own))
            news = (*((k, True) for k in sorted(always)), *((k, False) for k in sorted(never)))
            found = self._read[face, bits] = _Left(own, news, min(state.cost for state in own))
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Narrowed:
    """What is left to choose.

    Attributes
    ----------
    open : Open
    said : dict of int to bool
        Classes that are known to be along the sweep, or not to be.
    bits : dict of int to int
        States that are left, by face.
    """

    open: Open
    said: Mapping[int, bool]
    bits: Mapping[int, int]

    @property
    def along(self) -> set[int]:
        """Classes that are known to be along the sweep."""
        return {k for k, is_along in self.said.items() if is_along}

    @property
    def states(self) -> dict[int, tuple[State, ...]]:
        """The states that are left, by face; one where nothing is open."""
        return {f: self.states_of(f) for f in self.bits}

    def states_of(self, face: int) -> tuple[State, ...]:
        """The states that are left of a face."""
        return self.open.read(face, self.bits[face]).states

    def least_of(self, face: int) -> float:
        """Cost of the cheapest state that is left of a face."""
        return self.open.read(face, self.bits[face]).least

    def linking_faces(self) -> list[int]:
        """Faces of several states that must be linking sides."""
        return [f for f, own in self.states.items() if len(own) > 1 and all(state.read is not None for state in own)]

    def taken(self, face: int, state: State) -> Narrowed | None:
        """What is left where a face is what one of its states says; None where nothing is."""
        bit = 1 << self.open.states[face].index(state)
        one = Narrowed(open=self.open, said=self.said, bits={**self.bits, face: bit})
        return one.told((k, k in state.along) for k in sorted(state.on_face))

    def told(self, news: Iterable[tuple[int, bool]]) -> Narrowed | None:
        """What is left where some classes are, or are not, along the sweep; None where nothing is."""
        said, bits = dict(self.said), dict(self.bits)
        at_class, with_along, rivals, read = self.open.at_class, self.open.with_along, self.open.rivals, self.open.read
        waiting = deque(news)
        while waiting:
            k, is_along = waiting.popleft()
            if k in said:
                if said[k] != is_along:
                    return None
                continue
            said[k] = is_along
            if is_along:
                waiting.extend((rival, False) for rival in rivals.get(k, []))
            for f in at_class.get(k, []):
                before, along = bits[f], with_along[f, k]
                own = before & along if is_along else before & ~along
                if not own:
                    return None
                if own != before:
                    bits[f] = own
                    waiting.extend(read(f, own).news)
        return Narrowed(open=self.open, said=said, bits=bits)


def narrow(states: Mapping[int, Sequence[State]], pairs: Iterable[tuple[int, int]]) -> Narrowed | None:
    """Take out what cannot be, whatever is along the sweep; None where nothing can. Arguments as of `Open`."""
    every = Open(states, pairs)
    bits = {f: (1 << len(own)) - 1 for f, own in every.states.items()}
    start = Narrowed(open=every, said={}, bits=bits)
    return start.told(each for f, own in bits.items() for each in every.read(f, own).news)
