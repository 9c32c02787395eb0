"""Sides of hexes: the quads that a (hex, side) pair stands for, of any order, and the pair of a given quad."""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray
from ..cells import HEX_EDGES, HEX_FACES
from ..errors import InputError
from .pairing import mix

_CHUNK = 1 << 14


def _full_sides() -> IntArray:
    middle = {frozenset(edge): 8 + j for j, edge in enumerate(HEX_EDGES.tolist())}
    centres = {
        (0, 3, 4, 7): 20,
        (1, 2, 5, 6): 21,
        (0, 1, 4, 5): 22,
        (2, 3, 6, 7): 23,
        (0, 1, 2, 3): 24,
        (4, 5, 6, 7): 25,
    }
    rows = []
    for face in HEX_FACES.tolist():
        edges = [middle[frozenset((face[k], face[(k + 1) % 4]))] for k in range(4)]
        rows.append([*face, *edges, centres[tuple(sorted(face))]])
    return np.array(rows, dtype=np.int64)


SIDES = _full_sides()
"""Local nodes of the six outward sides: corners, middles of the edges, centre; the order of ``HEX_FACES``."""


def quads_of_sides(hexes: IntArray, of: IntArray, sides: IntArray) -> IntArray:
    """Outward quads (q, 4 | 8 | 9) of the sides of hexes (m, 8 | 20 | 27)."""
    width = {8: 4, 20: 8, 27: 9}[hexes.shape[1]]
    return hexes[np.asarray(of)[:, None], SIDES[np.asarray(sides), :width]]


