r"""A row of quads along the edge of a cap that runs tangent into the sides.

Place in the flow: ``quads`` lays it around a face whose rim is smooth, before a mesher fills what is left.

Method: where cap and side are tangent, a hex at the rim is as good as the angle between the first segment on the cap
and the first one on the side, and as its quad's corners at the rim. So the row is deep enough to turn the cap by
`_TURN`, as far as the segments along the rim are no shorter than that, and its quads stand square on the rim::

        o---o---o---o          i--i--i       a node at a corner of some 90 degrees
        |   |   |   |          |  |          has one quad alone, and its
        i---i---i---i          i--o          neighbours share an inner node

Not handled: re-entrant corners sharper than some 240 degrees, rows that meet each other, and corners fewer than three
segments apart, whose neighbours would share two inner nodes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray
from ..polygons import interior_angles, signed_area
from ..sweep import DirectedEdge, Sweep
from .crossings import loops_cross
from .spacing import SMOOTH

_TURN = np.pi / 8
"""Turn of the cap over the row, where it is curved as much within `_DEEPEST` segments."""
_DEPTHS = np.linspace(0.4, 2.5, 15)
"""Depths that are tried, in segments of the rim."""
_END = np.radians(125)
"""Angle of a corner below which it has one quad."""
_REENTRANT = np.radians(240)
"""Angle of a rim's node beyond which a row would fan out there."""
_SMOOTHINGS = 4
"""Laplacian passes over the row's inner nodes, which only even out its height."""
_SHARES = (1.0, 0.7, 0.45)
"""Heights of the row that are tried, as a share of the wanted length."""


def smooth_loops(sweep: Sweep, loops: Sequence[Sequence[DirectedEdge]]) -> list[bool]:
    """Tell which loops of a source face lie on the rim and are tangent to sides, here or at the target."""
    found = []
    for loop in loops:
        edges = {e for e, _ in loop}
        mine = [j for j, rim in enumerate(sweep.source_loops) if edges == {e for e, _ in rim}]
        both = [e for j in mine for e, _ in sweep.source_loops[j] + sweep.target_loops[j]]
        found.append(any(abs(sweep.solid.edges[e].dihedral - np.pi) < SMOOTH for e in both))
    return found


def lay_rows(
    loops: Sequence[FloatArray], smooth: Sequence[bool], normals_at: Callable[[FloatArray], FloatArray]
) -> tuple[FloatArray, IntArray, list[IntArray]] | None:
    """Lay a row of quads along the smooth loops of a polygon.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, holes clockwise.
    smooth : sequence of bool
        Which of them get a row.
    normals_at : callable
        Unit normals (m, 3) of the cap at places (m, 2).

    Returns
    -------
    inner : (n, 2) float64
        The rows' inner nodes.
    quads : (q, 4) int64
        Counter-clockwise; ids run through the loops, then `inner`.
    left : list of (m,) int64
        Loops of what is left to be filled, in the order of `loops`.
    None
        Where there is no room for the rows.
    """
    if any(flags and len(loop) < 8 for loop, flags in zip(loops, smooth, strict=True)):
        return None
    boundary = np.concatenate(loops)
    frames = [_inward(loop) for loop in loops]
    if any(is_smooth and (angle > _REENTRANT).any() for (_, angle), is_smooth in zip(frames, smooth, strict=True)):
        return None
    if any(_crowded(angle) for (_, angle), is_smooth in zip(frames, smooth, strict=True) if is_smooth):
        return None
    for share in _SHARES:
        inner: list[FloatArray] = []
        quads: list[IntArray] = []
        left: list[IntArray] = []
        first, n = 0, len(boundary)
        for loop, (inward, angle), is_smooth in zip(loops, frames, smooth, strict=True):
            ids = first + np.arange(len(loop), dtype=np.int64)
            first += len(loop)
            if not is_smooth:
                left.append(ids)
                continue
            places = loop + share * _depths(loop, inward, normals_at)[:, None] * inward
            number, places = _shared(places, angle)
            inner.append(places)
            quads.append(_quads_along(ids, n + number, angle))
            left.append(np.unique(n + number))
            n += len(places)
        points = np.concatenate([boundary, *inner])
        rows = np.concatenate(quads)
        rest = [points[loop] for loop in left]
        # Rows that have passed through each other leave less than nothing.
        if _least_sine(points[rows]) > 0.2 and sum(map(signed_area, rest)) > 0 and not loops_cross(rest):
            return np.concatenate(inner), rows, left
    return None


def _inward(loop: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Direction (m, 2) halving the angle at every node, of such length that steps are square to the rim; the angles."""
    after, angle = np.roll(loop, -1, axis=0) - loop, interior_angles(loop)
    half = np.arctan2(after[:, 1], after[:, 0]) + angle / 2
    direction = np.stack([np.cos(half), np.sin(half)], axis=1)
    return direction / np.maximum(np.sin(angle / 2), 0.5)[:, None], angle


def _depths(loop: FloatArray, inward: FloatArray, normals_at: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Depth of the row at every node."""
    steps = np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1)
    segment = (steps + np.roll(steps, 1)) / 2
    at_rim = normals_at(loop)
    depth = np.ones(len(loop))
    open_ = np.ones(len(loop), dtype=bool)
    for share in _DEPTHS:
        turned = np.einsum("ij,ij->i", normals_at(loop + (share * segment)[:, None] * inward), at_rim) < np.cos(_TURN)
        depth[open_ & turned] = share
        open_ &= ~turned
    curved = np.einsum("ij,ij->i", normals_at(loop + (_DEPTHS[-1] * segment)[:, None] * inward), at_rim) < np.cos(0.05)
    depth[open_ & curved] = _DEPTHS[-1]
    depth *= segment
    for _ in range(_SMOOTHINGS):
        depth = (np.roll(depth, 1) + 2 * depth + np.roll(depth, -1)) / 4
    return depth


def _crowded(angle: FloatArray) -> bool:
    """Whether corners with one quad stand so near to each other that both would have a neighbour's inner node."""
    corners = np.flatnonzero(angle < _END)
    apart = np.diff(corners, append=corners[:1] + len(angle))
    return bool((apart < 3).any())


def _shared(places: FloatArray, angle: FloatArray) -> tuple[IntArray, FloatArray]:
    """Number the inner nodes: a node at a sharp corner and both its neighbours have one in common, the corner's."""
    n = len(places)
    owner = np.arange(n)
    for i in np.flatnonzero(angle < _END):
        owner[np.array([i - 1, i, i + 1]) % n] = i
    kept = np.unique(owner)
    number = np.full(n, -1, dtype=np.int64)
    number[kept] = np.arange(len(kept))
    return number[owner], places[kept]


def _quads_along(ids: IntArray, inner: IntArray, angle: FloatArray) -> IntArray:
    n = len(ids)
    quads = []
    for i in range(n):
        k = (i + 1) % n
        if inner[i] != inner[k]:
            quads.append([ids[i], ids[k], inner[k], inner[i]])
        elif angle[i] < _END:
            quads.append([ids[i - 1], ids[i], ids[k], inner[i]])
    return np.array(quads, dtype=np.int64)


def _least_sine(corners: FloatArray) -> float:
    step = np.roll(corners, -1, axis=1) - corners
    step /= np.maximum(np.linalg.norm(step, axis=2, keepdims=True), 1e-300)
    back = np.roll(step, 1, axis=1)
    return float(np.min(back[..., 0] * step[..., 1] - back[..., 1] * step[..., 0]))
