"""Planes that part a cell into boxes, the features of each of which go one way.

Place in the flow: candidates of :mod:`.cutters`. A hole, a slot, a rounding can be swept along, or across as a cap, in
few directions; a cell whose features ask for different ones is parted first, and the rims of what is left are carried
on in the direction of each box.

Method: planes square to the faces of the cell lie half way between the ends of features (:mod:`.axial`), or on a plane
face where one ends in another; they may go through what is swept square to them. A search over the planes, deeper and
deeper within a budget, takes those that leave the fewest boxes, and the fewest that are swept towards a cut.

Two bores that cross get a box of their own, which :mod:`.crossings` parts.

Not handled: planes that are slanted to each other, and other features that cross; what is left of these stays in one
box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt

from ...arrays import BoolArray, FloatArray
from ...brep import Edge, Face, Solid
from ..shapes import shapes_of
from .axes import is_hollow
from .axial import (
    ALONG,
    EVERY,
    Box,
    Cluster,
    direction_of,
    find_clusters,
    is_across,
    main_normals,
    make_box,
    round_axis,
    sliced,
)
from .central import Cutter

GAP = 0.01
"""Distance of two ends of features, as a share of the cell's size, from which a plane fits between them."""
MOST_PLANES = 6
"""Planes of one box that are tried."""
MOST_BOXES = 2000
"""Boxes that are looked at, some 50 microseconds each."""
DEEPEST = 6
"""Planes of which one divides what the one before left, at most."""
BOX, STUCK, TOWARDS = 1.0, 6.0, 0.6
"""Costs of a box, of one whose features ask for different directions, and of a cut that its sweep ends on."""
NARROW, WIDE = 0.4, 0.2
"""Cost of a plane in no gap at all, and the gap, as a share of the cell's size, from which on a plane costs none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Cut:
    """A plane square to a normal, through a box."""

    axis: int
    offset: float
    box: Box
    price: float


@dataclass(kw_only=True, eq=False)
class _InBox:
    """What is in a box.

    Attributes
    ----------
    inside : sequence of Cluster
        Features that reach into it.
    ways : frozenset of int
        Directions that suit all of them.
    is_crossing : bool
        Whether they are two bores that cross once, and nothing else.
    planes : list of (axis, offset, price), or None
        What parts it, the most promising first; None until it is asked for.
    """

    inside: Sequence[Cluster]
    ways: frozenset[int]
    is_crossing: bool
    planes: list[tuple[int, float, float]] | None = None


@dataclass(kw_only=True, eq=False)
class _Guillotine:
    """The search for planes.

    Attributes
    ----------
    features : sequence of Cluster
    walls : sequence of sequence of float
        For every normal the offsets of the cell's faces across it.
    least : float
        Gap into which a plane fits.
    known : dict
        Cheapest cuts by box, its sides that are cuts, and depth.
    read : dict of Box to _InBox
    reaching : dict of (axis, low, high) to int
        Features in a slab, as bits.
    """

    features: Sequence[Cluster]
    walls: Sequence[Sequence[float]]
    least: float
    n_looked: int = 0
    known: dict[tuple[Box, tuple[bool, ...], int], tuple[float, tuple[_Cut, ...]]] = field(default_factory=dict)
    read: dict[Box, _InBox] = field(default_factory=dict)
    reaching: dict[tuple[int, float, float], int] = field(default_factory=dict)

    @property
    def tight(self) -> float:
        """Distance up to which ends of features are one."""
        return 1e-3 * self.least

    def look(self, box: Box) -> _InBox:
        """What is in a box; deeper searches come to the same boxes again."""
        found = self.read.get(box)
        if found is None:
            bits = self.reach(0, box[0]) & self.reach(1, box[1]) & self.reach(2, box[2])
            inside = [feature for j, feature in enumerate(self.features) if bits >> j & 1]
            found = self.read[box] = _InBox(
                inside=inside, ways=EVERY.intersection(*(f.ways for f in inside)), is_crossing=_is_one_crossing(inside)
            )
        return found

    def reach(self, axis: int, ends: tuple[float, float]) -> int:
        """The features that reach into a slab, as bits: boxes share their slabs."""
        low, high = ends
        found = self.reaching.get((axis, low, high))
        if found is None:
            tight, found = self.tight, 0
            for j, feature in enumerate(self.features):
                a, b = feature.spans[axis]
                # What is flat, as an edge is, must not lie on the side of the box.
                within = low + tight < a and b < high - tight
                found |= (within if b - a <= tight else min(b, high) - max(a, low) > tight) << j
            self.reaching[axis, low, high] = found
        return found

    def solve(self, box: Box) -> tuple[tuple[_Cut, ...], bool]:
        """The cheapest cuts of a cell, of the fewest planes after one another that leave no box stuck; all is well."""
        best: tuple[float, tuple[_Cut, ...]] = (np.inf, ())
        for depth in range(1, DEEPEST + 1):
            best = min(best, self.best(box, (False,) * 6, depth), key=lambda found: found[0])
            if self.n_looked >= MOST_BOXES or best[0] < STUCK:
                break
        cost, cuts = best
        return cuts, cost < BOX * (len(cuts) + 1) + sum(cut.price for cut in cuts) + 0.5 * TOWARDS

    def best(self, box: Box, ends: tuple[bool, ...], depth: int) -> tuple[float, tuple[_Cut, ...]]:
        """The cheapest cuts of a box (3, 2); `ends` says which of its sides, low ones first, are cuts."""
        key = box, ends, depth
        known = self.known.get(key)
        if known is not None:
            return known
        self.n_looked += 1
        here = self.look(box)
        if here.is_crossing:
            found: tuple[float, tuple[_Cut, ...]] = (BOX, ())
        elif here.ways:
            towards = min(ends[way] + ends[3 + way] for way in here.ways) if here.inside else 0
            found = (BOX + TOWARDS * towards, ())
        else:
            found = (BOX + STUCK + len(here.inside), ())
            if depth and here.planes is None:
                here.planes = self.planes(box, here.inside)
            for axis, offset, price in (here.planes or ()) if depth else ():
                if self.n_looked >= MOST_BOXES:
                    break
                (start, end), below, above = box[axis], list(box), list(box)
                below[axis], above[axis] = (start, offset), (offset, end)
                low, high = tuple(below), tuple(above)
                cost, cuts = self.best(low, (*ends[: 3 + axis], True, *ends[4 + axis :]), depth - 1)
                if cost + BOX + price >= found[0]:
                    continue
                other, more = self.best(high, (*ends[:axis], True, *ends[axis + 1 :]), depth - 1)
                if cost + other + price < found[0]:
                    found = (cost + other + price, (_Cut(axis=axis, offset=offset, box=box, price=price), *cuts, *more))
        self.known[key] = found
        return found

    def planes(self, box: Box, inside: Sequence[Cluster]) -> list[tuple[int, float, float]]:
        """Planes that part a box with their prices, those with the most unlike features on both sides first."""
        found: list[tuple[int, float, int, float]] = []
        bits = np.array([_bits(f.ways) for f in inside], dtype=np.int64)
        unlike = np.triu((bits[:, None] & bits) == 0, 1).astype(np.float64)
        for axis, (low, high) in enumerate(box):
            through = np.array([f.ways != {axis} for f in inside])
            starts, stops = np.clip([f.spans[axis] for f in inside], low, high).T
            ends = np.unique([low, high, *starts, *stops])
            widths = np.diff(ends)
            walls = np.array([wall for wall in self.walls[axis] if low + self.least < wall < high - self.least])
            at_end = (np.abs(walls[:, None] - np.concatenate([starts, stops])) < self.tight).any(axis=1)
            is_gap = widths > self.least
            places = np.concatenate([(0.5 * (ends[:-1] + ends[1:]))[is_gap], walls[at_end]])
            gaps = np.concatenate([widths[is_gap], np.zeros(int(at_end.sum()))])
            below = starts < places[:, None] - self.tight
            above = stops > places[:, None] + self.tight
            # Unlike features on one side, of which those on both sides are counted twice.
            together = _within(below, unlike) + _within(above, unlike) - _within(below & above, unlike)
            parted = (unlike.sum() - together).astype(np.int64)
            is_cut = (parted > 0) | (below != above).any(axis=1)
            for j in np.flatnonzero(is_cut & ~(below & above & through).any(axis=1)).tolist():
                found.append((-int(parted[j]), -float(gaps[j]), axis, float(places[j])))
        wide = WIDE * self.least / GAP
        return [
            (axis, place, NARROW * max(0.0, 1.0 + gap / wide)) for _, gap, axis, place in sorted(found)[:MOST_PLANES]
        ]


@cache
def _bits(ways: frozenset[int]) -> int:
    return sum(1 << way for way in ways)


def _within(sides: BoolArray, pairs: FloatArray) -> FloatArray:
    """How many of the pairs (n, n) lie in each set (m, n)."""
    chosen = sides.astype(np.float64)
    return np.asarray(np.einsum("ij,ij->i", chosen @ pairs, chosen))


def _is_one_crossing(inside: Sequence[Cluster]) -> bool:
    """Whether the features of a box are two bores that cross once, and nothing else."""
    own = [feature.axes for feature in inside if feature.is_crossing]
    return len(own) == 1 and all(feature.axes and feature.axes <= own[0] for feature in inside)


def into_boxes(solid: Solid, flat: float) -> tuple[list[Cutter], bool]:
    """Planes that part features which ask for different directions; none where one direction suits all.

    Parameters
    ----------
    solid : Solid
    flat : float
        Radians from pi up to which two faces at an edge are one surface.

    Returns
    -------
    cutters : list of Cutter
    is_well : bool
        Whether no box is swept towards a cut, and all can be swept.
    """
    axes = [direction_of(solid, face) for face in solid.faces]
    normals = main_normals(solid, axes)
    if len(normals) < 3:
        return [], False
    whole = find_clusters(solid, axes, normals, flat)
    features = [piece for cluster in whole for piece in sliced(solid, normals, axes, cluster)]
    if EVERY.intersection(*(f.ways for f in features)):
        return [], False
    walls = [_walls(solid, normal, flat) for normal in normals]
    search = _Guillotine(features=features, walls=walls, least=GAP * solid.size)
    reach, margin = solid.vertices @ normals.T, 0.1 * solid.size
    box = make_box(reach.min(axis=0) - margin, reach.max(axis=0) + margin)
    cuts, is_well = search.solve(box)
    if not cuts:
        return [], False
    many = f"{len(cuts)} planes" if len(cuts) > 1 else "a plane"
    return [
        Cutter(
            reason=f"{many} between features that go different ways",
            tools=tuple(_rectangle(cut, normals) for cut in cuts),
            weight=solid.size,
            leads=True,
        )
    ], is_well


def _walls(solid: Solid, normal: FloatArray, flat: float) -> list[float]:
    """Offsets of planes across a normal on which the cell may be parted: of its faces, and at the ends of roundings.

    The plane of a face that runs into a rounding of an inner corner would leave a cusp beyond it.
    """
    kept: list[float] = []
    cusps: list[float] = []
    for face in solid.faces:
        if face.kind != "plane":
            continue
        ends = [edge for edge in map(solid.edges.__getitem__, face.edges) if _ends_smoothly(solid, face, edge, flat)]
        if is_across(face, normal):
            (cusps if ends else kept).append(float(face.center @ normal))
        else:
            across = (np.cross(edge.tangents[0], face.normal) for edge in ends)
            kept += [
                float(edge.midpoint @ normal)
                for edge, way in zip(ends, across, strict=True)
                if abs(float(way @ normal)) > 1.0 - ALONG
            ]
    near = GAP * GAP * solid.size
    return sorted({at for at in kept if all(abs(at - cusp) > near for cusp in cusps)})


def _ends_smoothly(solid: Solid, face: Face, edge: Edge, flat: float) -> bool:
    """Whether a plane face runs into the rounding of an inner corner at a straight edge."""
    if edge.kind != "line" or abs(edge.dihedral - pi) > flat:
        return False
    other = solid.faces[edge.faces[0] if edge.faces[1] == face.id else edge.faces[1]]
    axis = round_axis(shapes_of(solid).faces[other.id])
    return axis is not None and is_hollow(other, edge.midpoint, *axis)


def _rectangle(cut: _Cut, normals: FloatArray) -> Any:
    """A plane face that fills a box of the search."""
    i, j = (k for k in range(3) if k != cut.axis)
    frame = gp_Ax3(
        gp_Pnt(*map(float, cut.offset * normals[cut.axis])),
        gp_Dir(*map(float, np.cross(normals[i], normals[j]))),
        gp_Dir(*map(float, normals[i])),
    )
    return BRepBuilderAPI_MakeFace(gp_Pln(frame), *cut.box[i], *cut.box[j]).Face()


__all__ = ["into_boxes"]
