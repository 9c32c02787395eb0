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

from ...arrays import IntArray
from ...errors import CadError

_NOT_FINITE = re.compile(rb"[(,]\s*[-+]?(?:nan|inf|infinity)\s*[,)]", re.IGNORECASE)
_HUGE = re.compile(rb"[\d.][eE]\+?(?:[3-9]\d|\d{3,})\s*[,)]")
_STRINGS = re.compile(rb"'[^']*'|/\*.*?\*/", re.DOTALL)
_NUMBERS = re.compile(rb"#(\d+)(\s*=)?")
"""Numbers of entities: where they begin, with what follows up to the next, and where they are referred to."""
_MOST_FOLLOWED = 1 << 27
"""Bytes of a file in which references are followed; a check of more would take longer than it is worth."""
_USUAL_DEPTH = 100
"""References from an assembly down to a coordinate: some 20 in files of all programs that were met."""


def check_step_text(path: Path, data: bytes) -> None:
    """Refuse a file that is no whole STEP file, has numbers that are none, or refers in circles.

    Raises
    ------
    CadError
    """
    head, tail = data[:4096], data[-4096:]
    if b"ISO-10303-21" not in head:
        raise CadError(
            f"{path}: this is not a STEP file: it does not begin with ISO-10303-21. "
            "Export STEP (AP203, AP214 or AP242) from its CAD program."
        )
    if b"END-ISO-10303-21" not in tail or b"ENDSEC" not in tail:
        raise CadError(f"{path}: the STEP file is cut off: END-ISO-10303-21 is missing. Export or copy it again.")
    for pattern, what in ((_NOT_FINITE, "a number that is not finite"), (_HUGE, "a number above 1e30")):
        found = pattern.search(data)
        if found:
            line = data.count(b"\n", 0, found.start()) + 1
            raise CadError(f"{path}, line {line}: the file holds {what}. Export it again from its CAD program.")
    if len(data) <= _MOST_FOLLOWED:
        circle = _circular(_STRINGS.sub(b"''", data))
        if circle is not None:
            raise CadError(
                f"{path}: the STEP file is damaged: entity #{circle} refers to itself, directly or through others. "
                "Export or copy it again."
            )


def _circular(data: bytes) -> int | None:
    """Number of an entity on a circle of references, or None."""
    words = _NUMBERS.findall(data)
    numbers = np.array([word for word, _ in words], dtype=bytes).astype(np.int64)
    begins = np.array([bool(equals) for _, equals in words], dtype=bool)
    entities = numbers[begins]
    order = np.argsort(entities, kind="stable")
    owners = np.cumsum(begins) - 1
    is_reference = ~begins & (owners >= 0)
    rows, targets = owners[is_reference], numbers[is_reference]
    at = np.minimum(np.searchsorted(entities[order], targets), len(entities) - 1)
    there = entities[order][at] == targets if len(entities) else np.zeros(0, dtype=bool)
    entity = on_circle(rows[there], order[at[there]], len(entities))
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
