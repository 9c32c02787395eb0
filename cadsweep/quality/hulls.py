"""Do two bilinear quads cross? Separating axes between the hulls of their pieces, for the few pairs that are in doubt.

Place in the flow: :mod:`cadsweep.quality.overlap` sends the pairs here that are near each other and not plainly side
by side.

Method. A bilinear quad lies in the hull of its corners. Where two hulls are not apart, both quads are cut in four and
the pieces asked again: hulls of pieces lie ever closer on the quads, also beside an edge or a corner in common. Pieces
that are not apart after `MOST_HALVINGS` cuts, or of which there are more than `MOST_PIECES`, cannot be told apart.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numba import njit

from ..arrays import FloatArray, IntArray

_njit = njit(cache=True, error_model="numpy", nogil=True)

MOST_HALVINGS = 6
"""Cuts in four: pieces are then a 64th of the quad long, and lie 1/4096 of its warp off it."""
MOST_PIECES = 256
"""Pairs of pieces of one pair of quads, all of one size, that may be in doubt; 4 x 64 lie beside a common edge."""

_SIDES = np.array(list(combinations(range(4), 2)), dtype=np.int64)
"""Edges and diagonals of four corners; rows 1 and 4 are the diagonals of the quad."""


def crossing_pairs(
    corners: FloatArray, pairs: IntArray, *, tolerance: float, close: float, most: int
) -> tuple[IntArray, FloatArray]:
    """Find out which pairs of quads cross.

    Parameters
    ----------
    corners : (q, 4, 3) float64
    pairs : (p, 2) int64
    tolerance : float
        Overlap up to which hulls are apart.
    close : float
        Corners that are nearer than this are in one place: quads back to back with the same corners do not cross.
    most : int
        Crossing pairs after which no more are looked for.

    Returns
    -------
    pairs : (c, 2) int64
    places : (c, 3) float64
        A point where each crosses.
    """
    rows = np.empty(len(pairs), dtype=np.int64)
    places = np.empty((len(pairs), 3))
    n = _find_crossing(corners, pairs, tolerance, close, most, rows, places)
    return pairs[rows[:n]], places[:n].copy()


@_njit
def _find_crossing(corners, pairs, tolerance, close, most, rows, places):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Fill rows (p,) and places (p, 3) of the pairs that cross, and return how many these are."""
    # Depth first, at most 15 pieces wait at each depth beside the one that is asked.
    depths = np.empty(16 * (MOST_HALVINGS + 1), dtype=np.int64)
    waiting = np.empty((16 * (MOST_HALVINGS + 1), 2, 4, 3))
    count = 0
    for row in range(len(pairs)):
        one, other = corners[pairs[row, 0]], corners[pairs[row, 1]]
        if hulls_apart(one, other, tolerance) or _back_to_back(one, other, close):
            continue
        if _cross(one, other, tolerance, depths, waiting, places[count]):
            rows[count] = row
            count += 1
            if count >= most:
                break
    return count


