r"""Quads in the sharp corners of a polygon, which no mesher of triangles fills well.

Place in the flow: ``filling`` lays them before gmsh fills what is left.

Method: the tip is one quad, as good as its corner allows; where the sides run on close to each other, pairs of quads
follow it like the rungs of a ladder, until there is room::

        u---p1---p2---        the tip u p1 m1 q1, then pairs of quads between
         \   \    \           the rungs p1 m1 q1 and p2 m2 q2
          \   m1---m2
           \ /    /
            q1---q2---

Not handled: corners beside which the segments of the two sides are of unlike lengths.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from .chart import is_simple

SHARP = np.radians(32.0)
"""Interior angle below which a corner gets a quad of its own."""
_TRIES = ((0.5, 99), (0.25, 99), (0.25, 2), (0.1, 1))
"""How far the middle of a rung is off the straight line between its ends, in halves of its length; and most rungs."""
_ROOM = 1.3
"""Length of a rung, in segments beside it, from which on two quads across are too long."""
_UNLIKE = 1.6
"""Ratio of the sides' lengths to a rung beyond which quads on it would lean too much."""
_BENT = np.radians(45.0)
"""Turn of a side beyond which no rung goes to what follows."""


def lay_tips(loops: Sequence[FloatArray]) -> tuple[FloatArray, IntArray, list[IntArray]] | None:
    """Lay quads in the sharp corners of a polygon.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, holes clockwise.

    Returns
    -------
    inner : (n, 2) float64
        Middles of the rungs.
    quads : (q, 4) int64
        Counter-clockwise; ids run through the loops, then `inner`.
    left : list of (m,) int64
        Loops of what is left to be filled, in the order of `loops`.
    None
        Where there is no sharp corner, or no quads fit into one.
    """
    for push, most in _TRIES:
        inner: list[FloatArray] = []
        quads: list[list[int]] = []
        left: list[IntArray] = []
        first, n = 0, sum(len(loop) for loop in loops)
        for loop in loops:
            left.append(_lay(loop, first, n, push, most, inner, quads))
            first += len(loop)
        if not quads:
            return None
        places = np.concatenate([*loops, np.array(inner)])
        # A rung's middle beyond a side that bends towards it may leave a loop that is inside out.
        if is_simple([places[ids] for ids in left]):
            return np.array(inner), np.array(quads, dtype=np.int64), left
    return None


def _lay(  # noqa: PLR0917
    loop: FloatArray, first: int, n: int, push: float, most: int, inner: list[FloatArray], quads: list[list[int]]
) -> IntArray:
    """Tips of one loop; the loop that is left, ids counted on from `first`, middles from `n`."""
    size = len(loop)
    angles = interior_angles(loop)
    used = np.zeros(size, dtype=bool)
    cut: dict[int, tuple[int, int]] = {}  # tip: rungs, and the last one's middle
    for i in np.argsort(angles).tolist():
        if angles[i] >= SHARP:
            break
        k = min(most, _rungs(loop, angles, i))
        taken = (i + np.arange(-k, k + 1)) % size
        if not k or 2 * k + 3 > size or used[taken].any():
            continue
        used[taken] = True
        before = -1
        for j in range(1, k + 1):
            p, q = (i + j) % size, (i - j) % size
            middle = (loop[p] + loop[q]) / 2.0
            out = middle - loop[i]
            half = np.linalg.norm(loop[p] - loop[q]) / 2.0
            inner.append(middle + push * half * out / np.linalg.norm(out))
            m = n + len(inner) - 1
            if j == 1:
                quads.append([first + i, first + p, m, first + q])
            else:
                last_p, last_q = first + (i + j - 1) % size, first + (i - j + 1) % size
                quads += [[last_p, first + p, m, before], [before, m, first + q, last_q]]
            before = m
        cut[i] = k, before
    ids = list(range(first, first + size))
    kept: list[int | None] = list(ids)
    for i, (k, middle) in cut.items():
        for j in range(-k + 1, k):
            kept[(i + j) % size] = None
        kept[i] = middle
    return np.array([j for j in kept if j is not None], dtype=np.int64)


def _rungs(loop: FloatArray, angles: FloatArray, i: int) -> int:
    """Rungs that fit beside a sharp corner."""
    size, k = len(loop), 0
    while 2 * (k + 1) + 3 <= size:
        p, q = loop[(i + k + 1) % size], loop[(i - k - 1) % size]
        one, other = np.linalg.norm(p - loop[i]), np.linalg.norm(q - loop[i])
        if not 1.0 / _UNLIKE < one / other < _UNLIKE:
            break
        if k:
            bent = [abs(angles[(i + s * k) % size] - np.pi) > _BENT for s in (1, -1)]
            before = loop[(i + k) % size], loop[(i - k) % size]
            segments = (np.linalg.norm(p - before[0]) + np.linalg.norm(q - before[1])) / 2.0
            if any(bent) or np.linalg.norm(before[0] - before[1]) > _ROOM * segments:
                break
        k += 1
    return k


def interior_angles(loop: FloatArray) -> FloatArray:
    """Angles (m,) inside of a polygon's loop, its inside on the left."""
    after, back = np.roll(loop, -1, axis=0) - loop, np.roll(loop, 1, axis=0) - loop
    cross = after[:, 0] * back[:, 1] - after[:, 1] * back[:, 0]
    return np.asarray(np.arctan2(cross, (after * back).sum(axis=1)) % (2.0 * np.pi))
