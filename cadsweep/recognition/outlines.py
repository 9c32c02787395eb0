"""Where edges on both caps would be divided so that outlines on them, which nearly coincide, answer each other.

A plate between the hexagon of a bolt's head and the round face of a nut has an outline on either cap. A sweep carries
one of them; where each edge has one to answer it on the other cap, it follows both, and leans a little. Where the two
are far apart, the plate is cut along them instead.

Place in the flow: asked by ``pipeline`` for a cell without a sweep; ``cad`` divides the edges, and it is read anew.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TypeVar

import numpy as np
import scipy

from ..arrays import FloatArray
from ..brep import Loop, Solid
from ..errors import NotSweepableError
from ..sweep import DirectedEdge, Sweep
from .bands import find_bands
from .build import assemble_sweep
from .layout import choose_bands, lay_out
from .match import join_boundaries, matched_points, partner_of

ALIKE = "sweep: outlines of both caps divided alike"
"""The row of the table that is this module."""
_LEAN = 0.5
"""Distance of two outlines along the caps, over that between the caps, up to which hexahedra may lean."""
_NEAR = 0.25
"""The same over the outlines' own extent: what is farther apart is another outline."""
_SNAP = 0.2
"""Share of the shorter of the edges beside them up to which two vertices are apart that answer each other."""
_SAMPLES = 33
"""Places on every edge, between which it is taken to be straight."""

_LEAST_GAP = 0.02
"""Share of an edge that is between two vertices on it at most where there need be none."""
_EDGE = 1e-3
"""Share of an edge by which places that are one may differ by rounding."""
_FIXED = 1e9
"""Weight of a vertex that answers another beside those that are new."""

Divisions = dict[int, list[float]]
"""Where edges are divided, in fractions of their length."""


def find_divisions(solid: Solid) -> Divisions | None:
    """Where edges of a solid's caps are to be divided; None where that gives it no sweep.

    Parameters
    ----------
    solid : Solid
        A cell without a sweep.
    """
    for bands in choose_bands(find_bands(solid, most_readings=1).bands):
        with suppress(NotSweepableError):  # other bands may do
            for layout in lay_out(solid, bands):
                found = _divisions(assemble_sweep(solid, layout))
                if found:
                    return found
    return None


def _divisions(sweep: Sweep) -> Divisions | None:
    """Where edges of both caps are divided; None where their faces do not answer each other one by one."""
    joined = join_boundaries(sweep)
    if not joined or not len(sweep.source) == len(sweep.target) > 1:
        return None
    with suppress(_UnlikeError):
        walk = _Walk(sweep, joined)
        walk.go()
        return walk.divisions if len(walk.answers) == len(sweep.source) else None
    return None


class _UnlikeError(Exception):
    """The caps have other faces, or outlines that are too far apart."""