@_njit
def _cross(one, other, tolerance, depths, waiting, place):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Whether pieces of two quads cannot be told apart; `place` (3,) is then where."""
    in_doubt = np.zeros(MOST_HALVINGS + 1, dtype=np.int64)
    first, second = np.empty((4, 4, 3)), np.empty((4, 4, 3))
    depths[0] = 0
    waiting[0, 0], waiting[0, 1] = one, other
    top = 1
    while top:
        top -= 1
        depth = depths[top]
        in_doubt[depth] += 1
        if depth == MOST_HALVINGS or in_doubt[depth] > MOST_PIECES:
            for x in range(3):
                place[x] = (waiting[top, 0, :, x].sum() + waiting[top, 1, :, x].sum()) / 8
            return True
        _cut_in_four(waiting[top, 0], first)
        _cut_in_four(waiting[top, 1], second)
        for i in range(4):
            for j in range(4):
                if not hulls_apart(first[i], second[j], tolerance):
                    depths[top] = depth + 1
                    waiting[top, 0], waiting[top, 1] = first[i], second[j]
                    top += 1
    return False


@_njit
def _cut_in_four(quad, pieces):  # type: ignore[no-untyped-def]
    """Fill pieces (4, 4, 3) of a bilinear quad (4, 3), cut in the middle of its parameters."""
    for x in range(3):
        center = (quad[0, x] + quad[1, x] + quad[2, x] + quad[3, x]) / 4
        for i in range(4):
            pieces[i, 0, x] = quad[i, x]
            pieces[i, 1, x] = 0.5 * (quad[i, x] + quad[(i + 1) % 4, x])
            pieces[i, 2, x] = center
            pieces[i, 3, x] = 0.5 * (quad[i, x] + quad[(i + 3) % 4, x])


@_njit
def _back_to_back(one, other, close):  # type: ignore[no-untyped-def]
    """Whether quads have the same corners the other way round, as the two sides of a contact do."""
    for shift in range(4):
        same = True
        for i in range(4):
            square = 0.0
            for x in range(3):
                square += (one[i, x] - other[(shift - i) % 4, x]) ** 2
            same = same and square <= close * close
        if same:
            return True
    return False


@_njit
def hulls_apart(one, other, tolerance):  # type: ignore[no-untyped-def]
    """Whether the hulls of corners (4, 3) and (4, 3) overlap by the tolerance at most.

    The axes that are tried are complete for tetrahedra, and for flat quads: those first that part most.
    """
    m = np.empty(3)
    for x in range(3):
        m[x] = other[:, x].sum() - one[:, x].sum()
    if _parted(one, other, m, tolerance):
        return True
    u, v = np.empty((6, 3)), np.empty((6, 3))
    for k in range(6):
        i, j = _SIDES[k]
        u[k] = one[j] - one[i]
        v[k] = other[j] - other[i]
    normals = np.empty((2, 3))
    _set_across(u[1], u[4], normals[0])
    _set_across(v[1], v[4], normals[1])
    return (
        _parted(one, other, normals[0], tolerance)
        or _parted(one, other, normals[1], tolerance)
        or _parted_across(one, other, normals[:1], u, tolerance)  # sides of flat quads
        or _parted_across(one, other, normals[1:], v, tolerance)
        or _parted_across(one, other, u, u, tolerance)  # faces of the tetrahedra
        or _parted_across(one, other, v, v, tolerance)
        or _parted_across(one, other, u, v, tolerance)
    )


@_njit
def _parted_across(one, other, u, v, tolerance):  # type: ignore[no-untyped-def]
    """Whether an axis across one of the vectors u (a, 3) and one of v (b, 3) parts two quads."""
    m = np.empty(3)
    for k in range(len(u)):
        for n in range(len(v)):
            _set_across(u[k], v[n], m)
            if _parted(one, other, m, tolerance):
                return True
    return False


@_njit
def _set_across(u, v, m):  # type: ignore[no-untyped-def]
    """Set m (3,) to the cross product of u and v."""
    m[0] = u[1] * v[2] - u[2] * v[1]
    m[1] = u[2] * v[0] - u[0] * v[2]
    m[2] = u[0] * v[1] - u[1] * v[0]


@_njit
def _parted(one, other, m, tolerance):  # type: ignore[no-untyped-def]
    """Whether the shadows of two quads on an axis overlap by the tolerance at most; no axis parts nothing."""
    square = m[0] * m[0] + m[1] * m[1] + m[2] * m[2]
    if square <= 0.0:
        return False
    low_one, high_one, low_other, high_other = np.inf, -np.inf, np.inf, -np.inf
    for i in range(4):
        s, t = 0.0, 0.0
        for x in range(3):  # from a corner on: coordinates far from the origin would lose digits
            s += (one[i, x] - one[0, x]) * m[x]
            t += (other[i, x] - one[0, x]) * m[x]
        low_one, high_one = min(low_one, s), max(high_one, s)
        low_other, high_other = min(low_other, t), max(high_other, t)
    return min(high_one - low_other, high_other - low_one) <= tolerance * np.sqrt(square)
