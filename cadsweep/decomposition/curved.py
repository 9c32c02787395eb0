"""The search for cuts through solids of any kind, in parts of one solid or several.

Place in the flow: ``pipeline`` calls :func:`find_cells` for cells that no sweep fits, or whose sweeps contradict each
other, with recognition, plan, cutters and cuts as callables; the search on planar solids alone is :mod:`.search`.

Method: best first. A move cuts one cell that stands in the way, and the faces of its neighbours with it, so a cut that
harms a neighbour shows at once. When all cells sweep, the plan decides, and the faces on which it fails say which cells
are cut next. The budget counts parts that are looked at, and their faces: the same part always gets the same cuts.
A cut that keeps features apart leaves more cells in the way at first; it is lent what that costs, for a while.

Where one cut seems best, best first goes on with what it leaves until the budget is gone, though another first cut may
leave cells that sweep at once. So after a while every cut of the whole gets its turn, first those that leave the least
in the way or part it most. Who meshes what is found may say which of its cells are poor: these are cut next.
"""

from __future__ import annotations

import heapq
import logging
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..brep import Cut, Part, Solid
from ..errors import PlanError
from .costs import BLOCKED, CELL, CONTRADICTION, cell_cost
from .tools import Fill, Tools

log = logging.getLogger(__name__)

