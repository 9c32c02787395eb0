"""Choosing one way a cell so that every shared face has roles that agree, and an order without a circle.

Place in the flow: after ``recognition``, before ``intervals``.

Method: a constraint search. Ways that no way of a neighbour agrees with are struck out until nothing changes (arc
consistency); then the cell with the fewest ways left takes its best one, and so on, with steps back. Components of
cells that share no face are searched apart. The budget counts steps, so the same part always gets the same plan.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ..brep import Part, Solid
from ..corner_blocks import CornerBlocks
from ..errors import PlanError
from ..sweep import Sweep
from .around import Shared, begin_around
from .ways import Fill, Role, Way, corner_vertices, list_ways

log = logging.getLogger(__name__)

MOST_STEPS = 20_000
"""Choices of one component that are tried: some seconds; plans of the parts measured needed below a thousand."""

_AGREE: dict[tuple[Role, Role], bool] = {
    ("grid", "grid"): True,  # where the corners are the same
    ("grid", "first"): True,
    ("grid", "last"): False,
    ("first", "first"): True,
    ("first", "last"): True,
    ("last", "last"): False,
    ("star", "grid"): False,
    ("star", "first"): True,
    ("star", "last"): False,
    (
        "star",
        "star",
    ): True,  # where the corners are the same, and odd in number: the counts place the middle of each edge
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Plan:
    """One sweep a cell.

    Attributes
    ----------
    ways : tuple of Way
        By cell.
    order : tuple of int
        Cells in an order in which every cell finds meshed what it is given.
    n_steps : int
        Choices that were tried.
    """

    ways: tuple[Way, ...]
    order: tuple[int, ...]
    n_steps: int = 0

    @property
    def fills(self) -> tuple[Fill, ...]:
        """How every cell is filled."""
        return tuple(way.fill for way in self.ways)

    def by_themselves(self, part: Part) -> set[int]:
        """Cells that are swept, and whose linking sides no other cell has."""
        shared = {key for key, users in shared_faces(part).items() if len(users) > 1}
        return {
            cell
            for cell, (solid, way) in enumerate(zip(part.solids, self.ways, strict=True))
            if isinstance(way.fill, Sweep)
            and shared.isdisjoint(int(solid.face_keys[side.face]) for side in way.fill.linking_sides)
        }

    @property
    def score(self) -> float:
        """Mean score of the sweeps."""
        return float(np.mean([way.score for way in self.ways]))


def shared_faces(part: Part) -> Shared:
    """Faces of two cells, by key."""
    users: Shared = {}
    for cell, solid in enumerate(part.solids):
        for face, key in enumerate(solid.face_keys.tolist()):
            users.setdefault(key, []).append((cell, face))
    return {key: own for key, own in users.items() if len(own) > 1}


def make_plan(part: Part, candidates: Sequence[Sequence[Fill]], *, most_steps: int = MOST_STEPS) -> Plan:
    """Choose a sweep for every cell.

    Parameters
    ----------
    part : Part
        Cells with keys of the whole part.
    candidates : sequence of sequence of Sweep or CornerBlocks
        How every cell may be filled.
    most_steps : int
        Choices to try in each component of cells that share faces.

    Returns
    -------
    Plan
        The best total score among the first plans found.

    Raises
    ------
    PlanError
        There is none; ``faces`` are those where the search met most contradictions.
    """
    ways = [list_ways(own) for own in candidates]
    for cell, own in enumerate(ways):
        if not own:
            raise _no_way(part, cell, candidates[cell])
    search = _Search(part, ways, shared_faces(part))
    chosen: dict[int, int] = {}
    for component in search.components():
        chosen |= search.solve(component, most_steps)
    picked = tuple(ways[cell][chosen[cell]] for cell in range(len(ways)))
    return Plan(ways=picked, order=tuple(search.order(chosen) or ()), n_steps=search.n_steps)


def _no_way(part: Part, cell: int, candidates: Sequence[Fill]) -> PlanError:
    solid = part.solids[cell]
    name = f"'{solid.name}'" if solid.name else f"cell {cell}"
    if not candidates:
        return PlanError(f"{name} has no sweep", faces=[(cell, f.id) for f in solid.faces])
    sweep = candidates[0]
    assert isinstance(sweep, Sweep), "blocks at the corners are a way"
    caps = [*sweep.source, *sweep.target]
    return PlanError(
        f"{name}: both caps of its sweep are divided, and the lines on them do not answer each other",
        where=f"{solid.faces[sweep.source[0]].label()} and {solid.faces[sweep.target[0]].label()}",
        faces=[(cell, f) for f in caps],
    )


BoolMatrix = npt.NDArray[np.bool_]


@dataclass(kw_only=True, eq=False)
class _State:
    """Ways still open by cell, and those chosen."""

    open: dict[int, npt.NDArray[np.bool_]]
    chosen: dict[int, int] = field(default_factory=dict)


class _Search:
    """The cells, their ways, and which pairs of ways agree."""

    def __init__(self, part: Part, ways: Sequence[Sequence[Way]], shared: Shared) -> None:
        self.part = part
        self.ways = ways
        self.shared = shared
        self.n_steps = 0
        self.conflicts: Counter[tuple[int, int]] = Counter()
        self.faces_between: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for (a, fa), (b, fb) in (users[:2] for users in shared.values()):
            self.faces_between.setdefault((a, b), []).append((fa, fb))
            self.faces_between.setdefault((b, a), []).append((fb, fa))
        self.neighbours: dict[int, list[int]] = {cell: [] for cell in range(len(ways))}
        for a, b in self.faces_between:
            self.neighbours[a].append(b)
        self._corners: dict[tuple[int, int, int], frozenset[int]] = {}
        self._agreement: dict[tuple[int, int], BoolMatrix] = {}

    def components(self) -> list[list[int]]:
        """Cells that hang together by faces."""
        left, found = set(range(len(self.ways))), []
        while left:
            waiting, own = [min(left)], set[int]()
            while waiting:
                cell = waiting.pop()
                if cell in own:
                    continue
                own.add(cell)
                waiting += self.neighbours[cell]
            left -= own
            found.append(sorted(own))
        return found

    def agreement(self, a: int, b: int) -> BoolMatrix:
        """Which ways of cell a (rows) agree with which of cell b on all faces between them."""
        known = self._agreement.get((a, b))
        if known is None:
            known = np.array(
                [[self.agree(a, i, b, j) for j in range(len(self.ways[b]))] for i in range(len(self.ways[a]))]
            )
            self._agreement[a, b], self._agreement[b, a] = known, known.T
        return known

    def agree(self, a: int, i: int, b: int, j: int) -> bool:
        """Whether two ways agree on every face between their cells."""
        return all(self.agree_on((a, i, fa), (b, j, fb)) for fa, fb in self.faces_between[a, b])

    def agree_on(self, mine: tuple[int, int, int], theirs: tuple[int, int, int]) -> bool:
        """Whether two ways agree on one face, each said as (cell, way, face)."""
        one, other = (self.ways[cell][way].roles[face] for cell, way, face in (mine, theirs))
        if one == other == "grid":
            return self.corners(*mine) == self.corners(*theirs)
        if one == other == "star":
            return self.corners(*mine) == self.corners(*theirs) and len(self.corners(*mine)) % 4 != 0
        return _AGREE[one, other] if (one, other) in _AGREE else _AGREE[other, one]

    def corners(self, cell: int, way: int, face: int) -> frozenset[int]:
        """Keys of the corners of a grid or of a star."""
        known = self._corners.get((cell, way, face))
        if known is None:
            solid = self.part.solids[cell]
            chosen = self.ways[cell][way]
            own: tuple[int, ...]
            if face in chosen.grids:
                own = corner_vertices(solid, chosen.grids[face])
            else:
                assert isinstance(chosen.fill, CornerBlocks), "only corner blocks have stars"
                own = tuple(chosen.fill.ends[chain][not forward] for chain, forward in chosen.fill.outlines[face])
            known = self._corners[cell, way, face] = frozenset(int(solid.vertex_keys[v]) for v in own)
        return known

    def solve(self, component: Sequence[int], most_steps: int) -> dict[int, int]:
        """The first choice that agrees everywhere, the best ways tried first."""
        state = _State(open={cell: np.ones(len(self.ways[cell]), dtype=bool) for cell in component})
        if not self.propagate(state, component):
            raise self.contradiction(component)
        budget = self.n_steps + most_steps
        found = self.descend(state, budget)
        if found is None:
            raise self.contradiction(component, exhausted=self.n_steps >= budget)
        return found

    def descend(self, state: _State, budget: int) -> dict[int, int] | None:
        """Depth first, without recursion: plans of hundreds of cells are as deep as they are long."""
        stack = [(state, iter(self.branches(state)))]
        while stack:
            here, branches = stack[-1]
            if len(here.chosen) == len(here.open):
                return here.chosen
            nxt = next(branches, None)
            if nxt is None:
                stack.pop()
                continue
            if self.n_steps >= budget:
                return None
            self.n_steps += 1
            cell, way = nxt
            then = _State(open={c: m.copy() for c, m in here.open.items()}, chosen={**here.chosen, cell: way})
            then.open[cell][:] = False
            then.open[cell][way] = True
            if self.propagate(then, [cell]) and self.order(then.chosen) is not None:
                stack.append((then, iter(self.branches(then))))
        return None

    def branches(self, state: _State) -> list[tuple[int, int]]:
        """The next cell to settle, with its ways from best to worst: few ways first, then beside what is settled."""
        left = [cell for cell in state.open if cell not in state.chosen]
        if not left:
            return []
        settled = {b for a in state.chosen for b in self.neighbours[a]}
        cell = min(left, key=lambda c: (int(state.open[c].sum()) > 1, c not in settled, int(state.open[c].sum()), c))
        return [(cell, int(way)) for way in np.flatnonzero(state.open[cell])]

    def propagate(self, state: _State, changed: Sequence[int]) -> bool:
        """Strike out ways that nothing of a neighbour agrees with; False where a cell has none left."""
        waiting = list(changed)
        while waiting:
            a = waiting.pop()
            for b in self.neighbours[a]:
                agreement = self.agreement(a, b)
                kept = state.open[b] & agreement[state.open[a]].any(axis=0)
                if kept.sum() == state.open[b].sum():
                    continue
                if not kept.any():
                    self.blame(a, b, state)
                    return False
                state.open[b] = kept
                waiting.append(b)
        return True

    def blame(self, a: int, b: int, state: _State) -> None:
        """Count the faces on which two cells cannot agree any more."""
        for fa, fb in self.faces_between[a, b]:
            pairs = ((i, j) for i in np.flatnonzero(state.open[a]) for j in np.flatnonzero(state.open[b]))
            if not any(self.agree_on((a, int(i), fa), (b, int(j), fb)) for i, j in pairs):
                self.conflicts[a, fa] += 1
                self.conflicts[b, fb] += 1
                return
        for fa, fb in self.faces_between[a, b]:  # each face alone would do, all together do not
            self.conflicts[a, fa] += 1
            self.conflicts[b, fb] += 1

    def order(self, chosen: dict[int, int]) -> list[int] | None:
        """Chosen cells in an order in which quads are carried on; None where that is a circle."""
        after: dict[int, set[int]] = {cell: set() for cell in chosen}
        for users in self.shared.values():
            (a, fa), (b, fb) = users[:2]
            if a not in chosen or b not in chosen:
                continue
            one, other = self.ways[a][chosen[a]].roles[fa], self.ways[b][chosen[b]].roles[fb]
            if one in ("last", "star") and other == "first":
                after[b].add(a)
            elif one == "first" and other in ("last", "star"):
                after[a].add(b)
        found: list[int] = []
        ready = sorted((cell for cell, before in after.items() if not before), reverse=True)
        followers: dict[int, list[int]] = {cell: [] for cell in chosen}
        for cell, before in after.items():
            for earlier in before:
                followers[earlier].append(cell)
        while len(found) < len(chosen):
            if not ready:
                ways = {cell: self.ways[cell][way] for cell, way in chosen.items()}
                begin = begin_around(self.part, ways, self.shared, {cell for cell, before in after.items() if before})
                if begin is None:
                    return None
                after[begin].clear()
                ready.append(begin)
            cell = ready.pop()
            found.append(cell)
            for later in followers[cell]:
                if cell in after[later]:
                    after[later].discard(cell)
                    if not after[later]:
                        ready.append(later)
        return found

    def contradiction(self, component: Sequence[int], *, exhausted: bool = False) -> PlanError:
        """Say which faces the search failed at most often."""
        solids = self.part.solids
        often = self.conflicts.most_common()
        faces = [face for face, n in often if n == often[0][1]] if often else []
        if not faces:
            names = ", ".join(_name(solids[cell], cell) for cell in component[:3])
            return PlanError(f"no order of meshing fits {names}: their sweeps follow each other in a circle")
        cell, face = faces[0]
        key = int(solids[cell].face_keys[face])
        (a, fa), (b, fb) = self.shared[key][:2]
        seen = [self.words(a, fa), self.words(b, fb)]
        tried = f" within {self.n_steps} tries" if exhausted else ""
        return PlanError(
            f"no sweeps of {_name(solids[a], a)} and {_name(solids[b], b)} agree{tried} on the face between them",
            where=f"{solids[a].faces[fa].label()}: to the first it is {seen[0]}, to the second {seen[1]}",
            faces=faces,
        )

    def words(self, cell: int, face: int) -> str:
        """What a face can be to its cell."""
        names = {"grid": "a side of four corners", "first": "a cap", "last": "a cap", "star": "a star of quads"}
        return " or ".join(sorted({names[way.roles[face]] for way in self.ways[cell]}))


def _name(solid: Solid, cell: int) -> str:
    return f"'{solid.name}'" if solid.name else f"cell {cell}"
