"""Bands: the ring-shaped strips of linking sides that one class of rails defines.

Place in the flow: second step of :mod:`cadsweep.recognition`. In a logical rectangle opposite
sides run the same way, so an edge along the sweep makes every edge it faces, across a linking
side, an edge along the sweep too. Edges tied in this manner form a class; the faces that a class
crosses are all linking sides and close to a band. So every class is a candidate, all classes
together have as many edges as the solid, and nothing is searched: the cost grows with the number
of faces. A class is rejected where it meets a face that is no rectangle, or crosses itself.

Where some faces have several readings, the classes that meet them are settled together by one
small integer programme: a state for every such face (no linking side, or one reading in one of
two directions), edges agreeing on both their faces, least total deviation of the angles.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from ..topology import Solid
from .corners import Reading, read_rectangles, why_no_rectangle

STEP_COST = 1e-3
"""Price of one more class in a band, so that of two equal solutions the smaller one is taken."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Band:
    """Linking sides that close to a ring.

    Attributes
    ----------
    faces : dict of int to (Reading, int)
        For every face its reading, and which of its chains are rails: 0 if chains 0 and 2 are,
        1 if chains 1 and 3 are.
    rails : frozenset of int
        Edge ids along the sweep.
    cost : float
        Worst deviation of a face from a rectangle, in right angles.
    """

    faces: dict[int, tuple[Reading, int]]
    rails: frozenset[int]
    cost: float


@dataclass(frozen=True, kw_only=True, eq=False)
class BandSearch:
    """All bands of a solid, and why the other directions are none.

    Attributes
    ----------
    bands : list of Band
    reasons : dict of int to str
        For every edge that cannot be along a sweep, the reason.
    readings : list of tuple of Reading
        For every face.
    """

    bands: list[Band]
    reasons: dict[int, str]
    readings: list[tuple[Reading, ...]] = field(default_factory=list)


class _EdgeSets:
    """Disjoint sets of edges."""

    def __init__(self, n: int) -> None:
        self.parent = list(range(n))

    def find(self, i: int) -> int:
        while self.parent[i] != i:
            self.parent[i] = self.parent[self.parent[i]]
            i = self.parent[i]
        return i

    def join(self, edges: tuple[int, ...]) -> None:
        first = self.find(edges[0])
        for e in edges[1:]:
            self.parent[self.find(e)] = first


def find_bands(solid: Solid, *, folded: bool = False) -> BandSearch:
    """Find the bands of a solid.

    Parameters
    ----------
    solid : Solid
    folded : bool
        Read faces with sharp folds as rectangles too (:func:`.corners.read_rectangles`).
    """
    readings = [read_rectangles(face, folded=folded) for face in solid.faces]
    classes = _EdgeSets(len(solid.edges))
    for options in readings:
        if len(options) == 1:
            a, b, c, d = options[0].chains
            classes.join(a + c)
            classes.join(b + d)
    of_edge = [classes.find(e) for e in range(len(solid.edges))]

    bad: dict[int, str] = {}
    faces_of: dict[int, list[tuple[int, int]]] = {}
    unclear_of: dict[int, list[int]] = {}
    for face, options in zip(solid.faces, readings, strict=True):
        if not options:
            why = f"{face.label()} {why_no_rectangle(face)}"
            for e in face.edges:
                bad.setdefault(of_edge[e], why)
        elif len(options) == 1:
            ways = [of_edge[options[0].chains[way][0]] for way in (0, 1)]
            if ways[0] == ways[1]:
                bad.setdefault(ways[0], f"the rails would run both along and across {face.label()}")
            for way in (0, 1):
                faces_of.setdefault(ways[way], []).append((face.id, way))
        else:
            for c in {of_edge[e] for e in face.edges}:
                unclear_of.setdefault(c, []).append(face.id)

    bands: list[Band] = []
    taken: set[int] = set()
    for c in dict.fromkeys(of_edge):
        if c in bad or c in taken:
            continue
        if c not in unclear_of:
            bands.append(_make_band(faces_of[c], {}, readings))
            continue
        settled = _settle(c, readings, of_edge, bad, faces_of, unclear_of)
        if settled is None:
            face = solid.faces[unclear_of[c][0]]
            bad[c] = f"no four corners of {face.label()} agree with its neighbours"
            continue
        chosen, states = settled
        taken |= chosen
        bands.append(_make_band([fw for k in sorted(chosen) for fw in faces_of.get(k, [])], states, readings))
    reasons = {e: bad[c] for e, c in enumerate(of_edge) if c in bad}
    return BandSearch(bands=bands, reasons=reasons, readings=readings)