MOST_PARTS = 100
"""Parts that are looked at before the search is given up: what a cut changes of each is read anew, in some 0.2 s."""
MOST_FACES = 8000
"""Faces that are read or cut before the search is given up, whatever the count of parts: some 5 ms each."""
CREDIT = 40
"""Parts that may be looked at until a cut that keeps features apart has paid."""
MOST_BEFORE, MOST_FACES_BEFORE = 40, 3000
"""Parts that are looked at best first, and faces that are read or cut for them, before every other cut of the whole
gets its turn."""
MOST_OPENINGS, MOST_OPENING_FACES = 100, 6000
"""Parts that are looked at in these turns, and faces that are read or cut for them."""
MOST_FACES_OF_ALL = 7000
"""Faces that are read or cut best first and in turns together: no part that is known needs more than 5,900."""
MANY_FACES = 200
"""Faces of a solid beyond which fewer are read or cut in all, as the square of them: cutters of a cell of 500 faces
take seconds, and so does each cut, so that a part that is not cut at once is refused within seconds as well."""
MANY_FACES_OF_ALL = 260
"""The same for best first and turns together, so that a part of 600 faces is still cut once."""
TURN = 20
"""Parts that are looked at in one turn."""
MOST_CELLS = 80
"""Cells beyond the first ones of a part at which it is not cut further."""
LEAD = 1.0
"""How much cheaper a part becomes by a cut that keeps features apart, at least."""
FLAT = 1e-4
"""Radians from pi up to which two faces at an edge are one surface."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """A part on the way.

    Attributes
    ----------
    part : Part
    cuts : tuple of Cut
        Those that were made.
    plan : Plan or None
        None where cells are in the way.
    blocked : tuple of int
        Cells without sweep.
    conflict : tuple of (cell, face)
        Where the sweeps of the cells contradict each other.
    message : str
        Why it has no plan.
    cost : float
        Never below 0.
    prices : float
        Of the cutters, a part of the cost.
    lent : float
        By how much it goes before others of its cost, for cuts that keep features apart.
    until : int
        Count of parts up to which it does.
    """

    part: Part
    cuts: tuple[Cut, ...]
    plan: Any
    blocked: tuple[int, ...]
    conflict: tuple[tuple[int, int], ...]
    message: str
    cost: float
    prices: float = 0.0
    lent: float = 0.0
    until: int = 0

    def rank(self, n_parts: int) -> float:
        """What it costs, less what is lent, when so many parts have been looked at."""
        return self.cost - self.lent if n_parts < self.until else self.cost


_Waiting = tuple[float, int, Found, Iterator[Found]]
"""A part that is gone on from: its rank, what orders equals, the part, and those that are one cut further."""


def find_cells(part: Part, tools: Tools, *, most_parts: int = MOST_PARTS) -> tuple[Found, int]:
    """Cut a part until every cell has a sweep and all agree; one solid as thoroughly as where it is meshed.

    Returns
    -------
    Found
        With a plan, or, where the budget ran out, what came nearest.
    int
        Parts that were looked at.
    """
    search = CellSearch(part, tools, most_parts=most_parts)
    return next(search.solutions(), None) or search.best, search.n_parts


class CellSearch:
    """One search: its budget, its memory, and what came nearest so far.

    Parameters
    ----------
    part : Part
    tools : Tools
    most_parts : int
        Parts to look at, best first.
    most_openings : int or None
        Parts to look at besides, in turns for all cuts of the whole; None for as many as suit one solid, or several.

    Attributes
    ----------
    best : Found
    n_parts : int
        Parts that were looked at.
    n_faces : int
        Faces of cells that were cut, or read, for them.
    refused : Counter
        How often a cutter of each kind parted no cell, or not well.
    share : float
        Of the counts of faces of each of the two, that a part of so many is given.
    most_of_all : float
        Faces that are read or cut for both together.
    poor : tuple of int
        What :meth:`cut_again` was told.
    until : float
        Count of parts at which its turn ends.
    ended_early : bool
        The user's time was used up before the count of parts was.
    """

    def __init__(
        self, part: Part, tools: Tools, *, most_parts: int = MOST_PARTS, most_openings: int | None = None
    ) -> None:
        self.tools = tools
        if most_openings is None:
            most_openings = MOST_OPENINGS if len(part.solids) == 1 else 0
        n_faces = max(len(solid.faces) for solid in part.solids)
        self.share = min(1.0, (MANY_FACES / n_faces) ** 2)
        self.most_of_all = min(1.0, (MANY_FACES_OF_ALL / n_faces) ** 2) * MOST_FACES_OF_ALL
        self.most_parts, self.most_faces, self.most_openings = most_parts, self.share * MOST_FACES, most_openings
        self.most_cells = MOST_CELLS + len(part.solids)
        self.n_parts = self.n_faces = 0
        self.known: set[Hashable] = set()
        self.sweeps: dict[object, list[Fill]] = {}
        self.compared = set[object]()
        self.refused: Counter[str] = Counter()
        self.ended_early = False
        self.poor: tuple[int, ...] = ()
        self.until: float = np.inf
        self.best = self.judge(part, ())

    def cut_again(self, cells: Sequence[int]) -> None:
        """Go on for a turn from the part that was yielded last, as though poor cells had no sweep."""
        self.poor, self.until = tuple(cells), min(self.until, self.n_parts + TURN)

    def in_the_way(self, found: Found, cells: tuple[int, ...]) -> Found:
        """A part that has a plan, as though some of its cells had no sweep."""
        more = 0.0
        for solid in (found.part.solids[cell] for cell in cells):
            with_sweep, without = (cell_cost(solid, has, size=solid.size, flat=FLAT) for has in (True, False))
            more += without - with_sweep
        lent, until = found.lent + more, self.n_parts + TURN
        return replace(found, plan=None, blocked=cells, cost=found.cost + more, lent=lent, until=until)

    def solutions(self) -> Iterator[Found]:
        """Parts that have a plan, as they are found; the search goes on from the cheapest part that has none."""
        first = self.best
        if first.plan is not None:
            yield first
        queue: list[_Waiting] = [(first.cost, 0, first, self.children(first))]
        if self.most_openings:
            yield from self.best_first(queue, MOST_BEFORE, self.share * MOST_FACES_BEFORE)
            yield from self.openings(first)
        yield from self.best_first(queue)

    def best_first(
        self, queue: list[_Waiting], most_parts: float = np.inf, most_faces: float = np.inf
    ) -> Iterator[Found]:
        """Go on from the cheapest parts of a queue until so many, or so many faces, were looked at; the rest stay."""
        n = 1 + max((number for _, number, _, _ in queue), default=0)
        most_parts, most_faces = most_parts + self.n_parts, most_faces + self.n_faces
        while queue and not self.is_over() and self.n_parts < most_parts and self.n_faces < most_faces:
            rank, number, here, children = heapq.heappop(queue)
            if rank < here.cost and self.n_parts >= here.until:
                heapq.heappush(queue, (here.cost, number, replace(here, lent=0.0), children))
                continue  # what was lent has not paid
            for child in children:
                self.best = min(self.best, child, key=lambda found: (found.plan is None, found.cost))
                then = child
                if child.plan is not None:
                    yield child
                    if not self.poor:
                        continue
                    then, self.poor = self.in_the_way(child, self.poor), ()
                own = then.rank(self.n_parts)
                heapq.heappush(queue, (own, n + 1, then, self.children(then)))
                n += 2
                if own < rank - BLOCKED + CELL or then.lent > here.lent:
                    # A cell less in the way, or features apart, whatever the other cutters would do: these wait.
                    heapq.heappush(queue, (rank + CELL, n, here, children))
                    break
                if self.n_parts >= most_parts or self.n_faces >= most_faces:
                    heapq.heappush(queue, (rank, number, here, children))
                    break

    def openings(self, first: Found) -> Iterator[Found]:
        """Every cut of the whole that was not looked at yet: all of them, then a turn for each."""
        parts, faces = self.n_parts, self.n_faces
        most = self.most_parts, self.most_faces
        self.most_parts = parts + self.most_openings
        self.most_faces = min(faces + self.share * MOST_OPENING_FACES, self.most_of_all)
        starts: list[Found] = []
        for child in self.children(first):
            self.best = min(self.best, child, key=lambda found: (found.plan is None, found.cost))
            if child.plan is not None:
                yield child
            else:
                starts.append(child)
        for start in _in_turns(starts):
            if self.is_over():
                break
            log.debug("a turn for %s", start.cuts[-1])
            yield from self.best_first([(start.cost, 0, start, self.children(start))], TURN)
        self.most_parts = most[0] + self.n_parts - parts
        self.most_faces = min(most[1] + self.n_faces - faces, self.most_of_all)

    def is_over(self) -> bool:
        """Whether the count of parts, or the user's time, is used up."""
        self.ended_early = self.ended_early or self.tools.is_late()
        is_over = self.n_parts >= min(self.most_parts, self.until) or self.n_faces >= self.most_faces
        return is_over or self.ended_early

    def children(self, found: Found) -> Iterator[Found]:
        """Parts one cut further."""
        if len(found.part.solids) >= self.most_cells:
            return
        for cell, faces in self.targets(found):
            if self.is_over():
                return  # to make the cutters of a large cell takes seconds
            for cutter in self.tools.find_cutters(found.part, cell, faces):
                if self.is_over():
                    return
                self.n_faces += len(found.part.solids[cell].faces)
                pieces = self.tools.split(found.part, cell, cutter, found.blocked)
                if pieces is None:
                    self.refused[cutter.reason] += 1
                    continue
                key = pieces.key
                if key in self.known:
                    continue
                self.known.add(key)
                then = pieces.imprinted()
                if then is None:
                    self.refused[cutter.reason] += 1
                    continue
                x, y, z = found.part.to_model(_middle(found.part.solids[cell])).tolist()
                cut = Cut(kind=cutter.kind, reason=cutter.reason, place=(x, y, z), family=cutter.family)
                child = self.judge(then, (*found.cuts, cut), found.prices + cutter.price)
                lent, until = found.lent, found.until
                if cutter.leads and child.cost - lent > found.cost - found.lent - LEAD:
                    lent = child.cost - found.cost + found.lent + LEAD
                    until = max(until, self.n_parts + CREDIT)
                yield replace(child, lent=lent, until=until)

    def targets(self, found: Found) -> list[tuple[int, list[int]]]:
        """The cells that may be cut, and the faces that are in the way there."""
        if found.blocked:
            first = {found.part.owners[cell]: cell for cell in reversed(found.blocked)}
            return [(cell, []) for cell in found.blocked if cell in first.values()]
        by_cell: dict[int, list[int]] = {}
        for cell, face in found.conflict:
            by_cell.setdefault(cell, []).append(face)
        return list(by_cell.items())[:4]

    def recognise(self, solid: Solid) -> list[Fill]:
        """The sweeps of a cell; one that comes out of a cut as it was, keys aside, is asked once."""
        if solid.kernel not in self.sweeps:
            self.sweeps[solid.kernel] = self.tools.recognise(solid)
        return [replace(fill, solid=solid) for fill in self.sweeps[solid.kernel]]

    def judge(self, part: Part, cuts: tuple[Cut, ...], prices: float = 0.0) -> Found:
        """What stands in the way of a part, and what that costs."""
        self.n_parts += 1
        self.n_faces += sum(len(solid.faces) for solid in part.solids if solid.kernel not in self.sweeps)
        candidates = [self.recognise(solid) for solid in part.solids]
        costs = [
            cell_cost(solid, bool(own), size=solid.size, flat=FLAT)
            for solid, own in zip(part.solids, candidates, strict=True)
        ]
        blocked = sorted((j for j, own in enumerate(candidates) if not own), key=lambda j: -costs[j])
        new = [j for j in blocked if part.solids[j].kernel not in self.compared]
        self.compared.update(part.solids[j].kernel for j in new)
        alike = self.tools.make_alike(part, new) if new else None
        if alike is not None:
            return self.judge(alike, cuts, prices)
        cost, plan, message = sum(costs) + prices, None, ""
        conflict: tuple[tuple[int, int], ...] = ()
        if blocked:
            message = f"{len(blocked)} cells have no sweep"
        else:
            try:
                plan = self.tools.make_plan(part, candidates)
            except PlanError as error:
                conflict, message = error.faces, error.message
                cost += CONTRADICTION * max(1, len(error.faces) // 2)
        self.tools.on_progress(len(blocked) or len({c for c, _ in conflict}))
        log.debug(
            "%d cells, %d in the way, cost %.2f, %d faces read: %s; %s",
            len(part.solids),
            len(blocked),
            cost,
            self.n_faces,
            cuts[-1:],
            message,
        )
        return Found(
            part=part,
            cuts=cuts,
            plan=plan,
            blocked=tuple(blocked),
            conflict=conflict,
            message=message,
            cost=cost,
            prices=prices,
        )


def _in_turns(starts: Sequence[Found]) -> list[Found]:
    """One of those that cost least, one of those with the most cells, and so on: no one measure knows which leads."""
    cheap = sorted(starts, key=lambda found: found.cost)
    parted = sorted(starts, key=lambda found: -len(found.part.solids))
    order = {id(found): found for pair in zip(cheap, parted, strict=True) for found in pair}
    return list(order.values())


def _middle(solid: Solid) -> FloatArray:
    """Middle (3,) of a cell's corners."""
    middle: FloatArray = 0.5 * (solid.vertices.min(axis=0) + solid.vertices.max(axis=0))
    return middle
