"""Tables of numbers as text, fast and exact, for the formats that are text."""

from __future__ import annotations

from itertools import chain
from typing import BinaryIO

import numpy as np

_CHUNK = 1 << 14


def write_rows(stream: BinaryIO, row: str, *columns: np.ndarray) -> None:
    """Write one line a row by a ``%`` format; ``%r`` gives a float's shortest exact text.

    Parameters
    ----------
    row : str
        Format of a row, its line end included.
    columns : arrays (n,) or (n, k)
        Side by side they fill the format.
    """
    n = len(columns[0])
    if n == 0:
        return
    flat = [column.reshape(n, -1) for column in columns]
    for start in range(0, n, _CHUNK):
        lists = [list(zip(*part[start : start + _CHUNK].T.tolist(), strict=True)) for part in flat]
        values = chain.from_iterable(chain.from_iterable(zip(*lists, strict=True)))
        count = len(lists[0])
        stream.write((row * count % tuple(values)).encode("ascii"))
