"""How far quads lie off the CAD faces that their nodes are on.

Place in the flow: ``pipeline`` measures a mesh, and divides finer what is too coarse.

Method: nodes lie on their faces, so a mesh is off where its quads sag: at the middles of their sides and inside. A
chord that cuts a thin tip off may be near both walls while the tip is far from the chord: where a free-form side turns
much along a chord, what lies between its ends on the face is held against the chord, too.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Surface

_TURNS = 0.05
"""Sag of a chord over its length from which on the face may reach farther than that beyond it: an arc of 23 degrees."""
_BETWEEN = (0.2, 0.35, 0.5, 0.65, 0.8)
"""Places between the ends of a chord at which the face is looked at."""
_SINGULAR = 1e-3
"""Length of a partial derivative over its greatest, below which a parameter means nothing."""
_EXACT = ("plane", "cylinder", "cone", "sphere", "torus")
"""Kinds of faces that bulge evenly: they are as far from a chord as the chord is from them."""
_INSIDE = ((0.5, 0.5), (0.2, 0.2), (0.8, 0.2), (0.8, 0.8), (0.2, 0.8))
"""Places inside a quad of a cap: a bump may be smaller than it."""


def side_sags(face: Face, corners: FloatArray) -> FloatArray:
    """Distances (5 m,) of the middles of the sides of quads (m, 4, 3), and of their own, from a side of the sweep."""
    begin = corners.transpose(1, 0, 2).reshape(-1, 3)
    end = np.roll(corners, -1, axis=1).transpose(1, 0, 2).reshape(-1, 3)
    # All that is asked of a face at once: of hundreds of faces, most of the time would be that of the calls.
    sags: FloatArray = face.surface.distance(np.concatenate([0.5 * (begin + end), corners.mean(axis=1)]))
    if face.kind not in _EXACT:
        _add_cut_off(face.surface, begin, end, sags[: len(begin)])
    return sags


def _add_cut_off(surface: Surface, begin: FloatArray, end: FloatArray, sags: FloatArray) -> None:
    """Raise the distances (m,) of chords, from (m, 3) to (m, 3), where they cut more off than their middles say."""
    turning = np.flatnonzero(sags > _TURNS * np.linalg.norm(end - begin, axis=1))
    if len(turning):
        one, other = surface.project(begin[turning]), surface.project(end[turning])
        # Of faces that are one surface together nothing lies between the parameters of two of them.
        same = (one[:, 2:] == other[:, 2:]).all(axis=1)
        turning, one, other = turning[same], one[same], other[same]
    if len(turning):
        sags[turning] = np.maximum(sags[turning], _cut_off(surface, begin[turning], end[turning], one, other))


def _cut_off(surface: Surface, begin: FloatArray, end: FloatArray, one: FloatArray, other: FloatArray) -> FloatArray:
    """Greatest distance (m,) from chords of what lies between their ends in the parameters `one` and `other`."""
    for axis, period in enumerate(surface.periods):
        if period is not None:
            other[:, axis] -= period * np.round((other[:, axis] - one[:, axis]) / period)
    sizes = [np.linalg.norm(by, axis=1) for at in (one, other) for by in surface.derivatives(at)]
    sound = np.all([size > _SINGULAR * size.max() for size in sizes], axis=0)
    steps = end - begin
    squares = np.einsum("md,md->m", steps, steps)
    far = np.zeros(len(begin))
    for share in _BETWEEN:
        off = surface.evaluate(one + share * (other - one)) - begin
        along = np.clip(np.einsum("md,md->m", off, steps) / np.where(squares > 0, squares, 1.0), 0.0, 1.0)
        far = np.maximum(far, np.linalg.norm(off - along[:, None] * steps, axis=1))
    return np.where(sound, far, 0.0)


def quad_sags(surface: Surface, corners: FloatArray) -> FloatArray:
    """Greatest distance (m,) of quads (m, 4, 3) of a cap from their surface."""
    places = [
        (1 - u) * (1 - v) * corners[:, 0]
        + u * (1 - v) * corners[:, 1]
        + u * v * corners[:, 2]
        + (1 - u) * v * corners[:, 3]
        for u, v in _INSIDE
    ]
    places += [(corners[:, j] + corners[:, (j + 1) % 4]) / 2 for j in range(4)]
    distances: FloatArray = surface.distance(np.concatenate(places)).reshape(len(places), len(corners)).max(axis=0)
    return distances
