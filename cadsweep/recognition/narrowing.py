"""What one class of rails settles by itself: states of faces that cannot be, and classes that must be along or across.

Place in the flow: :mod:`.bands` narrows the choices of each class, and :mod:`.choices` does with each state it tries.

Method: a state of a face names the classes that it has along the sweep; all others that meet the face run across it.
A state that says otherwise than what is known of a class is taken out, and a class that all states left of a face say
the same of is known: over and over, each face only when something has become known beside it. A face without a state
ends it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

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


@dataclass(frozen=True, kw_only=True, eq=False)
class Narrowed:
    """What is left to choose.

    Attributes
    ----------
    along, across : set of int
        Classes that are known to be along the sweep, and those known not to be.
    states : dict of int to list of State
        By face; one where nothing is open.
    at_class : mapping of int to list of int
        Faces that each class meets.
    rivals : mapping of int to list of int
        Classes that are not along the sweep where one is.
    """

    along: set[int]
    across: set[int]
    states: dict[int, list[State]]
    at_class: Mapping[int, list[int]]
    rivals: Mapping[int, list[int]]

    def linking_faces(self) -> list[int]:
        """Faces of several states that must be linking sides."""
        return [f for f, own in self.states.items() if len(own) > 1 and all(state.read is not None for state in own)]

    def taken(self, face: int, state: State) -> Narrowed | None:
        """What is left where a face is what one of its states says; None where nothing is."""
        one = replace(self, states=self.states | {face: [state]})
        return one.told((k, k in state.along) for k in state.on_face)

    def told(self, news: Iterable[tuple[int, bool]]) -> Narrowed | None:
        """What is left where some classes are, or are not, along the sweep; None where nothing is."""
        said = dict.fromkeys(self.along, True) | dict.fromkeys(self.across, False)
        states = dict(self.states)
        waiting = deque(news)
        while waiting:
            k, is_along = waiting.popleft()
            if k in said:
                if said[k] != is_along:
                    return None
                continue
            said[k] = is_along
            if is_along:
                waiting.extend((rival, False) for rival in self.rivals.get(k, []))
            for f in self.at_class.get(k, []):
                own = states[f] = [state for state in states[f] if (k in state.along) == is_along]
                if not own:
                    return None
                waiting.extend(each for each in _settled(own) if each[0] not in said)
        along = {k for k, is_along in said.items() if is_along}
        return replace(self, along=along, across=said.keys() - along, states=states)


def narrow(states: Mapping[int, Sequence[State]], pairs: Iterable[tuple[int, int]]) -> Narrowed | None:
    """Take out what cannot be, whatever is along the sweep; None where nothing can.

    Parameters
    ----------
    states : mapping of int to sequence of State
        By face.
    pairs : iterable of (int, int)
        Classes of which one at most is along the sweep.
    """
    at_class: dict[int, list[int]] = {}
    for f, own in states.items():
        for k in own[0].on_face:
            at_class.setdefault(k, []).append(f)
    rivals: dict[int, list[int]] = {}
    for a, b in pairs:
        rivals.setdefault(a, []).append(b)
        rivals.setdefault(b, []).append(a)
    every = {f: list(own) for f, own in states.items()}
    start = Narrowed(along=set(), across=set(), states=every, at_class=at_class, rivals=rivals)
    return start.told(each for own in every.values() for each in _settled(own))


def _settled(states: Sequence[State]) -> list[tuple[int, bool]]:
    """Classes that all states of a face say the same of, and what."""
    always = frozenset.intersection(*(state.along for state in states))
    ever = frozenset.union(*(state.along for state in states))
    return [*((k, True) for k in always), *((k, False) for k in states[0].on_face - ever)]
