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
import numpy.typing as npt
import scipy

from ..arrays import FloatArray
from ..brep import Solid
from .corners import Reading, read_rectangles, why_no_rectangle

STEP_COST = 1e-3
"""Price of one more class in a band: nothing joins a band that is not needed there."""
TIE = 0.5
"""Right angles by which another choice of corners may be worse than the best and is still tried."""
MAX_SOLUTIONS = 4
"""Ways to read the sides of one band that are kept, the cheapest first; each costs an integer programme."""


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


def find_bands(solid: Solid, *, folded: bool = False, most_readings: int | None = None) -> BandSearch:
    """Find the bands of a solid.

    Parameters
    ----------
    solid : Solid
    folded : bool
        Read faces with sharp folds as rectangles too (:func:`.corners.read_rectangles`).
    most_readings : int, optional
        Keep only so many readings of each face, the best.
    """
    net = _tie_edges(solid, [read_rectangles(face, folded=folded)[:most_readings] for face in solid.faces])
    bands: list[Band] = []
    seen: set[frozenset[int]] = set()
    for c in dict.fromkeys(net.of_edge):
        if c in net.bad:
            continue
        if c not in net.unclear:
            bands.append(_make_band(net.clear[c], {}, net.readings))
            continue
        settled = _settle(net, c)
        if not settled:
            face = solid.faces[net.unclear[c][0]]
            net.bad[c] = f"no four corners of {face.label()} agree with its neighbours"
        for chosen, states in settled:
            if chosen not in seen:
                seen.add(chosen)
                clear = [crossing for k in sorted(chosen) for crossing in net.clear.get(k, [])]
                bands.append(_make_band(clear, states, net.readings))
    reasons = {e: net.bad[c] for e, c in enumerate(net.of_edge) if c in net.bad}
    return BandSearch(bands=bands, reasons=reasons, readings=net.readings)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Net:
    """Classes of edges, and the faces they cross.

    Attributes
    ----------
    of_edge : list of int
        Class of every edge.
    bad : dict of int to str
        Classes that cannot be along a sweep.
    clear : dict of int to list of (int, int)
        Faces of one reading that a class crosses, and which of their chains it holds.
    unclear : dict of int to list of int
        Faces of several readings that a class meets.
    """

    readings: list[tuple[Reading, ...]]
    of_edge: list[int]
    bad: dict[int, str] = field(default_factory=dict)
    clear: dict[int, list[tuple[int, int]]] = field(default_factory=dict)
    unclear: dict[int, list[int]] = field(default_factory=dict)


def _tie_edges(solid: Solid, readings: list[tuple[Reading, ...]]) -> _Net:
    """Join edges that faces of one reading set opposite to each other."""
    sets = _EdgeSets(len(solid.edges))
    for options in readings:
        if len(options) == 1:
            a, b, c, d = options[0].chains
            sets.join(a + c)
            sets.join(b + d)
    net = _Net(readings=readings, of_edge=[sets.find(e) for e in range(len(solid.edges))])
    for face, options in zip(solid.faces, readings, strict=True):
        if not options:
            why = f"{face.label()} {why_no_rectangle(face)}"
            for e in face.edges:
                net.bad.setdefault(net.of_edge[e], why)
        elif len(options) == 1:
            ways = [net.of_edge[options[0].chains[way][0]] for way in (0, 1)]
            if ways[0] == ways[1]:
                net.bad.setdefault(ways[0], f"the rails would run both along and across {face.label()}")
            for way in (0, 1):
                net.clear.setdefault(ways[way], []).append((face.id, way))
        else:
            for k in {net.of_edge[e] for e in face.edges}:
                net.unclear.setdefault(k, []).append(face.id)
    return net


def _make_band(
    clear: list[tuple[int, int]], states: dict[int, tuple[Reading, int]], readings: list[tuple[Reading, ...]]
) -> Band:
    faces = {f: (readings[f][0], way) for f, way in clear} | states
    rails = frozenset(e for reading, way in faces.values() for k in (way, way + 2) for e in reading.chains[k])
    return Band(faces=faces, rails=rails, cost=max(reading.cost for reading, _ in faces.values()))