class _Walk:
    """A walk over both caps side by side, face by face, from the edges that linking sides join.

    Attributes
    ----------
    answers : dict of int to int
        Faces of the target cap that answer faces of the source cap.
    chains : dict of int to int
        The chain that an edge of either cap is of: equal for edges that answer each other, one by one or all of them.
    divisions : dict
    """

    def __init__(self, sweep: Sweep, joined: Mapping[int, DirectedEdge]) -> None:
        self.solid, self.divisions = sweep.solid, Divisions()
        self.caps = set(sweep.source), set(sweep.target)
        near, far = matched_points(self.solid, dict(joined))
        self.center, self.far_center = near.mean(axis=0), far.mean(axis=0)
        self.fit, *_ = np.linalg.lstsq(near - self.center, far - self.far_center, rcond=1e-9)
        self.most = _LEAN * min(sum(lengths) for lengths in sweep.span_lengths)
        self.chains: dict[int, int] = {}
        self.answers: dict[int, int] = {}
        self.waiting: list[tuple[int, int]] = []
        for chain, (a, (b, same)) in enumerate(joined.items()):
            self.chains |= {a: chain, b: chain}
            for f in set(self.solid.edges[a].faces) & set(sweep.source):
                self.meet(f, partner_of(self.solid, (f, a), (b, same), set(sweep.target)))

    def meet(self, face: int, other: int | None) -> None:
        """Take two faces of the caps for answers of each other."""
        if (face in self.caps[0]) != (other in self.caps[1]):
            raise _UnlikeError
        if other is None or face not in self.caps[0]:
            return
        if self.answers.setdefault(face, other) != other:
            raise _UnlikeError
        if (face, other) not in self.waiting:
            self.waiting.append((face, other))

    def go(self) -> None:
        """Walk until all faces have been met."""
        for f, g in self.waiting:  # which grows
            loops, others = list(self.solid.faces[f].loops), list(self.solid.faces[g].loops)
            if len(loops) != len(others):
                raise _UnlikeError
            for loop in sorted(loops, key=self.is_inner):
                if self.is_inner(loop):
                    other = self.nearest(loop, [one for one in others if self.is_inner(one)])
                    self.begin((f, loop), (g, other))
                else:
                    known = {self.chains[e] for e in loop.edges if e in self.chains}
                    other = _first(one for one in others if known & {self.chains.get(e) for e in one.edges})
                    self.compare((f, loop), (g, other))
                others.remove(other)

    def is_inner(self, loop: Loop) -> bool:
        """Whether nothing answers any of its edges yet."""
        return self.chains.keys().isdisjoint(loop.edges)

    def compare(self, of: tuple[int, Loop], to: tuple[int, Loop]) -> None:
        """Walk along two loops, chain by chain, from one whose answer is known."""
        (f, loop), (g, other) = of, to
        one, two = self.in_chains(loop.directed, f), self.in_chains(_backwards(other.directed), g)
        start = _first(j for j, (chain, _, _) in enumerate(one) if chain is not None)
        far = _first(j for j, (chain, _, _) in enumerate(two) if chain == one[start][0])
        one, two = one[start:] + one[:start], two[far:] + two[:far]
        if [chain for chain, _, _ in one] != [chain for chain, _, _ in two]:
            raise _UnlikeError
        for (chain, across, edges), (_, _, far_edges) in zip(one, two, strict=True):
            if chain is None:
                if across in self.caps[0]:  # a linking side need not have as many edges at both ends
                    self.divisions |= _by_lengths(self.solid, edges, far_edges)
                self.follow((f, [e for e, _ in edges]), (g, [e for e, _ in far_edges]))

    def in_chains(self, edges: Sequence[DirectedEdge], face: int) -> list[tuple[int | None, int, list[DirectedEdge]]]:
        """Edges of a loop by the chain that they are of, and the face across."""
        found: list[tuple[int | None, int, list[DirectedEdge]]] = []
        for edge in edges:
            chain, across = self.chains.get(edge[0]), _across(self.solid, [edge[0]], face)
            if found and found[-1][0] == chain and (chain is not None or found[-1][1] == across):
                found[-1][2].append(edge)
            else:
                found.append((chain, across, [edge]))
        first, last = found[0], found[-1]
        if len(found) > 1 and first[:2] == last[:2]:
            found = [(*last[:2], last[2] + first[2]), *found[1:-1]]
        return found

    def follow(self, of: tuple[int, Sequence[int]], to: tuple[int, Sequence[int]]) -> None:
        """Take two chains for answers of each other, and the faces across them."""
        chain = 1 + max(self.chains.values())
        self.chains |= dict.fromkeys((*of[1], *to[1]), chain)
        self.meet(_across(self.solid, of[1], of[0]), _across(self.solid, to[1], to[0]))

    def nearest(self, loop: Loop, others: Sequence[Loop]) -> Loop:
        """The loop on the other cap that answers one on this."""
        middle = self.carried(loop.directed).points.mean(axis=0)
        away = [np.linalg.norm(_Outline(self.solid, one.directed).points.mean(axis=0) - middle) for one in others]
        return _first(others[j] for j in np.argsort(away)[:1])

    def begin(self, of: tuple[int, Loop], to: tuple[int, Loop]) -> None:
        """Take two loops for answers of each other of which nothing is known: whole, or from the nearest chains on."""
        (f, loop), (g, other) = of, to
        one, two = self.in_chains(loop.directed, f), self.in_chains(_backwards(other.directed), g)
        if len(one) == len(two) == 1:
            outline, far = self.carried(one[0][2]), _Outline(self.solid, two[0][2])
            divisions = _alike(outline, far) if outline.is_near(far, self.most) else None
            if divisions is None:
                raise _UnlikeError
            self.divisions |= divisions
            self.follow((f, loop.edges), (g, other.edges))
            return
        first = one[0][2]
        middle = self.carried(first).points.mean(axis=0)
        far_first = min(
            (edges for _, _, edges in two),
            key=lambda edges: float(np.linalg.norm(_Outline(self.solid, edges).points.mean(axis=0) - middle)),
        )
        self.divisions |= _by_lengths(self.solid, first, far_first)
        self.follow((f, [e for e, _ in first]), (g, [e for e, _ in far_first]))
        self.compare(of, to)

    def carried(self, edges: Sequence[DirectedEdge]) -> _Outline:
        """Edges of the source cap as they are on the target cap, by what is known of both."""
        found = _Outline(self.solid, edges)
        found.points = (found.points - self.center) @ self.fit + self.far_center
        return found


