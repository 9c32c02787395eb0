"""The lines of an arrangement as a planar graph that can be changed: ends brought together, edges laid on each other.

Place in the flow: foundation of :mod:`.merging`. A *claim* is what of the part lies over an edge: from one height to
another a wall stands there, or two caps meet. Every claim remembers where on its own edge of the part it begins and
ends, so that an edge of the graph may be moved while what lies over it stays known.

Method: half-edges. Half ``2 e`` runs along edge e from its start to its end, ``2 e + 1`` back; its cell lies on
its left, seen against the direction of the stack.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from ..arrays import FloatArray
from ..brep import Solid
from ..stack import Claim, Stack
from .along import across

_TURN = np.radians(6.0)
"""Turn of an edge from one of its samples to the next."""
_MOST_SAMPLES = 65
_SAME = 1e-7
"""Distance, in sizes of the part, up to which places are the same."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """An edge of the graph.

    Attributes
    ----------
    base : int
        Edge of the arrangement whose curve it has, moved so that its ends are where its vertices are.
    span : (float, float)
        What of that curve, in fractions of its length.
    over : tuple of (int, bool)
        Edges of the part that lie over it, and whether they run the same way.
    claims : tuple of Claim
    frozen : bool
        Whether it must stay as it is.
    """

    base: int
    span: tuple[float, float]
    over: tuple[tuple[int, bool], ...]
    claims: tuple[Claim, ...]
    frozen: bool

    def reversed(self) -> Line:
        """The same run the other way."""
        return replace(
            self,
            span=self.span[::-1],
            over=tuple((e, not same) for e, same in self.over),
            claims=tuple(replace(claim, begin=claim.end, end=claim.begin) for claim in self.claims),
        )


class Graph:
    """Vertices and lines of an arrangement, with the cells between them.

    Attributes
    ----------
    points : list of (2,) float64
        By vertex.
    lines : dict of int to Line
        By number.
    origin, next, before, cell : dict of int to int
        By half-edge: the vertex where it begins, those that follow it and that it follows around its cell, and the
        cell, -1 outside.
    """

    def __init__(self, stack: Stack, frozen_cells: set[int]) -> None:
        arrangement = stack.arrangement
        prism = arrangement.prism
        self.frame, self._up = across(stack.direction), stack.direction
        self.solid: Solid = stack.solid
        self._curves = {e: prism.edges[e].curve for e in arrangement.over}
        self._ends = {e: (prism.edges[e].start, prism.edges[e].end) for e in arrangement.over}
        self._n_samples = {e: _samples_of(prism, e) for e in arrangement.over}
        self.points: list[FloatArray] = list(prism.vertices @ self.frame.T)
        self.given = len(self.points)
        self.lines: dict[int, Line] = {}
        self.origin: dict[int, int] = {}
        self.next: dict[int, int] = {}
        self.before: dict[int, int] = {}
        self.cell: dict[int, int] = {}
        for e in arrangement.over:
            self.origin[2 * e], self.origin[2 * e + 1] = prism.edges[e].start, prism.edges[e].end
            self.cell[2 * e] = self.cell[2 * e + 1] = -1
        for c, f in enumerate(arrangement.bottoms):
            for loop in prism.faces[f].loops:
                # The bottom is seen from below by its own loops.
                halves = [2 * e + int(forward) for e, forward in reversed(loop.directed)]
                for h, following in zip(halves, [*halves[1:], halves[0]], strict=True):
                    self._chain(h, following)
                    self.cell[h] = c
        outside = {self.origin[h]: h for h, c in self.cell.items() if c < 0}
        for h, c in self.cell.items():
            if c < 0:
                self._chain(h, outside[self.origin[h ^ 1]])
        for e, over in arrangement.over.items():
            claims = find_claims(stack, e)
            frozen = bool({self.cell[2 * e], self.cell[2 * e + 1]} & frozen_cells) or claims is None
            ways = tuple(zip(over, arrangement.ways[e], strict=True))
            self.lines[e] = Line(base=e, span=(0.0, 1.0), over=ways, claims=claims or (), frozen=frozen)
        self._given_claims = {e: line.claims for e, line in self.lines.items()}
        self._last = max(self.lines, default=-1)

    def lifted(self, points: FloatArray, height: float) -> FloatArray:
        """Points (m, 3) in space of places (m, 2), at a height along the direction."""
        return np.asarray(points @ self.frame + height * self._up)

    def copied(self) -> Graph:
        """A graph that may be changed without this one."""
        other = copy(self)
        for name in ("points", "lines", "origin", "next", "before", "cell"):
            setattr(other, name, copy(getattr(self, name)))
        return other

    def _chain(self, first: int, second: int) -> None:
        self.next[first], self.before[second] = second, first

    def loop(self, half: int) -> list[int]:
        """Half-edges around a cell's loop, from one of them on."""
        found = [half]
        while (half := self.next[half]) != found[0]:
            found.append(half)
        return found

    def loops(self) -> Iterator[list[int]]:
        """All loops."""
        left = set(self.next)
        while left:
            loop = self.loop(next(iter(left)))
            left.difference_update(loop)
            yield loop

    def leaving(self, vertex_half: int) -> list[int]:
        """Half-edges that begin where one does."""
        found, half = [vertex_half], vertex_half
        while (half := self.next[half ^ 1]) != vertex_half:
            found.append(half)
        return found

    def ends(self, e: int) -> tuple[int, int]:
        """Vertices at the start and the end of an edge."""
        return self.origin[2 * e], self.origin[2 * e + 1]

    def places(self, e: int, fractions: FloatArray) -> FloatArray:
        """Points (m, 2) of an edge: its curve, moved so that it begins and ends at its vertices."""
        line = self.lines[e]
        a, b = line.span
        on_curve = (
            self._curves[line.base].evaluate(a + (b - a) * np.concatenate([[0.0, 1.0], fractions])) @ self.frame.T
        )
        start, end = (self.points[v] - place for v, place in zip(self.ends(e), on_curve, strict=False))
        return np.asarray(on_curve[2:] + (1.0 - fractions)[:, None] * start + fractions[:, None] * end)

    def samples(self, e: int) -> FloatArray:
        """Points (m, 2) of an edge, dense enough for its turns."""
        line = self.lines[e]
        n = max(2, ceil(self._n_samples[line.base] * abs(line.span[1] - line.span[0])))
        return self.places(e, np.linspace(0.0, 1.0, n))

    def is_kept(self, e: int) -> bool:
        """Whether an edge is the arrangement's own, unmoved."""
        line = self.lines[e]
        if line.span != (0.0, 1.0) or self.ends(e) != self._ends[line.base]:
            return False
        ends = self._curves[line.base].evaluate(np.array([0.0, 1.0])) @ self.frame.T
        gaps = [self.points[v] - place for v, place in zip(self.ends(e), ends, strict=True)]
        return float(np.abs(gaps).max()) <= _SAME * self.solid.size

    def is_exact(self, e: int) -> bool:
        """Whether an edge is the arrangement's own and lies under all that lies over it."""
        return self.is_kept(e) and self.lines[e].claims == self._given_claims[self.lines[e].base]

    def claimed(self, claim: Claim, fractions: FloatArray) -> FloatArray:
        """Points (m, 2) where a claim wants the nodes at fractions of its edge of the graph."""
        at = claim.begin + (claim.end - claim.begin) * fractions
        return np.asarray(self.solid.edges[claim.edge].curve.evaluate(at) @ self.frame.T)

    def split(self, e: int, fraction: float) -> int:
        """Divide an edge; return the new vertex, where the new edge begins that has the rest of it."""
        line, place = self.lines[e], self.places(e, np.array([fraction]))[0]
        a, b = line.span
        middle = a + fraction * (b - a)
        halves = [claim.begin + fraction * (claim.end - claim.begin) for claim in line.claims]
        first = tuple(replace(claim, end=at) for claim, at in zip(line.claims, halves, strict=True))
        second = tuple(replace(claim, begin=at) for claim, at in zip(line.claims, halves, strict=True))
        self._last += 1
        new, vertex = self._last, len(self.points)
        self.points.append(place)
        self.lines[e] = replace(line, span=(a, middle), claims=first)
        self.lines[new] = replace(line, span=(middle, b), claims=second)
        there, back = 2 * e, 2 * e + 1
        self.origin[2 * new], self.origin[2 * new + 1], self.origin[back] = vertex, self.origin[back], vertex
        self.cell[2 * new], self.cell[2 * new + 1] = self.cell[there], self.cell[back]
        following, preceding = self.next[there], self.before[back]
        if following == back:  # the edge hangs free: it turns round at its end
            self._chain(2 * new, 2 * new + 1)
        else:
            self._chain(2 * new, following)
            self._chain(preceding, 2 * new + 1)
        self._chain(there, 2 * new)
        self._chain(2 * new + 1, back)
        return vertex

    def _name(self, half: int, vertex: int) -> None:
        for leaving in self.leaving(half):
            self.origin[leaving] = vertex

    def identify(self, one: int, other: int, place: FloatArray) -> None:
        """Make one vertex of those where two half-edges of one cell begin."""
        before_one, before_other = self.before[one], self.before[other]
        self._chain(before_one, other)
        self._chain(before_other, one)
        vertex = self.origin[one]
        self._name(one, vertex)
        self.points[vertex] = place

    def contract(self, e: int, place: FloatArray) -> None:
        """Make one vertex of the ends of an edge, and take the edge away."""
        there, back = 2 * e, 2 * e + 1
        stays = next((h for h in (self.next[there], self.next[back]) if h >> 1 != e), None)
        assert stays is not None, "an edge alone is no outline"
        vertex = self.origin[there]
        for h in (there, back):
            self._chain(self.before[h], self.next[h])
        self._remove(e)
        self._name(stays, vertex)
        self.points[vertex] = place

    def lay_together(self, half: int) -> int:
        """Make one edge of the two around a cell of two edges; return it."""
        other = self.next[half]
        one_line = self.lines[half >> 1] if half % 2 == 0 else self.lines[half >> 1].reversed()
        other_line = self.lines[other >> 1] if other % 2 else self.lines[other >> 1].reversed()
        gaps = [self._strain(e) for e in (half >> 1, other >> 1)]
        base = one_line if gaps[0] <= gaps[1] else other_line
        merged = replace(
            base, over=one_line.over + other_line.over, claims=one_line.claims + other_line.claims, frozen=False
        )
        # What is left are the other sides of both: one edge, which takes the first one's number.
        outer, opposite = half ^ 1, other ^ 1
        e = half >> 1
        start, end = self.origin[half], self.origin[other]
        there, back = 2 * e + half % 2, 2 * e + 1 - half % 2
        before, after = self.before[opposite], self.next[opposite]
        cell = self.cell[opposite]
        # `back` is the outer side already; `there` becomes the other outer side.
        assert back == outer
        self.cell[there] = cell
        self._chain(before if before != opposite else there, there)
        self._chain(there, after if after != opposite else there)
        self.origin[there], self.origin[back] = start, end
        for h in (other, opposite):
            del self.next[h], self.before[h], self.origin[h], self.cell[h]
        del self.lines[other >> 1]
        self.lines[e] = merged if half % 2 == 0 else merged.reversed()
        return e

    def _strain(self, e: int) -> float:
        """How far the ends of an edge were moved from its curve."""
        line = self.lines[e]
        ends = self._curves[line.base].evaluate(np.array(line.span)) @ self.frame.T
        return float(sum(np.linalg.norm(self.points[v] - p) for v, p in zip(self.ends(e), ends, strict=True)))

    def _remove(self, e: int) -> None:
        del self.lines[e]
        for h in (2 * e, 2 * e + 1):
            del self.next[h], self.before[h], self.origin[h], self.cell[h]


