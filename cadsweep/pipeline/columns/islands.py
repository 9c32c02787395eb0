"""A part without the outlines within walls of a stack that its layers cannot follow: they go up and come down again.

Such outlines divide one surface, as those of contacts and logos do. Their names go to the quads whose middles lie in
them, as of every merged face.
"""

from __future__ import annotations

import numpy as np

from ... import cad
from ...brep import Part
from ...errors import NotSweepableError
from ...stack import Stack

_ALONG = np.linspace(0.0, 1.0, 9)
"""Where an edge is looked at."""
_LEVEL = 1e-7
"""Share of the part's size by which a level edge may rise."""


def without_islands(part: Part, stack: Stack) -> Part:
    """The part with the faces beside such outlines merged.

    Raises
    ------
    NotSweepableError
        Both sides of one are of the same face of the model, or OpenCASCADE cannot merge them.
    """
    walls = [stack.solid.faces[f] for f in stack.walls]
    inner = {e for face in walls for loop in face.loops[1:] for e in loop.edges}
    islands = {e for e in inner & set(stack.stations) if _rises(stack, e)}
    if not islands:
        return part
    groups = [group for group in cad.find_mergeable(part) if islands & set(group)]
    merged = cad.merge_faces(part, groups) if islands <= {e for group in groups for e in group} else None
    if merged is None:
        face = next(face for face in walls if islands & set(face.edges))
        raise NotSweepableError(f"no layers follow the outline within {face.label()}, which is a wall of the columns")
    return merged


def _rises(stack: Stack, e: int) -> bool:
    heights = stack.solid.edges[e].curve.evaluate(_ALONG) @ stack.direction
    return float(np.ptp(heights)) > _LEVEL * stack.solid.size


__all__ = ["without_islands"]