def _reach(net: _Net, seed: int) -> tuple[list[int], list[int]]:
    """Classes and faces of several readings that hang together with a class."""
    classes: dict[int, None] = {seed: None}
    faces: dict[int, None] = {}
    stack = [seed]
    while stack:
        for f in net.unclear.get(stack.pop(), []):
            if f in faces:
                continue
            faces[f] = None
            for chain in net.readings[f][0].chains:
                for k in {net.of_edge[e] for e in chain} - classes.keys() - net.bad.keys():
                    classes[k] = None
                    stack.append(k)
    return list(classes), list(faces)


def _settle(net: _Net, seed: int) -> list[tuple[frozenset[int], dict[int, tuple[Reading, int]]]]:
    """Choose the states of all faces with several readings, given that class `seed` is along the sweep.

    Returns, cheapest first, the classes along the sweep and the chosen state of every such linking
    side; more than one where others are about as good, so that no order of the faces decides.
    """
    classes, faces = _reach(net, seed)
    column = {k: j for j, k in enumerate(classes)}
    cost = [STEP_COST] * len(classes)
    states: list[tuple[int, tuple[Reading, int] | None]] = []
    rows: list[dict[int, float]] = []
    right: list[float] = []
    for f in faces:
        on_face = {net.of_edge[e] for chain in net.readings[f][0].chains for e in chain}
        agree = {k: {column[k]: -1.0} for k in on_face if k in column}
        one: dict[int, float] = {}
        options: list[tuple[Reading, int] | None] = [None]
        options += [(reading, way) for reading in net.readings[f] for way in (0, 1)]
        for state in options:
            along = set() if state is None else _crossed(state[0], state[1], net.of_edge)
            if state is not None and (
                not along <= column.keys() or along & _crossed(state[0], 1 - state[1], net.of_edge)
            ):
                continue
            one[len(cost)] = 1.0
            for k in along:
                agree[k][len(cost)] = 1.0
            cost.append(0.0 if state is None else state[0].cost)
            states.append((f, state))
        rows += [one, *agree.values()]
        right += [1.0] + [0.0] * len(agree)
    both_ways: dict[int, list[int]] = {}
    for k in classes:
        for f, _ in net.clear.get(k, []):
            both_ways.setdefault(f, []).append(column[k])
    pairs = {tuple(p) for p in both_ways.values() if len(p) == 2}
    n_equal = len(rows)
    rows += [dict.fromkeys(pair, 1.0) for pair in pairs]

    bound = np.array(right + [1.0] * len(pairs))
    low = np.zeros(len(cost))
    low[column[seed]] = 1.0
    solutions: list[tuple[frozenset[int], dict[int, tuple[Reading, int]]]] = []
    best = np.inf
    while len(solutions) < MAX_SOLUTIONS:
        on = _solve(np.array(cost), low, rows, bound, n_equal)
        if on is None or np.array(cost) @ on > best + TIE:
            break
        best = min(best, float(np.array(cost) @ on))
        picked = {f: state for j, (f, state) in enumerate(states) if state is not None and on[len(classes) + j]}
        solutions.append((frozenset(k for k in classes if on[column[k]]), picked))
        taken = {
            len(classes) + j: 1.0 for j, (_, state) in enumerate(states) if state is not None and on[len(classes) + j]
        }
        if not taken:
            break
        # next time one of these faces must be read otherwise
        rows = [*rows, taken]
        bound = np.append(bound, len(taken) - 1.0)
    return solutions


def _solve(
    cost: FloatArray, low: FloatArray, rows: list[dict[int, float]], bound: FloatArray, n_equal: int
) -> npt.NDArray[np.bool_] | None:
    """Least cost of binary unknowns: the first `n_equal` rows equal their bound, others stay below."""
    entries = [(r, c, v) for r, row in enumerate(rows) for c, v in row.items()]
    r, c, v = (np.array(x) for x in zip(*entries, strict=True))
    result = scipy.optimize.milp(
        cost,
        integrality=np.ones(len(cost)),
        bounds=scipy.optimize.Bounds(low, np.ones(len(cost))),
        constraints=scipy.optimize.LinearConstraint(
            scipy.sparse.csr_array((v, (r, c)), shape=(len(rows), len(cost))),
            np.where(np.arange(len(rows)) < n_equal, bound, -np.inf),
            bound,
        ),
    )
    return None if result.x is None else result.x > 0.5


def _crossed(reading: Reading, way: int, of_edge: list[int]) -> set[int]:
    """Classes of the two opposite chains `way` of a reading."""
    return {of_edge[e] for k in (way, way + 2) for e in reading.chains[k]}
