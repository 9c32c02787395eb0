"""The search for cuts: which plane through which cell, until every cell sweeps and all agree.

Place in the flow: ``pipeline`` calls :func:`find_cuts` for a planar solid that no sweep and no stack fits, with
recognition and plan as callables.

Method: best-first search over complexes. A move cuts one cell that stands in the way, by a plane that a face gives
which meets a re-entrant edge or an imprint of the cell: its own, a neighbour's, or one square to an imprinted face
through the imprint's outline. As a complex is conformal at every step, a cut that harms a neighbour shows at once. When
all cells sweep, the plan decides; the faces that contradict say which cells are cut next. Where they contradict to the
end, all is searched once more, and cuts at such faces are also carried on through the neighbours that they imprint: an
imprint that ends on a grid is the commonest contradiction. The budget counts complexes and cells that are looked at, so
the same part always gets the same cuts.
"""

from __future__ import annotations

import heapq
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from math import inf, pi

from ..brep import Face, Part, Solid
from ..corner_blocks import CornerBlocks
from ..errors import PlanError
from ..sweep import Sweep
from .costs import CONTRADICTION, cell_cost
from .dividing import Plane, divide, divide_on, narrowest
from .planar import Cell, Facet, Pair, Pool, from_solid
from .solids import to_solid
from .vectors import cross, dot, minus, to_vector, unit

log = logging.getLogger(__name__)

Fill = Sweep | CornerBlocks
"""How a cell is filled with hexahedra."""

Recognise = Callable[[Solid], list[Fill]]
MakePlan = Callable[[Part, list[list[Fill]]], object]

