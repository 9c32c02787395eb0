"""Sharp edges of a solid in runs: between the same two patches, from corner to corner.

Place in the flow: lines of a mesh of the design are laid on runs (:mod:`.carrying`). Where a blend ended between two
edges of a run there is no corner of the design, and nodes need not be at that vertex.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Collection
from dataclasses import dataclass
from math import pi

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Curve, Edge, Solid
from .springs import TANGENT

_KINK = 0.1
"""Turn of two edges at a vertex, radians, above which it is a corner of their run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """Edges head to tail, as one curve; fractions are of arc length from one end to the other.

    Attributes
    ----------
    pair : (int, int)
        The patches on either side.
    edges : tuple of Edge
    forward : tuple of bool
    ends : (int, int)
        Vertices; of a closed run twice the same.
    """

    pair: tuple[int, int]
    edges: tuple[Edge, ...]
    forward: tuple[bool, ...]
    ends: tuple[int, int]

    @property
    def length(self) -> float:
        """Of all edges together."""
        return sum(edge.length for edge in self.edges)

    @property
    def is_closed(self) -> bool:
        """Whether it ends where it begins."""
        return self.ends[0] == self.ends[1]

    @property
    def _starts(self) -> FloatArray:
        """Where each edge begins, and where the last one ends."""
        return np.cumsum([0.0, *(edge.length for edge in self.edges)]) / self.length

    def evaluate(self, fractions: FloatArray) -> FloatArray:
        """Points (m, 3); of a closed run fractions may go beyond its end."""
        at = np.asarray(fractions, dtype=np.float64)
        at = at % 1.0 if self.is_closed else np.clip(at, 0.0, 1.0)
        starts = self._starts
        which = np.clip(np.searchsorted(starts, at, side="right") - 1, 0, len(self.edges) - 1)
        found = np.empty((len(at), 3))
        for j in np.unique(which).tolist():
            own = np.flatnonzero(which == j)
            share = np.clip((at[own] - starts[j]) / (starts[j + 1] - starts[j]), 0.0, 1.0)
            found[own] = self.edges[j].curve.evaluate(share if self.forward[j] else 1.0 - share)
        return found

    def project(self, points: FloatArray) -> FloatArray:
        """Fractions (m,) of the nearest points."""
        starts = self._starts
        best, found = np.full(len(points), np.inf), np.zeros(len(points))
        for j, edge in enumerate(self.edges):
            share = edge.curve.project(points)
            off = np.linalg.norm(edge.curve.evaluate(share) - points, axis=1)
            share = share if self.forward[j] else 1.0 - share
            own = off < best
            best[own] = off[own]
            found[own] = starts[j] + share[own] * (starts[j + 1] - starts[j])
        return found

    def nearest(self, points: FloatArray) -> FloatArray:
        """The nearest points (m, 3)."""
        return self.evaluate(self.project(points))

    def distance(self, points: FloatArray) -> FloatArray:
        """Distances (m,) of points (m, 3)."""
        found: FloatArray = np.min([edge.curve.distance(points) for edge in self.edges], axis=0)
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class Stretch:
    """A run from one place to another, as the curve of an edge.

    Attributes
    ----------
    run : Run
    first, last : float
        Where it begins and ends; one beyond the other, either way, and of a closed run beyond 1.
    """

    run: Run
    first: float
    last: float

    def evaluate(self, fractions: FloatArray) -> FloatArray:
        """Points (m, 3)."""
        return self.run.evaluate(self.first + np.asarray(fractions) * (self.last - self.first))

    def project(self, points: FloatArray) -> FloatArray:
        """Fractions (m,) of the nearest points of the stretch."""
        at = self.run.project(points)
        if self.run.is_closed:
            low = min(self.first, self.last)
            at = low + (at - low) % 1.0
            over = at - max(self.first, self.last)
            at = np.where((over > 0) & (low + 1.0 - at < over), low, at)
        found: FloatArray = np.clip((at - self.first) / (self.last - self.first), 0.0, 1.0)
        return found

    def nearest(self, points: FloatArray) -> FloatArray:
        """The nearest points (m, 3)."""
        return self.evaluate(self.project(points))

    def distance(self, points: FloatArray) -> FloatArray:
        """Distances (m,) of points (m, 3)."""
        found: FloatArray = np.linalg.norm(self.nearest(points) - points, axis=1)
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class LaidLine:
    """A line of the mesh on the model.

    Attributes
    ----------
    nodes : (k,) int64
    run : Run
    curve : Curve
        From its first to its last node.
    """

    nodes: IntArray
    run: Run
    curve: Curve