def _samples_of(prism: Solid, e: int) -> int:
    edge = prism.edges[e]
    if edge.kind == "line":
        return 2
    at = np.linspace(0.0, 1.0, 33)
    steps = np.diff(edge.curve.evaluate(at), axis=0)
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-300)
    turn = float(np.arccos(np.clip((steps[1:] * steps[:-1]).sum(axis=1), -1.0, 1.0)).sum())
    return min(_MOST_SAMPLES, 2 + ceil(turn / _TURN))


def find_claims(stack: Stack, e: int) -> tuple[Claim, ...] | None:
    """What of the part lies over an edge of its arrangement; None where that cannot be told."""
    solid, arrangement = stack.solid, stack.arrangement
    caps = {*stack.source, *stack.target}
    walls = set(stack.walls)
    rims: dict[int, list[int]] = {}
    lone: list[int] = []
    over = arrangement.over[e]
    for one in over:
        faces = [f for f in solid.edges[one].faces if f in walls]
        for f in faces:
            rims.setdefault(f, []).append(one)
        if not faces:
            lone.append(one)
        elif not caps & set(solid.edges[one].faces) and one not in stack.stations:
            return None
    found = [_claim(stack, e, one, one, one) for one in lone]
    for own in rims.values():
        own.sort(key=lambda one: float(solid.edges[one].midpoint @ stack.direction))
        if len(own) % 2:
            return None
        found += [_claim(stack, e, low, low, high) for low, high in zip(own[::2], own[1::2], strict=True)]
    return tuple(found)


def _claim(stack: Stack, e: int, edge: int, low: int, high: int) -> Claim:
    whole = stack.solid.edges[edge]
    own = stack.arrangement.prism.edges[e]
    rise = float((whole.midpoint - own.midpoint) @ stack.direction) * stack.direction
    ends = stack.arrangement.prism.vertices[[own.start, own.end]] + rise
    begin, end = (float(t) for t in whole.curve.project(ends))
    same = stack.arrangement.ways[e][stack.arrangement.over[e].index(edge)]
    # An end of the edge is its end to the last bit.
    begin, end = (round(t) if abs(t - round(t)) * whole.length <= 1e-7 * stack.solid.size else t for t in (begin, end))
    if whole.start == whole.end and begin == end:
        begin, end = (0.0, 1.0) if same else (1.0, 0.0)
    return Claim(edge=edge, begin=float(begin), end=float(end), low=low, high=high)


__all__ = ["Graph", "Line", "find_claims"]
