"""The two ends of a band, and bands that are given up because they cover only a part of another one's end.

Place in the flow: :mod:`.layout` asks it for what a band is by itself, which does not depend on the bands beside it,
and for the bands of a set that can follow each other. A solid of hundreds of faces has hundreds of sets that differ in
a few bands, so what belongs to one band is kept with it, and giving one up looks at its neighbours alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush
from typing import NamedTuple
from weakref import WeakKeyDictionary

from ..brep import Solid
from ..disjoint import DisjointSets
from .bands import Band


class Ends(NamedTuple):
    """What a band is by itself.

    Attributes
    ----------
    bottoms : dict of int to int
        For every face, which chain of its reading is the bottom: all alike.
    beyond : two tuples of (int, int)
        At the bottom and at the top: edges, and the faces across them.
    reason : str
        Why its faces make no ring of sides; empty where they do.
    """

    bottoms: dict[int, int]
    beyond: tuple[tuple[tuple[int, int], ...], tuple[tuple[int, int], ...]]
    reason: str


_ends: WeakKeyDictionary[Band, Ends] = WeakKeyDictionary()


def ends_of(solid: Solid, band: Band) -> Ends:
    """The two ends of a band of a solid."""
    if band not in _ends:
        bottoms, reason = _orient(solid, band)
        sides: tuple[list[tuple[int, int]], list[tuple[int, int]]] = ([], [])
        for f, (reading, _) in band.faces.items():
            for side in (0, 1):
                for e in reading.chains[(bottoms[f] + 2 * side) % 4]:
                    g = across(solid, e, f)
                    if g not in band.faces:
                        sides[side].append((e, g))
        _ends[band] = Ends(bottoms, (tuple(sides[0]), tuple(sides[1])), reason)
    return _ends[band]


def across(solid: Solid, edge: int, face: int) -> int:
    """The other face at an edge."""
    a, b = solid.edges[edge].faces
    return b if a == face else a


def without_partial_ends(solid: Solid, bands: Sequence[Band]) -> list[Band]:
    """Give up bands that cover only a part of another band's end: they cannot follow it.

    The first end, in the order of the bands, that several bands or groups of faces meet gives up all bands
    at it but the first of all; then the next one, where the faces of those are caps.

    Parameters
    ----------
    solid : Solid
    bands : sequence of Band
        The first stays.

    Returns
    -------
    list of Band
    """
    owner = {f: i for i, band in enumerate(bands) for f in band.faces}
    groups = _Groups(solid, owner)
    ends = [ends_of(solid, band) for band in bands]
    waiting = [(i, side) for i in range(len(bands)) for side in (0, 1)]
    heapify(waiting)
    dropped: set[int] = set()
    while waiting:
        i, side = heappop(waiting)
        if i in dropped:
            continue
        partners = set()
        for e, g in ends[i].beyond[side]:
            j = owner.get(g, -1)
            if j < 0:
                partners.add((-1, groups.find(g)))
            else:
                chains = bands[j].faces[g][0].chains
                partners.add((j, int(e not in chains[ends[j].bottoms[g]])))
        if len(partners) < 2:
            continue
        for j in {j for j, _ in partners if j > 0}:
            dropped.add(j)
            for f in bands[j].faces:
                del owner[f]
            for f in bands[j].faces:
                groups.open(f)
            # Whoever met this band meets a cap now; what was settled elsewhere can only meet fewer groups than before.
            for beyond in ends[j].beyond:
                for _, g in beyond:
                    if g in owner:
                        heappush(waiting, (owner[g], 0))
                        heappush(waiting, (owner[g], 1))
    return [band for i, band in enumerate(bands) if i not in dropped]


class _Groups:
    """Faces outside all bands, in groups that hang together."""

    def __init__(self, solid: Solid, owner: dict[int, int]) -> None:
        self.solid = solid
        self.owner = owner
        self.sets = DisjointSets(range(len(solid.faces)))
        for f in range(len(solid.faces)):
            if f not in owner:
                self.open(f)

    def open(self, face: int) -> None:
        """Join a face outside all bands with those beside it."""
        for e in self.solid.faces[face].edges:
            g = across(self.solid, e, face)
            if g not in self.owner:
                self.sets.merge(g, face)

    def find(self, face: int) -> int:
        """The face that stands for the group."""
        return self.sets.find(face)


def _orient(solid: Solid, band: Band) -> tuple[dict[int, int], str]:
    """Choose for every face of a band which of its chains is the bottom, all alike; and why that cannot be."""
    reason = ""
    chain_of = {
        (f, e): k for f, (reading, _) in band.faces.items() for k, chain in enumerate(reading.chains) for e in chain
    }
    first, (_, way) = next(iter(band.faces.items()))
    bottom = {first: (way + 1) % 4}
    stack = [first]
    while stack:
        f = stack.pop()
        for k in range(4):
            for e in band.faces[f][0].chains[k]:
                g = across(solid, e, f)
                if g not in band.faces:
                    continue
                # the chain that is the bottom, right, top, left of f is the top, left, bottom, right of g
                b = (chain_of[g, e] + 2 - (k - bottom[f])) % 4
                if g not in bottom:
                    bottom[g] = b
                    stack.append(g)
                elif bottom[g] != b:
                    reason = reason or f"the sides do not turn the same way at {solid.faces[g].label()}"
    apart = band.faces.keys() - bottom.keys()
    if apart:
        reason = reason or f"the sides do not hang together at {solid.faces[min(apart)].label()}"
        bottom |= {f: (band.faces[f][1] + 1) % 4 for f in apart}
    return bottom, reason
