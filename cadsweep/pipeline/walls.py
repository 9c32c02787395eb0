"""From the user's words for walls to rows of a section and to layers of a sweep.

A wall that is a side of the sweep gets rows of quads along its edges of the section; the edges that end there are
divided so that the rows end at their nodes. A wall that is a cap gets its layers along the rails.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from .. import cad
from ..arrays import FloatArray
from ..asked import WallLayers, layer_heights, wall_layers
from ..brep import Part
from ..errors import InputError
from ..options import SweepOptions
from ..surface import Division, Walls, turned_round
from ..sweep import Intervals, Sweep

STRAIGHT_ON = np.radians(135)
"""Angle of a section from which on a wall goes on along its neighbour: its rows could not end there."""
MOST_OF_EDGE = 0.8
"""Part of an edge that rows which end at it may take."""
LEAST_SLANT = 0.2
"""Sine of the angle between an edge and the wall that it leaves below which its layers get no longer."""
_MOST_GROWTH = 1e3
"""Growth up to which one is looked for that fills a length."""


@dataclass(kw_only=True, eq=False)
class WallPlan:
    """What wall layers ask of one sweep.

    Attributes
    ----------
    edges : dict of int to WallLayers
        Edges of the source cap along which rows are laid, heights in working units.
    faces : set of int
        The walls along which they are.
    ends : dict of int to dict of bool to (n,) float64
        For an edge at whose start (True) or end rows end or layers begin, distances of their nodes.
    counts : dict of tuple of int to int
        Segments that these edges need.
    cap_heights : dict of bool to (n,) float64
        Heights of the layers along the source (True) and the target, where these are walls.
    notes : list of str
    """

    edges: dict[int, WallLayers] = field(default_factory=dict)
    faces: set[int] = field(default_factory=set)
    ends: dict[int, dict[bool, FloatArray]] = field(default_factory=dict)
    growths: dict[int, float] = field(default_factory=dict)
    counts: dict[tuple[int, ...], int] = field(default_factory=dict)
    cap_heights: dict[bool, FloatArray] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def divisions(self, sweep: Sweep) -> dict[int, Division]:
        """How the edges at which rows end divide themselves."""
        found = {}
        for e, ends in self.ends.items():
            edge = sweep.solid.edges[e]
            found[e] = layered(ends, self.growths[e], length=edge.length, label=edge.label())
        return found

    @property
    def walls(self) -> Walls:
        """For the surface stage."""
        return Walls(layers=self.edges, faces=frozenset(self.faces))


def plan_walls(part: Part, sweep: Sweep, options: SweepOptions, counts: Intervals) -> WallPlan:
    """Find what wall layers ask of a sweep whose counts are roughly known.

    Raises
    ------
    InputError
        A name that no face has, a face that is neither a side nor a cap, or walls that contradict each other.
    """
    plan = WallPlan()
    for word, value in (options.wall_layers or {}).items():
        asked = wall_layers(f"the wall layers of '{word}'", value)
        own = replace(asked, first=asked.first / part.scale)
        for f in cad.select_faces(part, word):
            if options.fractions is not None and f in (*sweep.source, *sweep.target):
                label = sweep.solid.faces[f].label()
                raise InputError(
                    f"wall layers of '{word}': {label} is a cap, and fractions place the layers along the sweep"
                )
            _take_face(sweep, plan, f, own, word)
    end_rows(sweep, plan, counts, options)
    return plan


def end_rows(sweep: Sweep, plan: WallPlan, counts: Intervals, options: SweepOptions) -> None:
    """Find where the rows along the edges of a plan end, and the segments that this asks for."""
    _go_on(sweep, plan)
    _end_rows(sweep, plan)
    _need_segments(sweep, plan, counts, options)


def _take_face(sweep: Sweep, plan: WallPlan, face: int, own: WallLayers, word: str) -> None:
    label = sweep.solid.faces[face].label()
    for cap, at_source in ((sweep.source, True), (sweep.target, False)):
        if face not in cap:
            continue
        _layers_at_cap(sweep, plan, face, own, at_source=at_source)
        if len(cap) > 1:
            plan.notes.append(f"wall layers of '{word}' are those of the whole cap, of {len(cap)} faces")
        return
    sides = [side for side in sweep.linking_sides if side.face == face]
    if not sides:
        raise InputError(f"wall layers of '{word}': {label} is neither a side of the sweep nor one of its caps")
    edges = {e for side in sides for e in _source_edges_below(sweep, side.face)}
    if not edges:
        raise InputError(f"wall layers of '{word}': no edge of the source lies below {label}")
    plan.faces.add(face)
    for e in sorted(edges):
        known = plan.edges.setdefault(e, own)
        if known != own:
            raise InputError(f"{sweep.solid.edges[e].label()}: wall layers of '{word}' and of another name differ")


def _source_edges_below(sweep: Sweep, face: int) -> set[int]:
    """Edges of the source cap from which a column of sides leads to a face."""
    under: dict[int, set[int]] = {}
    for side in sweep.linking_sides:
        for e, _ in side.top:
            under.setdefault(e, set()).update(e for e, _ in side.bottom)
    on_source = {e for loop in sweep.source_loops for e, _ in loop}
    waiting = [e for side in sweep.linking_sides if side.face == face for e, _ in side.bottom]
    found, seen = set(), set(waiting)
    while waiting:
        e = waiting.pop()
        if e in on_source:
            found.add(e)
            continue
        new = under.get(e, set()) - seen
        seen |= new
        waiting += new
    return found


def _layers_at_cap(sweep: Sweep, plan: WallPlan, face: int, own: WallLayers, *, at_source: bool) -> None:
    """Ask the rails that begin at a cap for layers of the heights asked for, square to it."""
    solid = sweep.solid
    loops = sweep.source_loops if at_source else sweep.target_loops
    at_cap = {v for loop in loops for e, _ in loop for v in (solid.edges[e].start, solid.edges[e].end)}
    surface = solid.faces[face].surface
    plan.cap_heights[at_source] = heights_of(own)
    for e in sweep.rails:
        edge = solid.edges[e]
        for at_start, vertex in ((True, edge.start), (False, edge.end)):
            if vertex not in at_cap:
                continue
            normal = surface.normals(surface.project(solid.vertices[vertex][None]))[0]
            slant = abs(float(edge.tangents[0 if at_start else 1] @ normal))
            distances = heights_of(own) / max(slant, LEAST_SLANT)
            if distances[-1] > MOST_OF_EDGE * edge.length:
                taken, length = distances[-1] * solid.units.scale, edge.length * solid.units.scale
                raise InputError(
                    f"wall layers: {own.n} layers at {solid.faces[face].label()} take {taken:.3g} of {edge.label()}, "
                    f"which is {length:.3g} long: ask for fewer or thinner ones"
                )
            plan.ends.setdefault(e, {})[at_start] = distances
            plan.growths[e] = max(own.growth, 1.05)


def heights_of(own: WallLayers) -> FloatArray:
    return layer_heights(np.array([own.first]), np.array([own.growth]), own.n, np.array([np.inf]))[0]


def joints(sweep: Sweep) -> Iterator[tuple[int, tuple[int, bool], tuple[int, bool], float]]:
    """Faces of the source, pairs of their directed edges that follow each other, and the face's angle between them."""
    for f in sweep.source:
        for loop in sweep.solid.faces[f].loops:
            directed = loop.directed
            for j, angle in enumerate(loop.angles):
                yield f, directed[j - 1], directed[j], angle


