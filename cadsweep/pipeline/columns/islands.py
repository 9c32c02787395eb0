"""A part without the outlines in walls of a stack that its layers cannot follow: they go up and come down again.

Such outlines divide one surface, as those of contacts and logos do. Their names go to the quads whose middles lie in
them, as of every merged face.
"""

from __future__ import annotations

import numpy as np

from ... import cad
from ...brep import Part
from ...stack import Stack

_ALONG = np.linspace(0.0, 1.0, 9)
"""Where an edge is looked at."""
_LEVEL = 1e-7
"""Share of the part's size by which a level edge may rise."""
_STRAIGHT = 1e-6
"""Share of its length by which a straight edge may bend."""


def without_islands(part: Part, stack: Stack) -> Part | None:
    """The part with the faces beside such outlines merged; None where there are none, or that cannot be done."""
    stations = set(stack.stations)
    groups = [group for group in cad.find_mergeable(part) if _is_island(stack, stations.intersection(group))]
    return cad.merge_faces(part, groups) if groups else None


def _is_island(stack: Stack, edges: set[int]) -> bool:
    """Whether an outline of walls, or a part of it, is one that layers cannot follow."""
    inner = {e for f in stack.walls for loop in stack.solid.faces[f].loops[1:] for e in loop.edges}
    return any(_rises(stack, e) and (e in inner or _bends(stack, e)) for e in edges)


def _rises(stack: Stack, e: int) -> bool:
    heights = stack.solid.edges[e].curve.evaluate(_ALONG) @ stack.direction
    return float(np.ptp(heights)) > _LEVEL * stack.solid.size


def _bends(stack: Stack, e: int) -> bool:
    points = stack.solid.edges[e].curve.evaluate(_ALONG)
    chord = points[0] + np.outer(_ALONG, points[-1] - points[0])
    return float(np.abs(points - chord).max()) > _STRAIGHT * stack.solid.edges[e].length


__all__ = ["without_islands"]
