"""Matched faces that are walls of columns: edges of the plane that answer each other.

Matched caps need nothing: columns stand straight, so that the quads lie over each other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...brep import Part
from ...errors import InputError
from ...options import SweepOptions
from ...stack import Stack
from ...surface import Partners
from .periodic import SAME, Match, edge_images, find_matches

_ALONG = 1e-9
"""Part of a motion along the columns up to which it stays on the plane."""


def matched_walls(part: Part, stack: Stack, options: SweepOptions) -> list[Partners]:
    """The edges under matched walls of a stack, by the keys of the prism that its plane is a cap of.

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
    return found


def _axis(stack: Stack) -> str:
    return ", ".join(f"{c:.3g}" for c in stack.direction + 0.0)


def _on_plane(stack: Stack, match: Match, faces: tuple[frozenset[int], frozenset[int]]) -> Partners:
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
    return Partners(motion=motion, edges=images, faces={})
