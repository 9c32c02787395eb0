"""From the user's words for walls to rows of a section and to layers of a sweep.

A wall that is a side of the sweep gets rows of quads along its edges of the section; the edges that end there are
divided so that the rows end at their nodes. A wall that is a cap gets its layers along the rails.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sin

from ...arrays import FloatArray
from ...asked import WallLayers
from ...errors import InputError
from ...options import SweepOptions
from ...surface import Division, Walls
from ...sweep import Intervals, Sweep
from .leaving import STRAIGHT_ON, Leaving, joints


@dataclass(kw_only=True, eq=False)
class WallPlan(Leaving[int]):
    """What wall layers ask of one sweep, and of the edges that leave its walls.

    Attributes
    ----------
    edges : dict of int to WallLayers
        Edges of the source cap along which rows are laid, heights in working units.
    faces : set of int
        The walls along which they are.
    counts : dict of tuple of int to int
        Segments that the edges need at which rows end or layers begin.
    cap_heights : dict of bool to (n,) float64
        Heights of the layers along the source (True) and the target, where these are walls.
    """

    edges: dict[int, WallLayers] = field(default_factory=dict)
    faces: set[int] = field(default_factory=set)
    counts: dict[tuple[int, ...], int] = field(default_factory=dict)
    cap_heights: dict[bool, FloatArray] = field(default_factory=dict)

    def divisions(self, sweep: Sweep) -> dict[int, Division]:
        """How the edges at which rows end divide themselves."""
        edges = sweep.solid.edges
        return {e: self.division(e, edges[e].length, edges[e].label()) for e in self.ends}

    @property
    def walls(self) -> Walls:
        """For the surface stage."""
        return Walls(layers=self.edges, faces=frozenset(self.faces))


def end_rows(sweep: Sweep, plan: WallPlan, counts: Intervals, options: SweepOptions) -> None:
    """Find where the rows along the edges of a plan end, and the segments that this asks for."""
    _go_on(sweep, plan)
    _end_rows(sweep, plan)
    _need_segments(sweep, plan, counts, options)


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
        plan.leave(edge, own, sine=sin(angle), at_start=at_start)
    for e in plan.ends:
        if e not in sweep.rails:
            plan.shorten(e, sweep.solid.edges[e])


def _need_segments(sweep: Sweep, plan: WallPlan, counts: Intervals, options: SweepOptions) -> None:
    """Demand segments for the rows that end at an edge, and for what is left of it."""
    edges = sweep.solid.edges
    needed = {e: plan.needed(e, edges[e].length, edges[e].length / max(1, int(counts.counts[e]))) for e in plan.ends}
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