MOST_STATES = 800
"""Complexes that are looked at before the part is given up."""
MOST_CARRIED, MOST_READ = 250, 1300
"""Complexes that are looked at once cuts are carried on, and cells that are read for them: each may have ten new."""
MOST_AGAIN = 60
"""Complexes that are looked at once cells of one make poor hexahedra."""
MOST_CELLS = 60
"""Cells of a complex beyond which it is not cut further."""
CLIMB = 4.0
"""How much dearer than where it began a dive may become before another one is begun."""
CLOSED, NARROW = 1e-3, 0.015
"""Distance of a cut from what it passes by, as a share of the part's size: refused, and made dearer, below these."""
NARROW_COST = 1.5
"""Cost of a sliver that a cut makes, in cells: worth another cut or two to avoid."""
GAP = 0.02
"""Distance between two features, as a share of the part's size, from which a cut between them is worth it."""
MOST_DIRECTIONS = 4
"""Directions of faces in which features are parted."""
CORNER_EDGES = 3
"""Edges of a vertex up to which a block of hexahedra fits into it."""
FLAT = 1e-6
"""Radians from pi up to which two faces at an edge are one plane."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Seen:
    """What is known of a cell, whatever complex it is in."""

    solid: Solid
    sweeps: list[Fill]
    cost: float


@dataclass(frozen=True, kw_only=True)
class PlaneCut:
    """One cut of the solution: the plane, a point inside the cell that it cut, and why."""

    plane: Plane
    reason: str


@dataclass(kw_only=True, eq=False)
class State:
    """A complex, how it came about, and what stands in its way."""

    cells: tuple[Cell, ...]
    cuts: tuple[PlaneCut, ...] = ()
    cost: float = 0.0
    narrow: float = 0.0
    blocked: tuple[int, ...] = ()
    conflict: tuple[tuple[int, int], ...] = ()
    plan: object = None


@dataclass(kw_only=True, eq=False)
class Search:
    """Pool, cache and budget of one search."""

    model: Solid
    recognise: Recognise
    make_plan: MakePlan
    most_states: int = MOST_STATES
    most_read: float = inf
    is_late: Callable[[], bool] = lambda: False
    on_progress: Callable[[int], None] = lambda n: None
    ended_early: bool = False
    pool: Pool = field(init=False)
    best: State = field(init=False)
    n_states: int = 0
    seen: dict[Cell, Seen] = field(default_factory=dict)
    known: set[frozenset[frozenset[tuple[int, int]]]] = field(default_factory=set)
    is_contradicted: bool = False
    carries_on: bool = False
    poor: tuple[int, ...] = ()

    def cut_again(self, cells: Sequence[int]) -> None:
        """Go on for a while from the complex that was yielded last, as though poor cells had no sweep."""
        self.poor, self.most_states = tuple(cells), min(self.most_states, self.n_states + MOST_AGAIN)

    def solutions(self) -> Iterator[State]:
        """Complexes that have a plan, as they are found; ``best`` is the best complex looked at so far."""
        self.pool, cell = from_solid(self.model)
        self.best = first = self.judge((cell,), ())
        if first.plan is not None:
            yield first
        found = first.plan
        for state in self.below(first):
            found = state.plan
            yield state
        if found is None and self.is_contradicted:
            self.known.clear()
            self.most_states, self.most_read = self.n_states + MOST_CARRIED, len(self.seen) + MOST_READ
            self.carries_on = True
            yield from self.below(first)

    def below(self, first: State) -> Iterator[State]:
        """Complexes that have a plan, found by cutting one that has none, while the budget lasts."""
        queue: list[tuple[float, int, State]] = [(first.cost, 0, first)]
        n = turn = 0
        while queue and not self.is_over():
            start, _, here = heapq.heappop(queue)
            turn += 1
            while not self.is_over():
                children = []
                for child in self.children(here):
                    children.append(child)
                    self.best = min(self.best, child, key=lambda state: (state.plan is None, state.cost))
                    if child.plan is not None or self.is_over():
                        break
                if children and children[-1].plan is not None:
                    found = children.pop()
                    yield found
                    if self.poor:
                        children.append(replace(found, plan=None, blocked=self.poor))
                        self.poor = ()
                children.sort(key=lambda child: child.cost)
                # Every other time the best child is followed down at once: some parts need depth, others width.
                dives = turn % 2 and children and children[0].cost <= start + CLIMB
                for child in children[1:] if dives else children:
                    n += 1
                    heapq.heappush(queue, (child.cost, n, child))
                if not dives:
                    break
                here = children[0]

    def is_over(self) -> bool:
        """Whether the counts of complexes and of cells, or the user's time, are used up."""
        self.ended_early = self.ended_early or self.is_late()
        return self.n_states >= self.most_states or len(self.seen) >= self.most_read or self.ended_early

    def children(self, state: State) -> Iterator[State]:
        """Complexes one cut further."""
        if len(state.cells) >= MOST_CELLS or state.plan is not None:
            return
        targets = [state.blocked[0]] if state.blocked else list(dict.fromkeys(c for c, _ in state.conflict))
        ways = (divide, divide_on) if self.carries_on and not state.blocked else (divide,)
        for number in targets:
            for (plane, reason), way in product(self.planes(state, number), ways):
                cut = -1 - len(state.cuts)
                cells = way(self.pool, state.cells, number, plane, cut)
                if cells is None:
                    continue
                key = frozenset(frozenset(cell) for cell in cells)
                if key in self.known:
                    continue
                self.known.add(key)
                gap = narrowest(self.pool, cells, cut) / self.pool.size
                if gap < CLOSED:
                    continue
                narrow = state.narrow + max(0.0, 1.0 - gap / NARROW)
                yield self.judge(cells, (*state.cuts, PlaneCut(plane=plane, reason=reason)), narrow)

    def look(self, cell: Cell) -> Seen:
        """Recognise a cell once."""
        known = self.seen.get(cell)
        if known is None:
            solid = to_solid(self.pool, cell, self.model)
            sweeps = self.recognise(solid)
            known = self.seen[cell] = Seen(
                solid=solid, sweeps=sweeps, cost=cell_cost(solid, bool(sweeps), size=self.pool.size, flat=FLAT)
            )
        return known

    def judge(self, cells: tuple[Cell, ...], cuts: tuple[PlaneCut, ...], narrow: float = 0.0) -> State:
        """Cost of a complex; where all cells sweep, its plan."""
        self.n_states += 1
        seen = [self.look(cell) for cell in cells]
        cost = sum(one.cost for one in seen) + NARROW_COST * narrow
        blocked = sorted((j for j, one in enumerate(seen) if not one.sweeps), key=lambda j: -seen[j].cost)
        state = State(cells=cells, cuts=cuts, cost=cost, blocked=tuple(blocked), narrow=narrow)
        if not blocked:
            part = Part(solids=tuple(one.solid for one in seen))
            try:
                state.plan = self.make_plan(part, [one.sweeps for one in seen])
            except PlanError as error:
                state.conflict = error.faces
                self.is_contradicted = True
                state.cost += CONTRADICTION * max(1, len(error.faces) // 2)
        self.on_progress(len(state.blocked) or len({c for c, _ in state.conflict}))
        return state

    def planes(self, state: State, number: int) -> Iterator[tuple[Plane, str]]:
        """Planes that may part a cell, each once."""
        cell = state.cells[number]
        solid = self.look(cell).solid
        uses = self.pool.uses(cell)
        around: dict[Pair, set[int]] = {}
        for other in state.cells:
            for f, _ in other:
                for a, b in self.pool.facets[f].pairs:
                    pair = (a, b) if a < b else (b, a)
                    if pair in uses:
                        around.setdefault(pair, set()).add(f)
        found: list[tuple[float, Plane, str]] = []
        in_conflict = {f for c, f in state.conflict if c == number}
        pairs = list(uses)
        for edge in solid.edges:
            pair = pairs[edge.id]
            convex = edge.dihedral < pi - FLAT
            own = [f for f, _ in uses[pair]]
            if convex and not (in_conflict & set(edge.faces)):
                continue
            along = unit(minus(self.pool.points[pair[1]], self.pool.points[pair[0]]))
            for f in sorted(around[pair]):
                facet = self.pool.facets[f]
                if f in own and edge.dihedral < pi + FLAT:
                    continue
                found.append((edge.length, Plane(normal=facet.normal, offset=facet.offset), self.name_of(f)))
            if (not convex and edge.dihedral < pi + FLAT) or in_conflict & set(edge.faces):
                for f in own:
                    normal = unit(cross(along, self.pool.facets[f].normal))
                    square = Plane(normal=normal, offset=dot(normal, self.pool.points[pair[0]]))
                    where = self.model.units.place(edge.midpoint)
                    found.append((edge.length, square, f"square to {self.name_of(f)} at ({where})"))
        yield from _distinct(found)
        yield from _distinct(self.between_features(solid))
        yield from _distinct(self.through_points(solid))

    def through_points(self, solid: Solid) -> list[tuple[float, Plane, str]]:
        """Planes through two edges of a vertex with more than three, that have no face between them: it gets less."""
        found: list[tuple[float, Plane, str]] = []
        for vertex in range(len(solid.vertices)):
            edges = [e for e in solid.edges if vertex in (e.start, e.end)]
            if len(edges) <= CORNER_EDGES:
                continue
            where = self.model.units.place(solid.vertices[vertex])
            for one, other in combinations(edges, 2):
                a, b = (
                    to_vector(solid.vertices[e.end if e.start == vertex else e.start] - solid.vertices[vertex])
                    for e in (one, other)
                )
                square = cross(unit(a), unit(b))
                if set(one.faces) & set(other.faces) or dot(square, square) < FLAT:
                    continue
                normal = unit(square)
                plane = Plane(normal=normal, offset=dot(normal, to_vector(solid.vertices[vertex])))
                found.append((one.length + other.length, plane, f"a plane through the point ({where})"))
        return found

    def between_features(self, solid: Solid) -> list[tuple[float, Plane, str]]:
        """Planes half way between two groups of edges that stand in the way, square to a face of the cell."""
        features = [solid.vertices[sorted(group)] for group in _groups(solid)]
        found: list[tuple[float, Plane, str]] = []
        if len(features) < 2:
            return found
        for face in _directions(solid):
            extents = sorted((float((f @ face.normal).min()), float((f @ face.normal).max())) for f in features)
            reached = extents[0][1]
            for low, high in extents[1:]:
                if low - reached > GAP * self.pool.size:
                    plane = Plane(normal=to_vector(face.normal), offset=(low + reached) / 2.0)
                    found.append((low - reached, plane, f"a plane between features, parallel to {face.label()}"))
                reached = max(reached, high)
        return found

    def cut_facets(self, state: State) -> list[Facet]:
        """The facets of all cuts of a state, each once."""
        used = dict.fromkeys(f for cell in state.cells for f, _ in cell)
        return [self.pool.facets[f] for f in used if self.pool.facets[f].origin < 0]

    def name_of(self, f: int) -> str:
        """How messages call the plane of a facet."""
        origin = self.pool.facets[f].origin
        return self.model.faces[origin].label() if origin >= 0 else f"cut {-origin}"


def _groups(solid: Solid) -> list[set[int]]:
    """Vertices of re-entrant and imprinted edges that hang together."""
    groups: list[set[int]] = []
    for edge in solid.edges:
        if edge.dihedral > pi - FLAT:
            own = {edge.start, edge.end}
            for group in [group for group in groups if group & own]:
                groups.remove(group)
                own |= group
            groups.append(own)
    return groups


def _directions(solid: Solid) -> list[Face]:
    """Faces of a cell that look in different directions, the largest first."""
    found: list[Face] = []
    for face in sorted(solid.faces, key=lambda face: -face.area):
        if not any(abs(abs(float(face.normal @ other.normal)) - 1.0) < 1e-9 for other in found):
            found.append(face)
    return found[:MOST_DIRECTIONS]


def _distinct(found: Sequence[tuple[float, Plane, str]]) -> Iterator[tuple[Plane, str]]:
    """Each plane once, those of long edges first."""
    taken: list[Plane] = []
    for _, plane, reason in sorted(found, key=lambda one: -one[0]):
        if not any(_same(plane, other) for other in taken):
            taken.append(plane)
            yield plane, reason


def _same(a: Plane, b: Plane) -> bool:
    cosine = dot(a.normal, b.normal)
    return abs(abs(cosine) - 1.0) < 1e-9 and abs(a.offset - (b.offset if cosine > 0 else -b.offset)) < 1e-7
