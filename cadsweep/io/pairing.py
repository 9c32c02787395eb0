"""Which sides, edges and numbers of a list are one: by chains from the least corner, and by a table of keys.

Place in the flow: for formats that ask of every hexahedron what is beyond its sides (:mod:`.grids`, :mod:`.foam`), and
for :mod:`.places`. Sorting all of them costs several times as much: chains are two or three links long, and numbers
that come one after the other lie in memory one beside the other.
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray
from ..cells import HEX_EDGES, HEX_FACES
from ..compiled import compiled
from ..errors import InputError


def neighbours(hexes: IntArray, n_points: int) -> IntArray:
    """The side (6 m,) beyond each side of the hexahedra, ``6 h + row of HEX_FACES``; -1 where there is none.

    Raises
    ------
    InputError
        Three hexahedra have one side.
    """
    across, fault = _across(np.ascontiguousarray(hexes), HEX_FACES, n_points)
    if fault >= 0:
        raise InputError("three hexahedra have one side: no file of structured blocks, or of faces, holds such a mesh")
    return across


def edge_codes(hexes: IntArray, n_points: int) -> tuple[IntArray, IntArray]:
    """A number (m, 12) of every edge, of ``HEX_EDGES``, from 0; and how many hexahedra (e,) have each."""
    codes, counts = _edge_codes(np.ascontiguousarray(hexes), HEX_EDGES, n_points)
    return codes, counts


def first_rows(rows: np.ndarray) -> IntArray:
    """Where each row (n, k), of numbers of eight bytes, comes first, bit for bit."""
    bits = np.ascontiguousarray(rows).view(np.uint64)
    keys = np.zeros(len(bits), dtype=np.uint64)
    for column in bits.T:
        keys = mix(keys + column)
    first = _first_equal(keys)
    if (bits[first] != bits).any():  # two rows with one key
        _, kept, number = np.unique(bits, axis=0, return_index=True, return_inverse=True)
        first = kept[number.reshape(-1)]
    return first


def mix(values: np.ndarray) -> np.ndarray:
    """Numbers (n,) uint64 whose every bit hangs on every bit of the value (Steele, Lea, Flood, SplitMix64, 2014)."""
    values = values + np.uint64(0x9E3779B97F4A7C15)
    values = (values ^ (values >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    values = (values ^ (values >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return values ^ (values >> np.uint64(31))


@compiled(cache=True, nogil=True)
def _across(hexes, faces, n_points):  # type: ignore[no-untyped-def]
    m = len(hexes)
    across = np.full(6 * m, -1, dtype=np.int64)
    last = np.full(n_points, -1, dtype=np.int64)
    before = np.empty(6 * m, dtype=np.int64)
    opposite = np.empty((6 * m, 3), dtype=np.uint32)  # of the least corner: the one across, and the others ascending
    for h in range(m):
        for s in range(6):
            side = 6 * h + s
            k = 0
            for j in range(1, 4):
                k = j if hexes[h, faces[s, j]] < hexes[h, faces[s, k]] else k
            least = hexes[h, faces[s, k]]
            a, b = hexes[h, faces[s, (k + 1) % 4]], hexes[h, faces[s, (k + 3) % 4]]
            c, a, b = np.uint32(hexes[h, faces[s, (k + 2) % 4]]), np.uint32(min(a, b)), np.uint32(max(a, b))
            opposite[side, 0], opposite[side, 1], opposite[side, 2] = c, a, b
            other = last[least]
            while other >= 0 and not (opposite[other, 0] == c and opposite[other, 1] == a and opposite[other, 2] == b):
                other = before[other]
            if other < 0:
                before[side] = last[least]
                last[least] = side
            elif across[other] >= 0:
                return across, h
            else:
                across[side], across[other] = other, side
    return across, -1


@compiled(cache=True, nogil=True)
def _edge_codes(hexes, edges, n_points):  # type: ignore[no-untyped-def]
    m, n = len(hexes), 0
    codes = np.empty((m, 12), dtype=np.int64)
    last = np.full(n_points, -1, dtype=np.int64)
    before, ends = np.empty(12 * m, dtype=np.int64), np.empty(12 * m, dtype=np.uint32)
    counts = np.zeros(12 * m, dtype=np.int64)
    for h in range(m):
        for e in range(12):
            a, b = hexes[h, edges[e, 0]], hexes[h, edges[e, 1]]
            least, greatest = min(a, b), max(a, b)
            code = last[least]
            while code >= 0 and np.int64(ends[code]) != greatest:
                code = before[code]
            if code < 0:
                code = n
                ends[n], before[n] = greatest, last[least]
                last[least] = n
                n += 1
            counts[code] += 1
            codes[h, e] = code
    return codes, counts[:n].copy()


@compiled(cache=True, nogil=True)
def _first_equal(keys):  # type: ignore[no-untyped-def]
    n = len(keys)
    size = 16
    while size < 2 * n:
        size *= 2
    table = np.full(size, -1, dtype=np.int64)
    found = np.empty(n, dtype=np.int64)
    for k in range(n):
        place = np.int64(keys[k] & np.uint64(size - 1))
        while table[place] >= 0 and keys[table[place]] != keys[k]:
            place = (place + 1) & (size - 1)
        if table[place] < 0:
            table[place] = k
        found[k] = table[place]
    return found
