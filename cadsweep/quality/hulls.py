"""Do two bilinear quads cross? Separating axes between the hulls of their pieces, for the few pairs that are in doubt.

Place in the flow: :mod:`cadsweep.quality.overlap` sends the pairs here that are near each other and not plainly side
by side.

Method. A bilinear quad lies in the hull of its corners. Where two hulls are not apart, both quads are cut in four and
the pieces asked again: hulls of pieces lie ever closer on the quads, also beside an edge or a corner in common. Pieces
that are not apart after `MOST_HALVINGS` cuts, or of which there are more than `MOST_PIECES`, cannot be told apart.
"""

from __future__ import annotations

from itertools import combinations, product

import numpy as np

from ..arrays import FloatArray, IntArray
from ..compiled import compiled

_compiled = compiled(cache=True, error_model="numpy", nogil=True)

MOST_HALVINGS = 6
"""Cuts in four: pieces are then a 64th of the quad long, and lie 1/4096 of its warp off it."""
MOST_PIECES = 256
"""Pairs of pieces of one pair of quads, all of one size, that may be in doubt; 4 x 64 lie beside a common edge."""

_SIDES = np.array(list(combinations(range(4), 2)), dtype=np.int64)
"""Edges and diagonals of four corners; rows 1 and 4 are the diagonals of the quad."""

_AXES = np.array(
    [(1, 4), (7, 10)]  # the normals, which become vectors 12 and 13
    + [(12, k) for k in range(6)]  # across the sides of flat quads
    + [(13, k) for k in range(6, 12)]
    + list(combinations(range(6), 2))  # faces of the tetrahedra
    + list(combinations(range(6, 12), 2))
    + list(product(range(6), range(6, 12))),
    dtype=np.int64,
)
"""Pairs of vectors whose cross products are axes: 0 to 5 are sides of one quad, 6 to 11 of the other."""


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


@_compiled
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


@_compiled
def _cross(one, other, tolerance, depths, waiting, place):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Whether pieces of two quads cannot be told apart; `place` (3,) is then where."""
    in_doubt = np.zeros(MOST_HALVINGS + 1, dtype=np.int64)
    first, second = np.empty((4, 4, 3)), np.empty((4, 4, 3))
    depths[0] = 0
    _put(one, other, waiting, 0)
    top = 1
    while top:
        top -= 1
        depth = depths[top]
        in_doubt[depth] += 1
        if depth == MOST_HALVINGS or in_doubt[depth] > MOST_PIECES:
            for x in range(3):
                place[x] = 0.0
                for i in range(4):
                    place[x] += (waiting[top, 0, i, x] + waiting[top, 1, i, x]) / 8
            return True
        _cut_in_four(waiting[top, 0], first)
        _cut_in_four(waiting[top, 1], second)
        for i in range(4):
            for j in range(4):
                if not hulls_apart(first[i], second[j], tolerance):
                    depths[top] = depth + 1
                    _put(first[i], second[j], waiting, top)
                    top += 1
    return False


@_compiled
def _put(one, other, waiting, row):  # type: ignore[no-untyped-def]
    """Set a row of waiting (w, 2, 4, 3); spelled out, since numba takes seconds to compile such an assignment."""
    for i in range(4):
        for x in range(3):
            waiting[row, 0, i, x] = one[i, x]
            waiting[row, 1, i, x] = other[i, x]


@_compiled
def _cut_in_four(quad, pieces):  # type: ignore[no-untyped-def]
    """Fill pieces (4, 4, 3) of a bilinear quad (4, 3), cut in the middle of its parameters."""
    for x in range(3):
        center = (quad[0, x] + quad[1, x] + quad[2, x] + quad[3, x]) / 4
        for i in range(4):
            pieces[i, 0, x] = quad[i, x]
            pieces[i, 1, x] = 0.5 * (quad[i, x] + quad[(i + 1) % 4, x])
            pieces[i, 2, x] = center
            pieces[i, 3, x] = 0.5 * (quad[i, x] + quad[(i + 3) % 4, x])


@_compiled
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


@_compiled
def hulls_apart(one, other, tolerance):  # type: ignore[no-untyped-def]
    """Whether the hulls of corners (4, 3) and (4, 3) overlap by the tolerance at most.

    The axes that are tried are complete for tetrahedra, and for flat quads: those first that part most.
    """
    m, vectors = np.empty(3), np.empty((14, 3))
    for x in range(3):
        m[x] = 0.0
        for i in range(4):
            m[x] += other[i, x] - one[i, x]
        for k in range(6):
            i, j = _SIDES[k, 0], _SIDES[k, 1]
            vectors[k, x] = one[j, x] - one[i, x]
            vectors[6 + k, x] = other[j, x] - other[i, x]
    for axis in range(-1, len(_AXES)):
        if axis >= 0:
            a, b = _AXES[axis, 0], _AXES[axis, 1]
            for x in range(3):
                y, z = (x + 1) % 3, (x + 2) % 3
                m[x] = vectors[a, y] * vectors[b, z] - vectors[a, z] * vectors[b, y]
                if axis <= 1:
                    vectors[12 + axis, x] = m[x]
        if _parted(one, other, m, tolerance):
            return True
    return False


@_compiled
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
