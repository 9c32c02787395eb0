"""What arrays are called in signatures, sets of ids, and matrices by rows; imported by everybody, imports nobody."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import scipy

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]


_DENSE = 4
"""Room between the least and the greatest of some ids, over how many there are, up to which it is marked."""


def distinct(ids: IntArray) -> IntArray:
    """The different values of an array of integers, ascending.

    ``numpy.unique`` gives the same, from a hash table since version 2.3: of 400,000 node numbers in 25 times as long.
    """
    if ids.size and ids.dtype.kind == "i":
        low, high = int(ids.min()), int(ids.max())
        if high - low < _DENSE * ids.size:  # as numbers of nodes mostly are: marking takes a fraction of sorting
            there = np.zeros(high - low + 1, dtype=np.bool_)
            there[ids - low if low else ids] = True
            return (np.flatnonzero(there) + low).astype(ids.dtype, copy=False)
    ordered = np.sort(ids, axis=None)
    new = np.ones(len(ordered), dtype=np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=new[1:])
    return ordered[new]


def limits(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least and greatest coordinates (d,) of points (n, d): ``points.min(axis=0)`` takes twenty times as long."""
    columns = np.ascontiguousarray(points.T)
    return columns.min(axis=1), columns.max(axis=1)


def others(n: int, ids: IntArray) -> IntArray:
    """The numbers below `n` that are not among some of them, ascending."""
    left = np.ones(n, dtype=np.bool_)
    left[ids] = False
    return np.flatnonzero(left)


def cross_product(one: FloatArray, other: FloatArray) -> FloatArray:
    """The cross product of two vectors (3,): ``numpy.cross`` takes ten times as long for them."""
    (a, b, c), (d, e, f) = one.tolist(), other.tolist()
    return np.array([b * f - c * e, c * d - a * f, a * e - b * d])


def small_ints(ids: npt.NDArray[np.signedinteger]) -> npt.NDArray[np.signedinteger]:
    """Numbers in half the room, where they fit: for files."""
    return ids.astype(np.int32) if ids.size == 0 or ids.max() < 2**31 else ids


def sparse(rows: Sequence[Mapping[int, float]], n: int) -> scipy.sparse.csr_array:
    """A matrix (k, n) of rows that know their columns."""
    entries = [(r, c, v) for r, row in enumerate(rows) for c, v in row.items()]
    r, c, v = (np.array(x) for x in zip(*entries, strict=True))
    return scipy.sparse.csr_array((v, (r, c)), shape=(len(rows), n))
