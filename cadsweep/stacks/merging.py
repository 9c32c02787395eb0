"""Outlines that nearly coincide in plan laid together, where they belong to different heights of the part.

Place in the flow: after the arrangement, before it is meshed. Only the mesh of the plane changes by it: on every level
the nodes are on the outline that is there in truth (:mod:`.places`).

Method: wherever two vertices of a cell, or a vertex and an edge across it, are nearer to each other than a distance,
they are brought together, the nearest first; a cell of two edges vanishes. A step is made only where nothing of the
part claims two places at once: walls one over the other may be drawn apart by the layers between them, walls beside
each other are a thin piece of the part, or a narrow gap, and stay.

Not handled: cells under slanted or curved caps, whose heights change with the place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..arrays import FloatArray
from ..stack import Claim, Outline, Stack
from .graph import Graph
from .outline_crossings import n_crossings
from .steps import Step, find_steps

NEAR = 0.2
"""Distance, in sizes of the mesh, below which outlines are laid together: layers drawn apart by it lean 11 degrees."""
_STEEPEST = 1.0
"""Height over which a node may be drawn aside, in lengths by which it is: at 45 degrees a corner keeps 0.7."""
_SAME = 1e-7
"""Distance, in sizes of the part, up to which places are the same."""
_FARTHEST = 2.0
"""How far apart, in the distance that is near, places may be that were brought together step by step."""
_WIDE = 1.5
"""How wide, in the distance that is near, the gap between two edges may be that are laid together."""
_FLAT = 1e-9
_MOST_STEPS = 500


def merge_outlines(stack: Stack, near: float) -> tuple[FloatArray, list[Outline]] | None:
    """Lay outlines together that are nearer to each other than a distance.

    Parameters
    ----------
    stack : Stack
    near : float
        Working units.

    Returns
    -------
    vertices : (n, 3) float64
        On the plane of the arrangement.
    outlines : list of Outline
        All edges of the new arrangement; None where nothing is to be laid together.
    """
    faces = stack.solid.faces
    flat = {
        f
        for f in (*stack.source, *stack.target)
        if faces[f].kind == "plane" and abs(faces[f].normal @ stack.direction) > 1.0 - _FLAT
    }
    frozen = {c for c, caps in enumerate(stack.arrangement.caps) if not caps <= flat}
    graph = Graph(stack, frozen)
    merger = _Merger(graph, near, stack.direction)
    n = merger.run()
    if not n:
        return None
    heights = stack.solid.vertices @ stack.direction
    return merger.graph.lifted(np.array(merger.graph.points), heights.min()), _outlines(merger.graph, heights.min())


def _outlines(graph: Graph, height: float) -> list[Outline]:
    return [
        Outline(
            start=graph.ends(e)[0],
            end=graph.ends(e)[1],
            base=line.base,
            points=None if graph.is_kept(e) else graph.lifted(graph.samples(e), height),
            over=line.over,
            claims=() if graph.is_exact(e) else line.claims,
        )
        for e, line in graph.lines.items()
    ]


class _Merger:
    """Steps on a graph until none is left that may be made."""

    def __init__(self, graph: Graph, near: float, direction: FloatArray) -> None:
        self.graph = graph
        self.near = near
        self.direction = direction
        self.same = _SAME * graph.solid.size
        self._heights: dict[int, float] = {}
        self._zipped: set[int] = set()

    def run(self) -> int:
        """Make all steps; return how many."""
        done = 0
        steps = find_steps(self.graph, set(self.graph.cell.values()), self.near)
        for _ in range(_MOST_STEPS):
            steps.sort(reverse=True)
            made: set[int] | None = None
            while steps and made is None:
                step = steps.pop()
                made = self._make(step)
            if made is None:
                break
            done += 1
            # Only cells at the step have changed; steps across others stand.
            steps = [s for s in steps if not self._stale(s, made)]
            steps += find_steps(self.graph, made, self.near)
        return done

    def _stale(self, step: Step, cells: set[int]) -> bool:
        known = self.graph.cell
        return (
            step.one not in known or step.other not in known or known[step.one] in cells or known[step.other] in cells
        )

    def _height(self, edge: int) -> float:
        if edge not in self._heights:
            self._heights[edge] = float(self.graph.solid.edges[edge].midpoint @ self.direction)
        return self._heights[edge]

    # Making a step

    def _make(self, step: Step) -> set[int] | None:
        """Try a step; the cells that it changes, or None where it may not be made."""
        if step.one not in self.graph.next or step.other not in self.graph.next:
            return None
        trial = self.graph.copied()
        kept, self.graph = self.graph, trial
        changed = self._changed(step)
        if changed is None:
            self.graph = kept
        return changed

    def _changed(self, step: Step) -> set[int] | None:
        graph = self.graph
        if graph.cell[step.one] != graph.cell[step.other]:
            return None
        one, other = self._divided(step.one, step.at), self._divided(step.other, step.along)
        u, w = graph.origin[one], graph.origin[other]
        around = [*graph.leaving(one), *graph.leaving(other)]
        if u == w or any(graph.lines[h >> 1].frozen for h in around):
            return None
        between = [h >> 1 for h in graph.leaving(one) if graph.origin[h ^ 1] == w]
        if len(between) > 1 or any(graph.cell[one] not in {graph.cell[2 * e], graph.cell[2 * e + 1]} for e in between):
            return None
        others = [h for h in around if h >> 1 not in between]
        if not self._settle(others) or self._spread(others) > _FARTHEST * self.near:
            return None
        place = self._meeting(one, other)
        changed = {graph.cell[h] for h in around} | {graph.cell[h ^ 1] for h in around}
        crossings = n_crossings(graph, {h >> 1 for h in around}, changed)
        if between:
            graph.contract(between[0], place)
        else:
            graph.identify(one, other, place)
        vertex = w if w in set(graph.origin.values()) else u
        if not self._close_thin(vertex):
            return None
        bent = {h >> 1 for h in graph.leaving(self._leaving_one(vertex))}
        return None if n_crossings(graph, bent, changed) > crossings else changed

    def _divided(self, half: int, at: float) -> int:
        """The half-edge that begins at a fraction of another one, from its own start."""
        if at <= 0.0:
            return half
        e = half >> 1
        self.graph.split(e, 1.0 - at if half % 2 else at)
        return self.graph.next[half] if half % 2 == 0 else self._after(half, e)

    def _after(self, half: int, e: int) -> int:
        """Of an edge that is run against its way: the half that begins at its new vertex."""
        # The rest of the edge, which has a new number, comes first now; `half` begins at the new vertex.
        assert self.graph.before[half] >> 1 != e
        return half

    def _meeting(self, one: int, other: int) -> FloatArray:
        """Where two vertices meet: at the one that is a corner of the part, or half way."""
        graph = self.graph
        places = [graph.points[graph.origin[h]] for h in (one, other)]
        corners = [any(self._is_corner(claim, at) for claim, at in self._at(h)) for h in (one, other)]
        if corners[0] != corners[1]:
            return places[0 if corners[0] else 1]
        return np.asarray((places[0] + places[1]) / 2.0)

    def _at(self, half: int) -> list[tuple[Claim, float]]:
        """Claims at the vertex where a half-edge begins, and where on their edges that is."""
        found = []
        for h in self.graph.leaving(half):
            for claim in self.graph.lines[h >> 1].claims:
                found.append((claim, claim.end if h % 2 else claim.begin))
        return found

    @staticmethod
    def _is_corner(claim: Claim, at: float) -> bool:
        return at in {0.0, 1.0}

    def _apart(self, one: Claim, other: Claim, distance: float) -> bool:
        """Whether two claims may be at places so far from each other on one line."""
        a, b = (self._height(one.low), self._height(one.high)), (self._height(other.low), self._height(other.high))
        gap = max(a[0] - b[1], b[0] - a[1])
        return distance <= self.same or gap >= _STEEPEST * distance

    def _settle(self, around: Sequence[int]) -> bool:
        """Let all claims at vertices that meet be at one place on every height; False where they cannot."""
        graph = self.graph
        items = []  # (half, number of the claim)
        for h in around:
            items += [(h, k) for k in range(len(graph.lines[h >> 1].claims))]
        for _ in range(len(items) + 1):
            clash = self._first_clash(items)
            if clash is None:
                return True
            if not self._give_way(*clash):
                return False
        return False

    def _spread(self, around: Sequence[int]) -> float:
        """Largest distance between the places of claims at vertices that meet."""
        places = [self._place((h, k))[2] for h in around for k in range(len(self.graph.lines[h >> 1].claims))]
        return float(np.ptp(places, axis=0).max()) if places else 0.0

    def _place(self, item: tuple[int, int]) -> tuple[Claim, float, FloatArray]:
        h, k = item
        claim = self.graph.lines[h >> 1].claims[k]
        at = claim.end if h % 2 else claim.begin
        return claim, at, self.graph.claimed(claim, np.array([float(h % 2)]))[0]

    def _first_clash(self, items: list[tuple[int, int]]) -> tuple[tuple[int, int], tuple[int, int]] | None:
        known = [self._place(item) for item in items]
        for (j, (one, _, p)), (k, (other, _, q)) in combinations(enumerate(known), 2):
            if not self._apart(one, other, float(np.linalg.norm(p - q))):
                return items[j], items[k]
        return None

    def _give_way(self, one: tuple[int, int], other: tuple[int, int]) -> bool:
        """Move the end of one of two claims to the other's, along its own edge of the part."""
        (a, at, p), (b, bt, q) = self._place(one), self._place(other)
        for moving, claim, t, to in ((one, a, at, q), (other, b, bt, p)):
            if self._is_corner(claim, t):
                continue
            edge = self.graph.solid.edges[claim.edge]
            place = to @ self.graph.frame + self._height(claim.edge) * self.direction
            if float(edge.curve.distance(place[None])[0]) > self.same:
                continue
            self._move(moving, float(edge.curve.project(place[None])[0]))
            return self._runs_on(moving, claim)
        return False

    def _move(self, item: tuple[int, int], to: float) -> None:
        h, k = item
        line = self.graph.lines[h >> 1]
        claims = list(line.claims)
        to = (
            float(round(to)) if abs(to - round(to)) * self.graph.solid.edges[claims[k].edge].length <= self.same else to
        )
        claims[k] = replace(claims[k], end=to) if h % 2 else replace(claims[k], begin=to)
        self.graph.lines[h >> 1] = replace(line, claims=tuple(claims))

    def _runs_on(self, item: tuple[int, int], before: Claim) -> bool:
        """Whether a claim still runs the way it did, and is no point."""
        h, k = item
        claim = self.graph.lines[h >> 1].claims[k]
        length = self.graph.solid.edges[claim.edge].length
        return (claim.end - claim.begin) * np.sign(before.end - before.begin) * length > self.same

    def _close_thin(self, vertex: int) -> bool:
        """Lay the sides of cells of two edges at a vertex together; False where one is no thin gap."""
        graph = self.graph
        wide: set[int] = set()
        while True:
            pair = next(
                (
                    h
                    for h, origin in graph.origin.items()
                    if origin == vertex and graph.next[graph.next[h]] == h and graph.cell[h] >= 0 and h not in wide
                ),
                None,
            )
            if pair is None:
                break
            if self._is_wide(pair):
                wide |= {pair, graph.next[pair]}
            elif self._may_close(pair):
                graph.lay_together(pair)
            else:
                return False
        # An edge back to its own vertex is no outline.
        return not any(graph.origin[h] == graph.origin[h ^ 1] for h in graph.leaving(self._leaving_one(vertex)))

    def _leaving_one(self, vertex: int) -> int:
        return next(h for h, origin in self.graph.origin.items() if origin == vertex)

    def _is_wide(self, half: int) -> bool:
        """Whether a cell of two edges is wider than what is near."""
        graph, other, at = self.graph, self.graph.next[half], np.linspace(0.0, 1.0, 17)
        own = graph.places(half >> 1, at)[:: -1 if half % 2 else 1]
        beside = graph.places(other >> 1, at)[:: 1 if other % 2 else -1]
        return float(np.linalg.norm(own - beside, axis=1).max()) > _WIDE * self.near

    def _may_close(self, half: int) -> bool:
        graph = self.graph
        other = graph.next[half]
        lines = [graph.lines[h >> 1] for h in (half, other)]
        if (
            any(line.frozen for line in lines)
            or half >> 1 == other >> 1
            or graph.cell[half ^ 1] < 0 > graph.cell[other ^ 1]
        ):
            return False
        at = np.linspace(0.0, 1.0, 17)
        for one in lines[0].claims:
            for two in lines[1].claims:
                p = graph.claimed(one, at)[:: -1 if half % 2 else 1]
                q = graph.claimed(two, at)[:: 1 if other % 2 else -1]
                if not self._apart(one, two, float(np.linalg.norm(p - q, axis=1).max())):
                    return False
        return True