def _go_on(sweep: Sweep, plan: WallPlan) -> None:
    """Let walls go on along neighbours into which they run on straight, or around a re-entrant corner."""
    on_rim = {e for loop in sweep.source_loops for e, _ in loop}
    changed = True
    while changed:
        changed = False
        for _, (a, _), (b, _), angle in joints(sweep):
            if (a in plan.edges) == (b in plan.edges) or angle < STRAIGHT_ON:
                continue
            wall, other = (a, b) if a in plan.edges else (b, a)
            if other not in on_rim:
                continue  # an edge inside the cap: the rows end there whatever the angle
            plan.edges[other] = plan.edges[wall]
            plan.notes.append(
                f"wall layers go on along {sweep.solid.edges[other].label()}, into which the wall runs without a corner"
            )
            changed = True


def _end_rows(sweep: Sweep, plan: WallPlan) -> None:
    """Find the edges at which rows end, and where their nodes are to be."""
    for _, (a, a_forward), (b, b_forward), angle in joints(sweep):
        one, other = plan.edges.get(a), plan.edges.get(b)
        if one is not None and other is not None:
            if one.n != other.n:
                raise InputError(
                    f"{sweep.solid.edges[a].label()} and {sweep.solid.edges[b].label()} are walls that meet, and have "
                    f"{one.n} and {other.n} layers: ask for as many of both"
                )
            continue
        if one is None and other is None:
            continue
        own = one or other
        assert own is not None
        # The edge that is no wall ends at the joint where it is the first of the two.
        edge, at_start = (b, b_forward) if one is not None else (a, not a_forward)
        plan.ends.setdefault(edge, {})[at_start] = heights_of(own) / max(float(np.sin(angle)), LEAST_SLANT)
        plan.growths[edge] = max(own.growth, 1.05)
    for e, ends in plan.ends.items():
        if e in sweep.rails:
            continue
        whole = sweep.solid.edges[e]
        taken = sum(float(d[-1]) for d in ends.values())
        if taken > MOST_OF_EDGE * whole.length:
            plan.ends[e] = {side: d * (MOST_OF_EDGE * whole.length / taken) for side, d in ends.items()}
            plan.notes.append(f"wall layers are thinner at {whole.label()}, which is too short for them")