def find_sides(hexes: IntArray, quads: IntArray, n_points: int) -> tuple[IntArray, IntArray]:
    """Find the hex, and its side, that each quad bounds.

    Of two hexes that share a quad the one for which the quad points outward is taken.

    Parameters
    ----------
    hexes : (m, 8 | 20 | 27) int64
    quads : (q, 4 | 8 | 9) int64
    n_points : int

    Returns
    -------
    (q,) int64, (q,) int64
        Hex ids, and rows of :data:`~cadsweep.cells.HEX_FACES`.

    Raises
    ------
    InputError
        A quad is a side of no hex.
    """
    marked = np.zeros(n_points, dtype=bool)
    marked[quads[:, :4]] = True
    # Only hexes with four marked corners can own a quad: a thin shell of the mesh.
    candidates = np.flatnonzero(_count_marked(hexes, marked) >= 4)
    shell = hexes.take(candidates, axis=0)[:, :8]
    sides = _marked_sides(shell, marked)
    corners = shell.take(8 * (sides[:, None] // 6) + HEX_FACES.take(sides % 6, axis=0))
    _, codes = corner_keys(np.concatenate([quads[:, :4], corners]))
    wanted, offered = codes[: len(quads)], codes[len(quads) :]
    best = np.full(int(np.max(codes, initial=-1)) + 1, -1, dtype=np.int64)
    best[offered] = np.arange(len(sides))
    found = best[wanted]
    if (found < 0).any():
        raise InputError(f"boundary quad {tuple(quads[np.argmax(found < 0), :4])} is a side of no hex")
    # Where two hexes offer the quad, the one that sees it from inside is right.
    wrong = np.flatnonzero(~_turn_alike(corners[found], quads[:, :4]))
    if len(wrong):
        order = np.argsort(offered, kind="stable")
        first = np.searchsorted(offered[order], wanted[wrong])
        for rank in (0, 1):
            other = order[np.minimum(first + rank, len(order) - 1)]
            fits = (offered[other] == wanted[wrong]) & _turn_alike(corners[other], quads[wrong, :4])
            found[wrong[fits]] = other[fits]
    return candidates[sides[found] // 6], sides[found] % 6


def count_users(hexes: IntArray, quads: IntArray, n_points: int) -> IntArray:
    """How many hexes (q,) have each of the quads (q, 4 or more) as a side: 1 on the boundary, 2 inside."""
    marked = np.zeros(n_points, dtype=bool)
    marked[quads[:, :4]] = True
    shell = hexes[_count_marked(hexes, marked) >= 4, :8]
    sides = _marked_sides(shell, marked)
    corners = shell[sides[:, None] // 6, HEX_FACES[sides % 6]]
    _, codes = corner_keys(np.concatenate([quads[:, :4], corners]))
    uses = np.bincount(codes[len(quads) :], minlength=int(np.max(codes, initial=-1)) + 1)
    return uses[codes[: len(quads)]]


def _marked_sides(hexes: IntArray, marked: np.ndarray) -> IntArray:
    """Sides all of whose corners are marked, as ``6 * hex + row of HEX_FACES``."""
    corners = marked.take(hexes).T
    return np.flatnonzero(np.stack([np.logical_and.reduce(corners[face]) for face in HEX_FACES], axis=1))


def _turn_alike(some: IntArray, others: IntArray) -> np.ndarray:
    """Whether quads of the same corners turn the same way: after the same corner comes the same corner."""
    place = (some == others[:, :1]).argmax(axis=1)
    return some[np.arange(len(some)), (place + 1) % 4] == others[:, 1]


def _count_marked(hexes: IntArray, marked: np.ndarray) -> np.ndarray:
    """Number of marked corners of each hex; in chunks, which stay in the cache."""
    counts = np.empty(len(hexes), dtype=np.uint8)
    for start in range(0, len(hexes), _CHUNK):
        corners = np.ascontiguousarray(marked[hexes[start : start + _CHUNK, :8]])
        # Eight bytes of 0 or 1 are added by one multiplication: their sum ends in the highest byte.
        packed = corners.view(np.uint64)[:, 0]
        counts[start : start + _CHUNK] = (packed * np.uint64(0x0101010101010101)) >> np.uint64(56)
    return counts


def corner_keys(corners: IntArray) -> tuple[IntArray, IntArray]:
    """Give equal codes to quads with the same corners, however they are turned.

    Returns
    -------
    (u,) int64, (n,) int64
        The first quad of each code, and the code of every quad; codes ascend with the sorted corners.
    """
    if len(corners) == 0:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    columns = _sorted_columns(corners)
    if int(np.max(columns[3])) < 1 << 31:  # two ids a key sort twice as fast as one
        columns = [(columns[0] << 32) | columns[1], (columns[2] << 32) | columns[3]]
    order = np.lexsort(columns[::-1])
    new = np.zeros(len(corners), dtype=bool)
    new[:1] = True
    for column in (one.take(order) for one in columns):
        new[1:] |= column[1:] != column[:-1]
    codes = np.empty(len(corners), dtype=np.int64)
    codes[order] = np.cumsum(new) - 1
    return order[new], codes


def cyclic(corners: IntArray) -> IntArray:
    """Turn each quad so that its least corner comes first; the direction stays."""
    first = corners.argmin(axis=1)
    return corners[np.arange(len(corners))[:, None], (first[:, None] + np.arange(4)) % 4]


def _sorted_columns(corners: IntArray) -> list[IntArray]:
    """The four columns of quads whose corners are sorted: ``numpy.sort`` takes four times as long for rows of four."""
    a, b, c, d = np.ascontiguousarray(corners.T)
    a, b, c, d = np.minimum(a, b), np.maximum(a, b), np.minimum(c, d), np.maximum(c, d)
    least, b, c, greatest = np.minimum(a, c), np.minimum(b, d), np.maximum(a, c), np.maximum(b, d)
    return [least, np.minimum(b, c), np.maximum(b, c), greatest]


def unnamed_sides(hexes: IntArray, quads: IntArray, n_points: int) -> IntArray:
    """Sides (s, 4) that one hex has, and none of the quads (q, 4 or more) is.

    Whether there are any is seen first without sorting: of all sides, and of the quads with one hex, numbers are made
    of their corners and folded by exclusive or, in which what two hexes share vanishes.
    """
    outer = quads[count_users(hexes, quads, n_points) == 1] if len(quads) else quads
    mixed = mix(np.arange(n_points, dtype=np.uint64))
    folded = np.bitwise_xor.reduce(_keys(mixed, outer), initial=np.uint64(0))
    for face in HEX_FACES:
        folded ^= np.bitwise_xor.reduce(_keys(mixed, hexes[:, face]))
    if folded == 0:
        return np.empty((0, 4), dtype=np.int64)
    sides = hexes[:, HEX_FACES].reshape(-1, 4)
    first, codes = corner_keys(np.concatenate([sides, quads[:, :4]]))
    counts = np.bincount(codes[: len(sides)], minlength=len(first))
    counts[codes[len(sides) :]] = 0
    return sides[np.sort(first[counts == 1])]


def _keys(mixed: np.ndarray, corners: IntArray) -> np.ndarray:
    """A number of every quad (q, 4 or more), in whatever order its corners come; two have one by chance of 2**-64."""
    sums = mixed[corners[:, 0]]
    for k in (1, 2, 3):
        sums += mixed[corners[:, k]]
    return mix(sums)