def as_curve(run: Run, first: float, last: float) -> Curve:
    """The curve of a stretch; that of the edge where it is all of one."""
    if len(run.edges) == 1 and (first, last) == ((0.0, 1.0) if run.forward[0] else (1.0, 0.0)):
        return run.edges[0].curve
    return Stretch(run=run, first=first, last=last)


def find_runs(solid: Solid, patches: IntArray, corners: Collection[int]) -> list[Run]:
    """Runs of the edges of a solid that are between two patches, or sharp within one.

    They go on around a kink, but for one at a vertex that is among the `corners`: a design has an edge go straight on
    where a blend of the model ends with one.
    """
    sharp = [edge.id for edge in solid.edges if is_line(edge, patches)]

    def goes_on(vertex: int, one: int, other: int) -> bool:
        if {patches[f] for f in solid.edges[one].faces} != {patches[f] for f in solid.edges[other].faces}:
            return False
        if vertex not in corners:
            return True
        tangents = [_leaving(solid.edges[e], vertex) for e in (one, other)]
        return bool(tangents[0] @ tangents[1] < -np.cos(_KINK))

    return chained(solid, patches, sharp, goes_on)


def chained(
    solid: Solid, patches: IntArray, edges: Collection[int], goes_on: Callable[[int, int, int], bool]
) -> list[Run]:
    """Runs of some edges of a solid: on at a vertex from one to the other, where two meet there and it `goes_on`."""
    at: dict[int, list[int]] = defaultdict(list)
    for e in edges:
        for vertex in (solid.edges[e].start, solid.edges[e].end):
            at[vertex].append(e)
    left, runs = dict.fromkeys(edges), []
    while left:
        first = next(iter(left))
        del left[first]
        run = [(first, True)]
        for _ in range(2):
            while True:
                e, ahead = run[-1]
                vertex = solid.edges[e].end if ahead else solid.edges[e].start
                own = at[vertex]
                is_on = len(own) == 2 and own[0] != own[1] and goes_on(vertex, *own)
                following = [other for other in own if other in left] if is_on else []
                if not following:
                    break
                del left[following[0]]
                run.append((following[0], solid.edges[following[0]].start == vertex))
            run = [(e, not ahead) for e, ahead in reversed(run)]
        low, high = sorted(int(patches[f]) for f in solid.edges[first].faces)
        ends = solid.first_vertex(run[0]), solid.last_vertex(run[-1])
        runs.append(
            Run(pair=(low, high), edges=tuple(solid.edges[e] for e, _ in run), forward=tuple(a for _, a in run),
                ends=ends)
        )  # fmt: skip
    return runs


def is_line(edge: Edge, patches: IntArray) -> bool:
    """Whether an edge is between two patches, or sharp within one."""
    one, other = (int(patches[f]) for f in edge.faces)
    return one != other or abs(edge.dihedral - pi) > TANGENT


def _leaving(edge: Edge, vertex: int) -> FloatArray:
    tangent: FloatArray = edge.tangents[0] if edge.start == vertex else -edge.tangents[1]
    return tangent


__all__ = ["LaidLine", "Run", "Stretch", "as_curve", "chained", "find_runs", "is_line"]