def _need_segments(sweep: Sweep, plan: WallPlan, counts: Intervals, options: SweepOptions) -> None:
    """Demand segments for the rows that end at an edge, and for what is left of it."""
    needed: dict[int, int] = {}
    for e, ends in plan.ends.items():
        edge = sweep.solid.edges[e]
        size = edge.length / max(1, int(counts.counts[e]))
        left = edge.length - sum(float(d[-1]) for d in ends.values())
        last = [float(np.diff(d, prepend=0.0)[-1]) for d in ends.values()]
        needed[e] = sum(len(d) for d in ends.values()) + count_between(left, last, plan.growths[e], size)
    for f in sweep.source:
        for loop in sweep.solid.faces[f].loops:
            if len(loop.edges) == 4:
                for a, b in (loop.edges[:3:2], loop.edges[1::2]):
                    if a in needed and b in needed:
                        needed[a] = needed[b] = max(needed[a], needed[b])
    rails = [e for e in needed if e in sweep.rails]
    if options.layers is None:
        # All rails of a span have as many layers: one of them asks for all.
        for span in sweep.spans[0]:
            own = [e for e in span if e in rails]
            if own:
                most = max(own, key=lambda e: needed[e])
                plan.counts[most,] = needed[most]
    plan.counts |= {(e,): n for e, n in needed.items() if e not in rails}


def count_between(length: float, last: list[float], growth: float, size: float) -> int:
    """Segments that lead on from the last layers, growing up to the size."""
    for n in range(1, 100_000):
        if _grown(n, last, growth, size).sum() >= length:
            return n
    return 100_000


def _grown(n: int, last: list[float], growth: float, most: float) -> FloatArray:
    """Lengths of n segments that grow away from the layers at one end or at both, up to the greatest."""
    steps = growth ** np.arange(1, n + 1, dtype=float)
    rows = [last[0] * steps, *(own * steps[::-1] for own in last[1:])]
    return np.minimum(np.min(rows, axis=0), max(most, min(last)))


def layered(ends: Mapping[bool, FloatArray], growth: float, *, length: float, label: str) -> Division:
    """The division of a line with nodes at given distances from its start (True) and its end."""
    begin, end = (ends.get(side, np.empty(0)) / length for side in (True, False))
    return partial(_layered, begin=begin, end=end, growth=growth, label=label)


def _layered(n: int, *, begin: FloatArray, end: FloatArray, growth: float, label: str) -> FloatArray:
    """Fractions (n + 1,) of an edge with nodes at given fractions from its ends, and growing segments between."""
    n_left = n - len(begin) - len(end)
    if n_left < 1:
        raise InputError(
            f"{label} gets {n} segments, and {n - n_left} wall layers end or begin there: ask for at least "
            f"{n - n_left + 1}"
        )
    if not len(begin):
        return turned_round(_layered(n, begin=end, end=begin, growth=growth, label=label))
    left = 1.0 - begin[-1] - (end[-1] if len(end) else 0.0)
    last = [float(np.diff(d, prepend=0.0)[-1]) for d in (begin, end) if len(d)]
    weights = _grown(n_left, last, growth, np.inf)
    enough = weights.sum() >= left
    # The greatest segment where there are enough; else more growth than was asked for.
    low, high = (0.0, 1.0) if enough else (growth, _MOST_GROWTH)
    for _ in range(100):
        middle = (low + high) / 2
        made = np.minimum(weights, middle) if enough else _grown(n_left, last, middle, np.inf)
        low, high = (middle, high) if made.sum() < left else (low, middle)
    weights = np.minimum(weights, high) if enough else _grown(n_left, last, high, np.inf)
    between = begin[-1] + left * np.cumsum(weights)[:-1] / weights.sum()
    return np.concatenate([[0.0], begin, between, 1.0 - end[::-1], [1.0]])
