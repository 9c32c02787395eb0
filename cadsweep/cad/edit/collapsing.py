"""The topology of a design: the blends of a solid shrunk to what they stand for, on ids alone.

Place in the flow: :mod:`.sharpening` gives it places, curves and faces.

Method: what runs across a blend, its ends and all borders of a corner's patch shrink to vertices; its two long borders
become one edge between its supports, cut where an edge of either support ends at it. Everything else stays. So two
blends that meet in a mitre end in one vertex, and what was rolled over the end of another leaves nothing there::

       A  |  B              A  |  B
     _____|_____          _____|_____
     __blend____    ->                      one edge for the blend, cut where that between A and B ends at it
          C                    C

Not handled: borders of a blend that are broken, as by a hole through it; blends side by side that no face lies between.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from ...brep import Solid

SAMPLES = 33
"""Places on every edge of a design."""
TANGENT = 0.05
"""Largest angle between faces, radians, at an edge that is smooth."""
_SAME = 0.02
"""Share of a blend's length within which what ends at it from both sides ends there at one place."""


class Rounding(Protocol):
    """What replaces an edge, with its supports on either side, or a corner."""

    @property
    def kind(self) -> str:
        """``"edge"`` or ``"corner"``."""
        ...

    @property
    def faces(self) -> tuple[int, ...]:
        """Ids of its faces."""
        ...

    @property
    def supports(self) -> tuple[tuple[int, ...], ...]:
        """Faces on either side of an edge."""
        ...


class CannotCloseError(Exception):
    """Some faces of blends have to stay, as the others do not close over them.

    Attributes
    ----------
    faces : frozenset of int
    """

    def __init__(self, faces: Collection[int], why: str) -> None:
        super().__init__(why)
        self.faces = frozenset(faces)