_One = TypeVar("_One")


def _first(among: Iterable[_One]) -> _One:
    for one in among:
        return one
    raise _UnlikeError


def _backwards(edges: Sequence[DirectedEdge]) -> list[DirectedEdge]:
    return [(e, not forward) for e, forward in edges[::-1]]


def _across(solid: Solid, edges: Sequence[int], face: int) -> int:
    """The one face on the other side of edges of a face."""
    found = {other for e in edges for other in solid.edges[e].faces} - {face}
    if len(found) != 1:
        raise _UnlikeError
    return found.pop()


def _by_lengths(solid: Solid, edges: Sequence[DirectedEdge], others: Sequence[DirectedEdge]) -> Divisions:
    """Where two open chains of edges are divided, by their lengths, so that each vertex has one to answer it."""
    if len(edges) == len(others):
        return {}
    places = []
    for chain in (edges, others):
        along = np.cumsum([0.0, *(solid.edges[e].length for e, _ in chain)])
        places.append(along / along[-1])
    divisions: Divisions = {}
    for chain, own, far in ((edges, *places), (others, *places[::-1])):
        for place in far[1:-1]:
            if np.min(np.abs(own - place)) > _EDGE:
                j = int(np.searchsorted(own, place)) - 1
                fraction = float((place - own[j]) / (own[j + 1] - own[j]))
                edge, forward = chain[j]
                divisions.setdefault(edge, []).append(fraction if forward else 1.0 - fraction)
    return divisions


