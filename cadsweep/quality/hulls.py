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

MOST_HALVINGS = 6
MOST_PIECES = 256
"""Pairs of pieces of one pair of quads that may be in doubt at once."""

CHUNK = 64
"""Pairs that are looked at together."""

_SIDES = tuple(combinations(range(4), 2))
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
    found, places = [np.zeros((0, 2), dtype=np.int64)], [np.zeros((0, 3))]
    doubtful = []
    for first in range(0, len(pairs), 16 * CHUNK):
        some = pairs[first : first + 16 * CHUNK]
        doubtful.append(some[~hulls_apart(corners[some[:, 0]], corners[some[:, 1]], tolerance)])
    pairs = np.concatenate(doubtful) if doubtful else pairs
    for first in range(0, len(pairs), CHUNK):
        some = pairs[first : first + CHUNK]
        one, other = corners[some[:, 0]], corners[some[:, 1]]
        where, crossing = _crossing_places(one, other, tolerance, _back_to_back(one, other, close))
        found.append(some[crossing])
        places.append(where)
        if sum(map(len, found)) >= most:
            break
    return np.concatenate(found), np.concatenate(places)


def hulls_apart(one: FloatArray, other: FloatArray, tolerance: float) -> np.ndarray:
    """Whether the hulls of corners (p, 4, 3) and (p, 4, 3) overlap by the tolerance at most, (p,) bool.

    The axes that are tried are complete for tetrahedra, and for flat quads.
    """
    origin = one[:, :1]
    one, other = one - origin, other - origin
    apart = np.zeros(len(one), dtype=np.bool_)
    left = np.arange(len(one))
    for axes in _axes(one, other):
        m = axes(left)
        lengths = np.sqrt(np.sum(m * m, axis=1))
        shadows = [np.einsum("pix,px->pi", quads[left], m) for quads in (one, other)]
        low, high = ([s.min(axis=1) for s in shadows], [s.max(axis=1) for s in shadows])
        overlap = np.minimum(high[0] - low[1], high[1] - low[0])
        parted = (overlap <= tolerance * lengths) & (lengths > 0)
        apart[left[parted]] = True
        left = left[~parted]
        if not len(left):
            break
    return apart


def _axes(one: FloatArray, other: FloatArray):  # type: ignore[no-untyped-def]
    """Functions that give the axes (p, 3) of some rows: those first that part most."""
    sides = [[quads[:, j] - quads[:, i] for i, j in _SIDES] for quads in (one, other)]
    normals = [_cross(own[1], own[4]) for own in sides]

    def across(u: FloatArray, v: FloatArray):  # type: ignore[no-untyped-def]
        return lambda rows: _cross(u[rows], v[rows])

    yield lambda rows: other[rows].sum(axis=1) - one[rows].sum(axis=1)
    for normal in normals:
        yield lambda rows, normal=normal: normal[rows]
    for own, normal in zip(sides, normals, strict=True):  # sides of flat quads
        for side in own:
            yield across(normal, side)
    for own in sides:  # faces of the tetrahedra
        for u, v in combinations(own, 2):
            yield across(u, v)
    for u, v in product(*sides):
        yield across(u, v)


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    """Cross products of rows; ``numpy.cross`` takes several times as long on few of them."""
    return np.stack(
        [
            u[:, 1] * v[:, 2] - u[:, 2] * v[:, 1],
            u[:, 2] * v[:, 0] - u[:, 0] * v[:, 2],
            u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0],
        ],
        axis=1,
    )


def _crossing_places(
    one: FloatArray, other: FloatArray, tolerance: float, harmless: np.ndarray
) -> tuple[FloatArray, np.ndarray]:
    """Where (c, 3) pairs cross, and which rows (c,) those are."""
    owner = np.flatnonzero(~harmless)
    first, second = one[owner], other[owner]
    lost: dict[int, FloatArray] = {}
    for level in range(MOST_HALVINGS + 1):
        doubt = np.flatnonzero(~hulls_apart(first, second, tolerance))
        owner, first, second = owner[doubt], first[doubt], second[doubt]
        rows, counts = np.unique(owner, return_counts=True)
        given_up = rows if level == MOST_HALVINGS else rows[counts > MOST_PIECES]
        for row in given_up.tolist():
            at = int(np.flatnonzero(owner == row)[0])
            lost[row] = (first[at].mean(axis=0) + second[at].mean(axis=0)) / 2
        if level == MOST_HALVINGS or not len(owner):
            break
        going = ~np.isin(owner, given_up)
        owner = np.repeat(owner[going], 16)
        first = np.repeat(_quarters(first[going]), 4, axis=1).reshape(-1, 4, 3)
        second = np.tile(_quarters(second[going]), (1, 4, 1, 1)).reshape(-1, 4, 3)
    rows_found = np.array(sorted(lost), dtype=np.int64)
    return np.array([lost[row] for row in rows_found.tolist()]).reshape(-1, 3), rows_found


def _quarters(quads: FloatArray) -> FloatArray:
    """The four pieces (q, 4, 4, 3) of bilinear quads (q, 4, 3), cut in the middle of their parameters."""
    center = quads.mean(axis=1)
    after = 0.5 * (quads + np.roll(quads, -1, axis=1))
    before = 0.5 * (quads + np.roll(quads, 1, axis=1))
    pieces = [np.stack([quads[:, i], after[:, i], center, before[:, i]], axis=1) for i in range(4)]
    return np.stack(pieces, axis=1)


def _back_to_back(one: FloatArray, other: FloatArray, close: float) -> np.ndarray:
    """Whether quads have the same corners the other way round, as the two sides of a contact do."""
    same = np.zeros(len(one), dtype=np.bool_)
    for shift in range(4):
        turned = other[:, (shift - np.arange(4)) % 4]
        same |= np.all(np.linalg.norm(one - turned, axis=2) <= close, axis=1)
    return same
