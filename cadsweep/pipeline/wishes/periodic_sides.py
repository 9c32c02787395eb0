"""Matched faces that are sides or caps of one sweep, or walls of columns: counts, divisions and nodes that answer.

Matched caps of columns need nothing: these stand straight, so that the quads lie over each other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...brep import Part
from ...errors import InputError
from ...options import SweepOptions
from ...stack import Stack
from ...surface import Division, Motion, turned
from ...sweep import Intervals, Sweep
from .periodic import SAME, Match, edge_images, find_matches

_ALONG = 1e-9
"""Part of a motion along the columns up to which it stays on the plane."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SweepMatch:
    """Two groups of faces of a sweep, and what carries the first to the second.

    Attributes
    ----------
    faces : (frozenset of int, frozenset of int)
    motion : Motion
    edges : dict of int to (int, bool)
        Edge of the first to that of the second, and whether it runs from start to start.
    """

    faces: tuple[frozenset[int], frozenset[int]]
    motion: Motion
    edges: dict[int, tuple[int, bool]]


def tied_counts(
    sweep: Sweep, matches: Sequence[SweepMatch], counts: Intervals, demanded: Mapping[tuple[int, ...], int]
) -> dict[tuple[int, ...], int]:
    """Counts that make matched edges around the loops equal, beside those that are demanded.

    Raises
    ------
    InputError
        Two edges that answer each other are asked to have unlike counts.
    """
    single = {edges[0]: n for edges, n in demanded.items() if len(edges) == 1}
    rails = set(sweep.rails)
    found: dict[tuple[int, ...], int] = {}
    for match in matches:
        for a, (b, _) in match.edges.items():
            if a == b or a in rails or b in rails:
                continue
            asked = {single[e] for e in (a, b) if e in single}
            if len(asked) > 1:
                labels = " and ".join(sweep.solid.edges[e].label() for e in (a, b))
                raise InputError(f"periodic: {labels} answer each other, and are asked to have unlike counts")
            n = asked.pop() if asked else max(int(counts.counts[a]), int(counts.counts[b]))
            found |= {(e,): n for e in (a, b) if e not in single and counts.counts[a] != counts.counts[b]}
    return found


def with_images(matches: Sequence[SweepMatch], divisions: Mapping[int, Division]) -> dict[int, Division]:
    """The divisions of edges, and of those that answer them on matched faces."""
    found = dict(divisions)
    for match in matches:
        for a, (b, same) in match.edges.items():
            for one, other in ((a, b), (b, a)):
                if one in divisions and other not in divisions:
                    found[other] = divisions[one] if same else turned(divisions[one])
    return found


def side_motions(sweep: Sweep, matches: Sequence[SweepMatch]) -> list[tuple[frozenset[int], frozenset[int], Motion]]:
    """Matches of sides, for the surface stage."""
    sides = {side.face for side in sweep.linking_sides}
    return [(*match.faces, match.motion) for match in matches if match.faces[0] <= sides]


def of_walls(part: Part, stack: Stack, options: SweepOptions) -> tuple[SweepMatch, ...]:
    """The matched walls of a stack, as matched sides of the prism that its plane is a cap of.

    Raises
    ------
    InputError
        Faces that are neither both walls nor both caps, that are matched along the columns, or below which the plane
        is divided in different places.
    """
    found = []
    for match in find_matches(part, part, options):
        faces = [{f for _, f in own} for own in match.places]
        if all(own <= set(stack.source + stack.target) for own in faces):
            continue
        if not all(own <= set(stack.walls) for own in faces):
            raise InputError(
                f"periodic: the part is meshed as columns along ({_axis(stack)}), and '{match.words[0]}' and "
                f"'{match.words[1]}' are neither both along it nor both across"
            )
        found.append(_on_plane(stack, match, (frozenset(faces[0]), frozenset(faces[1]))))
    return tuple(found)


def _axis(stack: Stack) -> str:
    return ", ".join(f"{c:.3g}" for c in stack.direction + 0.0)


def _on_plane(stack: Stack, match: Match, faces: tuple[frozenset[int], frozenset[int]]) -> SweepMatch:
    prism, up = stack.plan.solid, stack.direction
    motion = match.motion
    turn = np.linalg.norm(motion.matrix @ up - up)
    if turn > _ALONG or abs(float(motion.shift @ up)) > SAME * stack.solid.size:
        raise InputError(
            f"periodic: '{match.words[0]}' is carried to '{match.words[1]}' by a motion that is not across the columns "
            f"along ({_axis(stack)}) that the part is meshed in"
        )
    motion = replace(motion, shift=motion.shift - (motion.shift @ up) * up)
    below = []
    for own in faces:
        edges = {e for f in own for e in stack.solid.faces[f].edges}
        below.append([e for e, over in stack.arrangement.over.items() if edges & set(over)])
    one, other = ({e: prism.edges[e] for e in own} for own in below)
    near = SAME * stack.solid.size + stack.solid.tolerance
    images, alone = edge_images(one, other, motion, near)
    if alone:
        here, there = match.words if alone[0] in one else match.words[::-1]
        place = stack.solid.units.place(prism.edges[alone[0]].midpoint)
        raise InputError(
            f"periodic: what is above or below divides '{here}' around ({place}) in another place than '{there}'; "
            "where outlines of caps end at one of two matched walls, they must end at the other, too"
        )
    sides = tuple(
        frozenset(side.face for side in stack.plan.linking_sides if {e for e, _ in side.bottom} & set(own))
        for own in below
    )
    return SweepMatch(faces=(sides[0], sides[1]), motion=motion, edges=images)
