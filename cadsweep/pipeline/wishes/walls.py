"""Rows of quads along edges of a section whose heights are asked for: where they go on, where they end.

The edges that end at a wall's are divided so that the rows end at their nodes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sin

from ...asked import WallLayers
from ...errors import InputError
from ...surface import Division
from ...sweep import Intervals, Sweep
from .leaving import STRAIGHT_ON, Leaving, joints


@dataclass(kw_only=True, eq=False)
class WallPlan(Leaving[int]):
    """What wall layers ask of a section, and of the edges that leave its walls.

    Attributes
    ----------
    edges : dict of int to WallLayers
        Edges of the source cap along which rows are laid, heights in working units.
    """

    edges: dict[int, WallLayers] = field(default_factory=dict)

    def divisions(self, sweep: Sweep) -> dict[int, Division]:
        """How the edges at which rows end divide themselves."""
        edges = sweep.solid.edges
        return {e: self.division(e, edges[e].length, edges[e].label()) for e in self.ends}

    def least_counts(self, sweep: Sweep, counts: Intervals) -> dict[int, int]:
        """Segments that these edges need for the rows, and for what is left of them as long as they are now."""
        edges = sweep.solid.edges
        return {e: self.needed(e, edges[e].length, edges[e].length / max(1, int(counts.counts[e]))) for e in self.ends}

    def end_rows(self, sweep: Sweep) -> None:
        """Find where the rows along the edges of a plan end."""
        _go_on(sweep, self)
        _end_rows(sweep, self)


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
        plan.shorten(e, sweep.solid.edges[e])
