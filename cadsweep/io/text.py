"""Tables of numbers as text, fast and exact, for the formats that are text; and the way back."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, BinaryIO

import numpy as np

from ..errors import InputError
from ..threads import map_chunks
from . import decimals
from .parsing import floats, whole_numbers

_CHUNK = 1 << 14
_FIELD = re.compile(r"%(?:(?P<exact>\d*)(?P<kind>[dxr])|\.(?P<most>\d+)r|(?P<long>\d+)\.16E)")


def write_rows(stream: BinaryIO, row: str, *columns: np.ndarray) -> None:
    """Write one line a row, by a format.

    Parameters
    ----------
    row : str
        Text of a row, its line end included, with a field a column: ``%d`` and ``%x`` an integer that is not negative,
        ``%8d`` in eight characters; ``%r`` a float as its shortest exact text, ``%.20r`` in twenty characters at the
        most, ``%16r`` in exactly sixteen, rounded where it must be; ``%25.16E`` as in C.
    columns : arrays (n,) or (n, k)
        Side by side they fill the fields.

    Raises
    ------
    InputError
        A number has more digits than its field has room for.
    """
    n = len(columns[0])
    if n == 0:
        return
    pieces = _pieces(row)
    flat = [column.reshape(n, -1) for column in columns]

    def text(rows: slice) -> memoryview:
        fields = (part[rows, k] for part in flat for k in range(part.shape[1]))
        return _table(pieces, fields, rows.stop - rows.start)

    for some in map_chunks(text, n, chunk=_CHUNK):
        stream.write(some)


def write_list(
    stream: BinaryIO,
    field: str,
    values: np.ndarray,
    *,
    per_line: int,
    begin: str = "",
    between: str = "",
    end: str = "\n",
) -> None:
    """Write integers (n,), so many a line by one format, with `begin` before a line, `end` after it, `between` two."""
    whole = len(values) // per_line * per_line
    for rows in (values[:whole].reshape(-1, per_line), values[whole:].reshape(1, -1)):
        if rows.size:
            write_rows(stream, begin + between.join([field] * rows.shape[1]) + end, rows)


def _pieces(row: str) -> list[bytes | dict[str, Any]]:
    found: list[bytes | dict[str, Any]] = []
    place = 0
    for match in _FIELD.finditer(row):
        found += [row[place : match.start()].encode(), match.groupdict()]
        place = match.end()
    return [piece for piece in (*found, row[place:].encode()) if piece]


def _table(pieces: list[bytes | dict[str, Any]], fields: Iterator[np.ndarray], n: int) -> memoryview:
    """The text of some rows."""
    columns: list[np.ndarray] = []
    for piece in pieces:
        if isinstance(piece, bytes):
            columns.append(np.frombuffer(piece, dtype=np.uint8)[:, None])
        else:
            columns.append(_texts(np.ascontiguousarray(next(fields)), **piece))
    ends = np.cumsum([len(column) for column in columns])
    rows = np.empty((n, ends[-1]), dtype=np.uint8)
    for column, end in zip(columns, ends, strict=True):
        rows[:, end - len(column) : end] = column.T
    flat = rows.reshape(-1)
    return flat[flat != 0].data


def _texts(
    values: np.ndarray, *, exact: str | None, kind: str | None, most: str | None, long: str | None
) -> np.ndarray:
    if most:
        return decimals.bounded_texts(values, int(most))
    if long:
        return decimals.scientific_texts(values, int(long))
    width = int(exact or 0)
    if kind == "r":
        return decimals.fitted_texts(values, width) if width else decimals.exact_texts(values)
    try:
        return decimals.whole_texts(values, width=width, base=16 if kind == "x" else 10)
    except OverflowError as error:
        raise InputError(f"a number is too long for the format: {error}; write another format") from None


def parse_numbers(text: bytes | np.ndarray, dtype: Any = np.float64) -> np.ndarray:
    """Numbers (n,) of a text, or its characters (k,) uint8, that has nothing else, between commas, spaces or line ends.

    Raises
    ------
    InputError
        Something is no number.
    """
    try:
        return whole_numbers(text) if np.dtype(dtype).kind == "i" else floats(text)
    except ValueError:
        raise InputError("a number is no number, or the file is cut short") from None