def _make_band(
    clear: list[tuple[int, int]], states: dict[int, tuple[Reading, int]], readings: list[tuple[Reading, ...]]
) -> Band:
    faces = {f: (readings[f][0], way) for f, way in clear} | states
    rails = frozenset(e for reading, way in faces.values() for k in (way, way + 2) for e in reading.chains[k])
    return Band(faces=faces, rails=rails, cost=max(reading.cost for reading, _ in faces.values()))


def _settle(
    seed: int,
    readings: list[tuple[Reading, ...]],
    of_edge: list[int],
    bad: dict[int, str],
    faces_of: dict[int, list[tuple[int, int]]],
    unclear_of: dict[int, list[int]],
) -> tuple[set[int], dict[int, tuple[Reading, int]]] | None:
    """Choose the states of all faces with several readings, given that class `seed` is along the sweep.

    Returns the classes along the sweep and the chosen state of every such linking side, or None.
    """
    reach, faces = [seed], []
    seen_classes, seen_faces = {seed}, set()
    for c in reach:
        for f in unclear_of.get(c, []):
            if f in seen_faces:
                continue
            seen_faces.add(f)
            faces.append(f)
            for e in {e for chain in readings[f][0].chains for e in chain}:
                k = of_edge[e]
                if k not in seen_classes and k not in bad:
                    seen_classes.add(k)
                    reach.append(k)
    column = {c: j for j, c in enumerate(reach)}
    cost = [STEP_COST] * len(reach)

    states: list[tuple[int, Reading | None, int]] = []
    rows: list[dict[int, float]] = []
    lower: list[float] = []
    for f in faces:
        on_face = {of_edge[e] for chain in readings[f][0].chains for e in chain}
        row_of = {c: {column[c]: -1.0} for c in on_face if c in column}
        one: dict[int, float] = {}
        options = [(reading, way) for reading in readings[f] for way in (0, 1)]
        for reading, way in [(None, 0), *options]:
            along = set() if reading is None else _crossed(reading, way, of_edge)
            if reading is not None and (not along <= column.keys() or along & _crossed(reading, 1 - way, of_edge)):
                continue
            j = len(cost)
            cost.append(0.0 if reading is None else reading.cost)
            states.append((f, reading, way))
            one[j] = 1.0
            for c in along:
                row_of[c][j] = 1.0
        rows.append(one)
        lower.append(1.0)
        rows.extend(row_of.values())
        lower.extend([0.0] * len(row_of))
    n_equal = len(rows)
    ways_of: dict[int, list[int]] = {}
    for c in reach:
        for f, _ in faces_of.get(c, []):
            ways_of.setdefault(f, []).append(column[c])
    rows.extend(dict.fromkeys(pair, 1.0) for pair in {tuple(p) for p in ways_of.values() if len(p) == 2})
    upper = [*lower[:n_equal], *[1.0] * (len(rows) - n_equal)]
    lower.extend([0.0] * (len(rows) - n_equal))

    low = np.zeros(len(cost))
    low[column[seed]] = 1.0
    entries = [(i, j, v) for i, row in enumerate(rows) for j, v in row.items()]
    i, j, v = (np.array(x) for x in zip(*entries, strict=True))
    A = csr_array((v, (i, j)), shape=(len(rows), len(cost)))
    result = milp(
        np.array(cost),
        integrality=np.ones(len(cost)),
        bounds=Bounds(low, np.ones(len(cost))),
        constraints=LinearConstraint(A, np.array(lower), np.array(upper)),
    )
    if result.x is None:
        return None
    on = result.x > 0.5
    chosen = {c for c in reach if on[column[c]]}
    picked = {
        f: (reading, way) for k, (f, reading, way) in enumerate(states) if reading is not None and on[len(reach) + k]
    }
    return chosen, picked


def _crossed(reading: Reading, way: int, of_edge: list[int]) -> set[int]:
    """Classes of the two opposite chains `way` of a reading."""
    return {of_edge[e] for k in (way, way + 2) for e in reading.chains[k]}
