"""A STEP file's text, checked before OpenCASCADE reads it.

Place in the flow: called by ``files``. OpenCASCADE reads half of a file that is cut off without a
word, takes a number that is none for another, and overflows its stack on an entity that refers to
itself; all three show in the text.

Not checked: whether the text says something sensible; ``step`` asks OpenCASCADE for that.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import scipy

from ...arrays import BoolArray, IntArray
from ...errors import CadError

_NOT_FINITE = re.compile(rb"[(,]\s*[-+]?(?:nan|inf|infinity)\s*[,)]", re.IGNORECASE)
_HUGE = re.compile(rb"[eE]\+?0*(?:[3-9]\d|[1-9]\d{2,})\s*[,)]")
_STRINGS = re.compile(rb"'[^']*'|/\*.*?\*/", re.DOTALL)
_PLAIN = re.compile(rb"#(\d+)\s*=\s*REPRESENTATION\s*\(")
_SPACES = np.frombuffer(b" \t\r\n\v\f", dtype=np.uint8)
_MOST_FOLLOWED = 1 << 27
"""Bytes of a file in which references are followed; a check of more would take longer than it is worth."""
_BEFORE_EXPONENT = tuple(b"%c" % character for character in b"0123456789.")
_MOST_DIGITS = 19
"""Digits from which on an entity has no number that fits in 64 bits."""
_USUAL_DEPTH = 100
"""References from an assembly down to a coordinate: some 20 in files of all programs that were met."""


def check_step_text(path: Path, data: bytes) -> None:
    """Refuse a file that is no whole STEP file, has numbers that are none, or refers in circles.

    Raises
    ------
    CadError
    """
    if b"ISO-10303-21" not in data[:4096]:
        raise CadError(
            f"{path}: this is not a STEP file: it does not begin with ISO-10303-21. "
            "Export STEP (AP203, AP214 or AP242) from its CAD program."
        )
    end = data.rfind(b"END-ISO-10303-21")
    if end < 0 or b"ENDSEC" not in data[max(0, end - 4096) : end]:
        raise CadError(f"{path}: the STEP file is cut off: END-ISO-10303-21 is missing. Export or copy it again.")
    lowered = data.lower()
    if b"nan" in lowered or b"inf" in lowered:
        _refuse_number(path, data, _NOT_FINITE.search(data), "a number that is not finite")
    huge = (found for found in _HUGE.finditer(data) if data[found.start() - 1 : found.start()] in _BEFORE_EXPONENT)
    _refuse_number(path, data, next(huge, None), "a number above 1e30")
    if len(data) <= _MOST_FOLLOWED:
        circle = _circular(data)
        if circle is not None:
            raise CadError(
                f"{path}: the STEP file is damaged: entity #{circle} refers to itself, directly or through others. "
                "Export or copy it again."
            )


def _refuse_number(path: Path, data: bytes, found: re.Match[bytes] | None, what: str) -> None:
    if found is not None:
        line = data.count(b"\n", 0, found.start()) + 1
        raise CadError(f"{path}, line {line}: the file holds {what}. Export it again from its CAD program.")


def numbers_of(data: bytes) -> tuple[IntArray, BoolArray]:
    """Numbers of entities in the order of the text, and which of them begin the entity: an = follows."""
    if b"/*" in data:
        data = _STRINGS.sub(b"''", data)
    text = np.frombuffer(data + b" ", dtype=np.uint8)
    at = np.flatnonzero(text == ord("#"))
    quotes = np.flatnonzero(text == ord("'"))
    quotes = quotes[: len(quotes) // 2 * 2]
    at = at[np.searchsorted(quotes, at) % 2 == 0] + 1  # outside of strings: a quote in one is written twice
    numbers = np.zeros(len(at), dtype=np.int64)
    length = np.zeros(len(at), dtype=np.int64)
    going = np.arange(len(at))
    while len(going):
        digits = text[at[going]] - np.uint8(ord("0"))  # what comes before the digits wraps round to more than 9
        is_digit = digits <= 9
        going = going[is_digit]
        numbers[going] = 10 * numbers[going] + digits[is_digit]
        at[going] += 1
        length[going] += 1
    is_number = (length > 0) & (length < _MOST_DIGITS)
    numbers, at = numbers[is_number], at[is_number]
    going = np.flatnonzero(np.isin(text[at], _SPACES) & (at + 1 < len(text)))
    while len(going):
        at[going] += 1
        going = going[np.isin(text[at[going]], _SPACES) & (at[going] + 1 < len(text))]
    return numbers, text[at] == ord("=")


def _circular(data: bytes) -> int | None:
    """Number of an entity on a circle of references, or None."""
    numbers, begins = numbers_of(data)
    entities = numbers[begins]
    order = np.argsort(entities, kind="stable")
    owners = np.cumsum(begins) - 1
    is_reference = ~begins & (owners >= 0)
    rows, targets = owners[is_reference], numbers[is_reference]
    at = np.minimum(np.searchsorted(entities[order], targets), len(entities) - 1)
    there = entities[order][at] == targets if len(entities) else np.zeros(0, dtype=bool)
    rows, columns = rows[there], order[at[there]]
    own = rows == columns
    if own.any():  # as programs write densities; no shape is made of them
        harmless = np.isin(entities[rows], [int(number) for number in _PLAIN.findall(data)])
        rows, columns = rows[~(own & harmless)], columns[~(own & harmless)]
    entity = on_circle(rows, columns, len(entities))
    return None if entity is None else int(entities[entity])


def on_circle(rows: IntArray, columns: IntArray, n: int) -> int | None:
    """One of n entities on a circle of the references from `rows` (m,) to `columns` (m,), or None.

    References to entities that refer to nothing are taken away, over and over; what is left leads to circles.
    """
    for _ in range(_USUAL_DEPTH):
        refers = np.zeros(n, dtype=bool)
        refers[rows] = True
        kept = refers[columns]
        if kept.all():
            return _walked(rows, columns) if len(rows) else None
        rows, columns = rows[kept], columns[kept]
    # As deep as no model is: a chain of n would take n rounds.
    graph = scipy.sparse.csr_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(n, n))
    _, groups = scipy.sparse.csgraph.connected_components(graph, directed=True, connection="strong")
    circular = (np.bincount(groups)[groups] > 1) | (graph.diagonal() > 0)
    return int(np.flatnonzero(circular)[0]) if circular.any() else None


def _walked(rows: IntArray, columns: IntArray) -> int:
    """Follow references, each to an entity that refers on, until one comes again."""
    following = dict(zip(rows.tolist(), columns.tolist(), strict=True))
    seen: set[int] = set()
    entity = int(rows[0])
    while entity not in seen:
        seen.add(entity)
        entity = following[entity]
    return entity
