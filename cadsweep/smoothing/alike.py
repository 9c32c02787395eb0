"""Patches that are each other's image by a motion or a mirror: one is worked on, the others follow it.

Place in the flow: :mod:`.ladder` takes its steps through it, and scores what it gets as anything else. A plate with a
hundred equal bosses has a hundred equal patches, or four mirror images of a quarter of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import FloatArray, IntArray
from .patch import Patch

Step = Callable[[Patch, FloatArray], FloatArray]
"""Makes new places (n, 3) of the nodes of a patch from those that they have."""

SAME = 1e-6
"""Distance of nodes that are each other's image, over the size of a patch."""

LEAST_ANCHORS = 3
"""Nodes that are known by their distance from the middle, by which a motion is found."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Done:
    """A patch that was worked on, and where its nodes (n, 3) went."""

    patch: Patch
    middle: FloatArray
    radii: FloatArray
    moved: FloatArray


class Alike:
    """The patches of a mesh that steps were taken on."""

    def __init__(self) -> None:
        self._done: dict[tuple[Step, int, int, int], list[_Done]] = {}

    def stepped(self, step: Step, patch: Patch, points: FloatArray) -> FloatArray:
        """What a step makes of a patch with its nodes at points (n, 3), taken anew or as the image of one before.

        What is free moves alone, and is brought back to its faces; an image that is not better there is none.
        """
        if points is not patch.points:  # as a step before left it
            return step(patch, points)
        middle = points.mean(axis=0)
        radii = np.linalg.norm(points - middle, axis=1)
        known = self._done.setdefault((step, len(patch.hexes), len(points), int(np.count_nonzero(patch.free))), [])
        for other in known:
            moved = _image(patch, middle, radii, other)
            if moved is not None and patch.score(moved).beats(patch.score(points)):
                return moved
        moved = step(patch, points)
        known.append(_Done(patch=patch, middle=middle, radii=radii, moved=moved.copy()))
        return moved


def _image(patch: Patch, middle: FloatArray, radii: FloatArray, other: _Done) -> FloatArray | None:
    """Where the nodes (n, 3) of a patch go as those of another one did; None where it is no image of that."""
    tolerance = SAME * float(radii.max())
    if np.abs(np.sort(other.radii) - np.sort(radii)).max() > tolerance:
        return None
    for turn in _motions(patch.points - middle, radii, other, tolerance):
        to = _answering(patch, other, (patch.points - middle) @ turn, tolerance)
        if to is not None:
            moved = (other.moved - other.middle)[to] @ turn.T + middle
            moved[~patch.free] = patch.points[~patch.free]
            return moved if patch.snap is None else patch.snap(moved)
    return None


def _motions(centred: FloatArray, radii: FloatArray, other: _Done, tolerance: float) -> Iterator[FloatArray]:
    """Orthogonal matrices (3, 3), rows times which may be those of another patch: one, or two that differ by a mirror.

    Found from the nodes that no other node is as far from the middle as.
    """
    mine, theirs = np.argsort(radii), np.argsort(other.radii)
    apart = np.diff(radii[mine]) > 4 * tolerance
    alone = np.flatnonzero(np.concatenate([[True], apart]) & np.concatenate([apart, [True]]))
    if len(alone) < LEAST_ANCHORS:
        return
    both = centred[mine[alone]].T @ (other.patch.points - other.middle)[theirs[alone]]
    left, strength, right = np.linalg.svd(both)
    yield left @ right
    if strength[2] <= SAME * strength[0]:  # nodes of one plane, as of a patch that is its own mirror image
        yield left @ np.diag([1.0, 1.0, -1.0]) @ right


def _answering(patch: Patch, other: _Done, placed: FloatArray, tolerance: float) -> IntArray | None:
    """The node of another patch at each of placed nodes (n, 3); None where these are no patches of one kind."""
    away, to = cKDTree(other.patch.points - other.middle).query(placed)
    if away.max() > tolerance or len(np.unique(to)) < len(to) or (other.patch.free[to] != patch.free).any():
        return None
    rows, others = np.sort(to[patch.hexes], axis=1), np.sort(other.patch.hexes, axis=1)
    order, other_order = np.lexsort(rows.T), np.lexsort(others.T)
    is_same = np.array_equal(rows[order], others[other_order])
    return to if is_same and np.allclose(patch.goals[order], other.patch.goals[other_order], rtol=1e-3) else None