@dataclass(frozen=True, kw_only=True, eq=False)
class SharpEdge:
    """An edge of the design.

    Attributes
    ----------
    ends : (int, int)
        Vertices of the design.
    faces : tuple of int
        The two faces of the model that meet there.
    places : (SAMPLES, 3) float64
        About where it lies, from one end to the other.
    origin : int or None
        The edge of the model that it is; None where it stands for a blend.
    blend : tuple of int
        Faces of that.
    """

    ends: tuple[int, int]
    faces: tuple[int, ...]
    places: FloatArray
    origin: int | None = None
    blend: tuple[int, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Collapsed:
    """The topology of a design.

    Attributes
    ----------
    vertices : dict of int to list of int
        Of every vertex those of the model that it stands for; its number is the least of them.
    edges : list of SharpEdge
    loops : dict of int to list of list of (int, bool)
        Of every face that stays its loops, of edges of the design and whether they are run through forward.
    """

    vertices: dict[int, list[int]]
    edges: list[SharpEdge]
    loops: dict[int, list[list[tuple[int, bool]]]]


def collapse(solid: Solid, blends: Sequence[Rounding]) -> Collapsed:
    """Shrink blends.

    Raises
    ------
    CannotCloseError
        Some cannot be.
    """
    return _Collapsing(solid, blends).result()


class _Collapsing:
    def __init__(self, solid: Solid, blends: Sequence[Rounding]) -> None:
        self.solid, self.blends = solid, blends
        self.blend_of = {f: b for b, blend in enumerate(blends) for f in blend.faces}
        self.root = list(range(len(solid.vertices)))
        self.side = self._sides()
        self.edges: list[SharpEdge] = []
        self.pieces: dict[int, list[tuple[int, bool]]] = {}

    def find(self, vertex: int) -> int:
        while self.root[vertex] != vertex:
            vertex = self.root[vertex]
        return vertex

    def join(self, one: int, other: int) -> None:
        low, high = sorted((self.find(one), self.find(other)))
        self.root[high] = low

    def result(self) -> Collapsed:
        for e in self._shrinking():
            self.join(self.solid.edges[e].start, self.solid.edges[e].end)
        for b, blend in enumerate(self.blends):
            if blend.kind == "edge":
                self._cut(b)
        at = np.linspace(0.0, 1.0, SAMPLES)
        for edge in self.solid.edges:
            if not any(f in self.blend_of for f in edge.faces):
                self.pieces[edge.id] = [(len(self.edges), True)]
                ends = self.find(edge.start), self.find(edge.end)
                self.edges.append(
                    SharpEdge(ends=ends, faces=edge.faces, places=edge.curve.evaluate(at), origin=edge.id)
                )
        loops = {face.id: list(self._loops(face.id)) for face in self.solid.faces if face.id not in self.blend_of}
        # Numbers of vertices are final now: those of one place were joined as blends were cut.
        edges = [replace(own, ends=(self.find(own.ends[0]), self.find(own.ends[1]))) for own in self.edges]
        for own in edges:
            if own.ends[0] == own.ends[1]:
                raise CannotCloseError(self._around(own.ends[0]), "an edge beside it has no length any more")
        used = {v for own in edges for v in own.ends}
        vertices: dict[int, list[int]] = {v: [] for v in sorted(used)}
        for v in range(len(self.root)):
            if self.find(v) in used:
                vertices[self.find(v)].append(v)
        return Collapsed(vertices=vertices, edges=edges, loops=loops)

    def _sides(self) -> dict[int, int]:
        """Long borders of blends, by edge: which of the two sides each is of."""
        found = {}
        for edge in self.solid.edges:
            own = [f for f in edge.faces if f in self.blend_of]
            if len(own) != 1 or abs(edge.dihedral - pi) > TANGENT:
                continue
            blend = self.blends[self.blend_of[own[0]]]
            (outside,) = (f for f in edge.faces if f not in self.blend_of)
            sides = [s for s, support in enumerate(blend.supports) if outside in support]
            if blend.kind == "edge" and sides:
                if len(sides) > 1:
                    raise CannotCloseError(blend.faces, "it lies between a face and itself")
                found[edge.id] = sides[0]
        return found

    def _shrinking(self) -> Iterator[int]:
        """Edges that shrink to a vertex."""
        at: dict[tuple[int, int], set[int]] = {}
        for e, side in self.side.items():
            edge = self.solid.edges[e]
            (b,) = (self.blend_of[f] for f in edge.faces if f in self.blend_of)
            at.setdefault((b, side), set()).update((edge.start, edge.end))
        for edge in self.solid.edges:
            own = [self.blend_of[f] for f in edge.faces if f in self.blend_of]
            if not own or edge.id in self.side:
                continue
            if len(own) == 2 and own[0] == own[1] and self.blends[own[0]].kind == "edge":
                first, second = at.get((own[0], 0), set()), at.get((own[0], 1), set())
                ends = edge.start, edge.end
                if not any(a in first and b in second for a, b in (ends, ends[::-1])):
                    continue  # it runs along the blend
            yield edge.id

    def _cut(self, b: int) -> None:
        """Make the edges that a blend stands for."""
        blend = self.blends[b]
        chains = [self._chain(b, side) for side in (0, 1)]
        starts = [[self._first(d) for d in chain] for chain in chains]
        common = [v for v in starts[0] if v in starts[1]]
        ends = [self._last(chain[-1]) for chain in chains]
        if not common or ends[0] != ends[1]:
            raise CannotCloseError(blend.faces, "its borders do not end together")
        if all(own[0] == end for own, end in zip(starts, ends, strict=True)):  # closed: both begin at one place
            chains = [_rotated(chain, own.index(common[0])) for chain, own in zip(chains, starts, strict=True)]
            starts = [[self._first(d) for d in chain] for chain in chains]
            ends = [common[0]] * 2
        elif starts[0][0] != starts[1][0]:
            raise CannotCloseError(blend.faces, "its borders do not begin together")
        cuts = [[*own, end] for own, end in zip(starts, ends, strict=True)]
        at = [0, 0]
        while at[0] < len(chains[0]):
            to = [self._next(cuts, at, s) for s in (0, 1)]
            if cuts[0][to[0]] != cuts[1][to[1]]:
                raise CannotCloseError(blend.faces, "its borders turn round")
            self._between(blend, [chain[i:j] for chain, i, j in zip(chains, at, to, strict=True)])
            at = to

    def _next(self, cuts: list[list[int]], at: list[int], side: int) -> int:
        """The next place on a side that is one on the other, too."""
        other = set(cuts[1 - side][at[1 - side] + 1 :])
        return next(j for j in range(at[side] + 1, len(cuts[side])) if cuts[side][j] in other)

    def _between(self, blend: Rounding, chains: list[list[tuple[int, bool]]]) -> None:
        """Edges between two places that both borders have; what ends at one border alone cuts the other."""
        shares = [self._shares(chain) for chain in chains]
        cuts = [(0.0, self._first(chains[0][0]))]
        inner = sorted(
            (float(share), self._first(chain[j]))
            for chain, own in zip(chains, shares, strict=True) for j, share in enumerate(own[:-1]) if j
        )  # fmt: skip
        for share, vertex in inner:
            if share - cuts[-1][0] < _SAME and len(cuts) > 1:
                self.join(vertex, cuts[-1][1])
            else:
                cuts.append((share, vertex))
        cuts.append((1.0, self._last(chains[0][-1])))
        for (low, start), (high, end) in pairwise(cuts):
            sides = [int(np.searchsorted(own, 0.5 * (low + high))) - 1 for own in shares]
            uses = [chain[j] for chain, j in zip(chains, sides, strict=True)]
            places = [
                self._places(chain, own, np.linspace(low, high, SAMPLES))
                for chain, own in zip(chains, shares, strict=True)
            ]
            number = len(self.edges)
            for e, ahead in uses:
                self.pieces.setdefault(e, []).append((number, ahead))
            faces = tuple(f for e, _ in uses for f in self.solid.edges[e].faces if f not in self.blend_of)
            self.edges.append(
                SharpEdge(ends=(start, end), faces=faces, places=np.mean(places, axis=0), blend=blend.faces)
            )

    def _chain(self, b: int, side: int) -> list[tuple[int, bool]]:
        """Edges of a border head to tail, side 0 as its blend has it and side 1 the other way round."""
        following: dict[int, tuple[int, bool]] = {}
        for f in self.blends[b].faces:
            for loop in self.solid.faces[f].loops:
                for e, ahead in loop.directed:
                    if self.side.get(e) == side and any(self.blend_of.get(g) == b for g in self.solid.edges[e].faces):
                        use = (e, ahead == (side == 0))
                        if following.setdefault(self._first(use), use) != use:
                            raise CannotCloseError(self.blends[b].faces, "its border parts")
        ends = {self._last(use) for use in following.values()}
        chain: list[tuple[int, bool]] = []
        at = next((v for v in following if v not in ends), next(iter(following), -1))
        while at in following:
            chain.append(following.pop(at))
            at = self._last(chain[-1])
        if following or not chain:
            raise CannotCloseError(self.blends[b].faces, "its border is broken")
        return chain

    def _first(self, use: tuple[int, bool]) -> int:
        return self.find(self.solid.first_vertex(use))

    def _last(self, use: tuple[int, bool]) -> int:
        return self.find(self.solid.last_vertex(use))

    def _shares(self, chain: list[tuple[int, bool]]) -> FloatArray:
        lengths = np.cumsum([0.0, *(self.solid.edges[e].length for e, _ in chain)])
        return lengths / lengths[-1]

    def _places(self, chain: list[tuple[int, bool]], shares: FloatArray, at: FloatArray) -> FloatArray:
        which = np.clip(np.searchsorted(shares, at, side="right") - 1, 0, len(chain) - 1)
        found = np.empty((len(at), 3))
        for j, (e, ahead) in enumerate(chain):
            own = which == j
            share = (at[own] - shares[j]) / (shares[j + 1] - shares[j])
            found[own] = self.solid.edges[e].curve.evaluate(share if ahead else 1.0 - share)
        return found

    def _loops(self, face: int) -> Iterator[list[tuple[int, bool]]]:
        for loop in self.solid.faces[face].loops:
            found: list[tuple[int, bool]] = []
            for e, ahead in loop.directed:
                own = self.pieces.get(e, [])
                found += [(k, way == ahead) for k, way in (own if not own or own[0][1] == ahead else own[::-1])]
            if len(found) < 2:
                beside = {f for e in loop.edges for f in self.solid.edges[e].faces if f in self.blend_of}
                raise CannotCloseError(beside, "a face beside it has no border any more")
            yield found

    def _around(self, vertex: int) -> set[int]:
        """Faces of blends around what shrinks to a vertex."""
        return {
            f for edge in self.solid.edges if vertex in (self.find(edge.start), self.find(edge.end))
            for f in edge.faces if f in self.blend_of
        }  # fmt: skip


def _rotated(chain: list[tuple[int, bool]], first: int) -> list[tuple[int, bool]]:
    return chain[first:] + chain[:first]


__all__ = ["SAMPLES", "TANGENT", "CannotCloseError", "Collapsed", "Rounding", "SharpEdge", "collapse"]