class _Outline:
    """A closed chain of edges as points, `_SAMPLES` - 1 to each edge.

    Attributes
    ----------
    points : (n, 3) float64
    """

    def __init__(self, solid: Solid, edges: Sequence[DirectedEdge]) -> None:
        self.edges = list(edges)
        at = np.linspace(0.0, 1.0, _SAMPLES)[:-1]
        self.points = np.concatenate(
            [solid.edges[e].curve.evaluate(at if forward else 1.0 - at) for e, forward in self.edges]
        )

    @property
    def vertices(self) -> FloatArray:
        """Where each edge begins (n_edges, 3)."""
        return self.points[:: _SAMPLES - 1]

    @property
    def lengths(self) -> FloatArray:
        """Of the edges (n_edges,)."""
        steps = np.linalg.norm(np.roll(self.points, -1, axis=0) - self.points, axis=1)
        return np.asarray(steps.reshape(len(self.edges), -1).sum(axis=1))

    def is_near(self, other: _Outline, most: float) -> bool:
        """Whether no vertex or middle of an edge is farther from the other outline, nor than that is wide."""
        half = (_SAMPLES - 1) // 2
        away = [*self.nearest(other.points[::half])[1], *other.nearest(self.points[::half])[1]]
        wide = float(np.linalg.norm(np.ptp(self.points, axis=0)))
        return max(away) <= min(most, _NEAR * wide)

    def nearest(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Places (m,) on the outline nearest to points (m, 3), edge by edge from 0 on, and their distances (m,)."""
        start, step = self.points, np.roll(self.points, -1, axis=0) - self.points
        share = np.einsum("mnd,nd->mn", points[:, None] - start, step) / np.einsum("nd,nd->n", step, step)
        share = np.clip(share, 0.0, 1.0)
        away = np.linalg.norm(points[:, None] - (start + share[..., None] * step), axis=2)
        at = np.argmin(away, axis=1)
        rows = np.arange(len(points))
        return (at + share[rows, at]) / (_SAMPLES - 1) % len(self.edges), away[rows, at]

    def divided(self, places: list[float]) -> Iterator[tuple[int, float]]:
        """The edges that places are on, and the fractions of their lengths."""
        for place in places:
            edge, forward = self.edges[int(place)]
            yield edge, place % 1.0 if forward else 1.0 - place % 1.0


def _alike(one: _Outline, other: _Outline) -> Divisions | None:
    """Where two outlines are divided so that each vertex has one to answer it; None where their order is another."""
    on_other = other.nearest(one.vertices)[0]
    n, m = len(one.edges), len(other.edges)
    lengths, far_lengths = one.lengths, other.lengths
    answered: dict[int, int] = {}
    for i in range(n):
        near = int(np.rint(on_other[i])) % m
        apart = np.linalg.norm(one.vertices[i] - other.vertices[near])
        along = [lengths[i - 1], lengths[i], far_lengths[near - 1], far_lengths[near]]
        if apart <= _SNAP * min(along) and near not in answered.values():
            answered[i] = near
            on_other[i] = near
    on_one = one.nearest(other.vertices)[0]
    for i, j in answered.items():
        on_one[j] = i
    on_other = _apart(on_other, lengths / far_lengths.mean(), sorted(answered), m)
    on_one = _apart(on_one, far_lengths / lengths.mean(), sorted(answered.values()), n)
    if not (_in_order(on_other, m) and _in_order(on_one, n)):
        return None
    divisions: Divisions = {}
    new = [float(on_other[i]) for i in range(n) if i not in answered]
    far_new = [float(on_one[j]) for j in range(m) if j not in answered.values()]
    for outline, places in ((other, new), (one, far_new)):
        for edge, fraction in outline.divided(places):
            divisions.setdefault(edge, []).append(fraction)
    return divisions


def _apart(places: FloatArray, gaps: FloatArray, kept: Sequence[int], around: int) -> FloatArray:
    """The nearest places that follow one another at these gaps or more, unless these are wider than what is there.

    Two ends of an edge that goes straight from one outline to the other have one place there.
    """
    first = kept[0] if kept else int(np.argmax((places - np.roll(places, 1) + _EDGE) % around))
    order = np.roll(np.arange(len(places)), -first)
    turned = places[first] + (places[order] - places[first] + _EDGE) % around - _EDGE
    before = np.concatenate([[0.0], np.cumsum(np.minimum(gaps[order], _LEAST_GAP)[:-1])])
    weights = np.where(np.isin(order, kept), _FIXED, 1.0)
    found = np.empty_like(places)
    found[order] = scipy.optimize.isotonic_regression(turned - before, weights=weights).x + before
    return np.asarray(found % around)


def _in_order(places: FloatArray, around: int) -> bool:
    """Whether places on a closed chain of so many edges follow one another once around."""
    steps = np.diff([*places, places[0]]) % around
    return bool((steps > 1e-6).all()) and abs(steps.sum() - around) < 1e-6


__all__ = ["ALIKE", "Divisions", "find_divisions"]
