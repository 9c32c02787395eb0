"""Bands: the ring-shaped strips of linking sides that one class of rails defines.

Place in the flow: second step of :mod:`cadsweep.recognition`. In a logical rectangle opposite
sides run the same way, so an edge along the sweep makes every edge it faces, across a linking
side, an edge along the sweep too. Edges tied in this manner form a class; the faces that a class
crosses are all linking sides and close to a band. So every class is a candidate, all classes
together have as many edges as the solid, and nothing is searched: the cost grows with the number
of faces. A class is rejected where it meets a face that is no rectangle, or crosses itself.

Where some faces have several readings, the classes that meet them are settled together: a state for
every such face (no linking side, or one reading in one of two directions), edges agreeing on both
their faces, least total deviation of the angles. What one class along the sweep settles by itself
(:mod:`.narrowing`) is taken as it is, and of the rest the cheapest choices are followed (:mod:`.choices`).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ..brep import Solid
from ..disjoint import DisjointSets
from .choices import Tries, cheapest
from .corners import Reading, read_rectangles, why_no_rectangle
from .narrowing import Narrowed, State, narrow


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
    components: dict[int, Narrowed | None] = {}
    tries = Tries()
    for c in dict.fromkeys(net.of_edge):
        if c in net.bad:
            continue
        if c not in net.unclear:
            bands.append(_make_band(net.clear[c], {}, net.readings))
            continue
        if c not in components:
            # Classes that turn out bad later may stay in it: no choice has them along the sweep.
            classes, component = _component(net, c)
            components |= dict.fromkeys(classes, component)
        settled = _settle(components[c], c, tries)
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
    sets = DisjointSets(range(len(solid.edges)))
    for options in readings:
        if len(options) == 1:
            a, b, c, d = options[0].chains
            for tied in (a + c, b + d):
                for e in tied[1:]:
                    sets.merge(e, tied[0])
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


def _settle(
    component: Narrowed | None, seed: int, tries: Tries
) -> list[tuple[frozenset[int], dict[int, tuple[Reading, int]]]]:
    """Choose the states of all faces with several readings, given that class `seed` is along the sweep.

    Returns, cheapest first, the classes along the sweep and the chosen state of every such linking
    side; more than one where others are about as good, so that no order of the faces decides.
    """
    left = None if component is None else component.told([(seed, True)])
    if left is None:
        return []
    picked = {f: states[0].read for f, states in left.states.items() if len(states) == 1}
    return [
        (
            frozenset(left.along | chosen),
            {f: read for f, read in (picked | reads).items() if read is not None},
        )
        for chosen, reads in cheapest(left, tries)
    ]


def _component(net: _Net, seed: int) -> tuple[list[int], Narrowed | None]:
    """Classes that hang together with one, and what their faces of several readings may be."""
    classes, faces = _reach(net, seed)
    known = set(classes)
    both_ways: dict[int, list[int]] = {}
    for k in classes:
        for f, _ in net.clear.get(k, []):
            both_ways.setdefault(f, []).append(k)
    pairs = sorted({(own[0], own[1]) for own in both_ways.values() if len(own) == 2})
    return classes, narrow({f: _states_of(net, f, known) for f in faces}, pairs)


def _states_of(net: _Net, face: int, known: set[int]) -> list[State]:
    """What a face of several readings may be: no linking side, or one reading in one of two directions."""
    on_face = frozenset(net.of_edge[e] for chain in net.readings[face][0].chains for e in chain) & known
    states = [State(read=None, along=frozenset(), on_face=on_face, cost=0.0)]
    for reading in net.readings[face]:
        for way in (0, 1):
            along = _crossed(reading, way, net.of_edge)
            if along <= known and not along & _crossed(reading, 1 - way, net.of_edge):
                states.append(State(read=(reading, way), along=frozenset(along), on_face=on_face, cost=reading.cost))
    return states


def _crossed(reading: Reading, way: int, of_edge: list[int]) -> set[int]:
    """Classes of the two opposite chains `way` of a reading."""
    return {of_edge[e] for k in (way, way + 2) for e in reading.chains[k]}
