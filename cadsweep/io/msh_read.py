"""Reading gmsh's MSH: 4.1 and 2.2, text and binary.

Place in the flow: :mod:`cadsweep.io.msh` hands over the whole file. Only numpy reads it, so a damaged file ends as an
:class:`~cadsweep.errors.InputError`, never as a crash.

Not handled: periodic links, partitions, and data sections are passed over; cells of fewer than two dimensions are left
out; files written on a machine of the other byte order, and parametric nodes, are refused.

References
----------
Gmsh reference manual, "MSH file format" and "MSH file format version 2 (Legacy)".
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..mesh import HexMesh
from .msh_common import NODES_OF_TYPE, Groups, collect

_OPENING = re.compile(rb"^\$(\w+)[ \t]*\r?\n", re.MULTILINE)


def read_content(content: Any) -> HexMesh:
    """Make a mesh of a file's bytes."""
    data = memoryview(content)
    head = bytes(data[:200])
    found = re.match(rb"\s*\$MeshFormat\s+(\d+\.?\d*)\s+([01])\s+(\d+)[ \t]*\r?\n", head)
    if found is None:
        raise InputError("it does not begin with $MeshFormat")
    version, binary = found[1].decode(), found[2] == b"1"
    if version not in {"4.1", "2.2", "2"}:
        raise InputError(f"it is of version {version}; 4.1 and 2.2 are read: save it again in one of these")
    place = found.end()
    if binary:
        if int.from_bytes(bytes(data[place : place + 4]), "little") != 1:
            raise InputError("it was written on a machine of the other byte order")
        place += 4
    groups = Groups()
    entities: dict[tuple[int, int], tuple[int, ...]] = {}
    nodes: tuple[IntArray, FloatArray] | None = None
    elements = False
    while (section := _next_section(data, place)) is not None:
        name, place = section
        if name == b"PhysicalNames":
            groups.names, place = _physical_names(data, place)
        elif name in {b"Entities", b"Nodes", b"Elements"}:
            values = _Values(data, place, binary=binary)
            if name == b"Entities":
                entities = dict(_entities(values))
            elif name == b"Nodes":
                nodes = _nodes4(values) if version == "4.1" else _nodes2(values)
            else:
                elements = True
                (_elements4 if version == "4.1" else _elements2)(values, groups, entities)
            place = values.place
    if nodes is None or not elements:
        raise InputError("it has no nodes or no elements, or is cut short")
    return collect(nodes[1], nodes[0], groups)


def _next_section(data: memoryview, place: int) -> tuple[bytes, int] | None:
    while True:
        found = _OPENING.search(data, place)
        if found is None:
            return None
        place = found.end()
        if not found[1].startswith(b"End"):
            return found[1], place


def _physical_names(data: memoryview, place: int) -> tuple[dict[tuple[int, int], str], int]:
    end = re.compile(rb"\$EndPhysicalNames").search(data, place)
    if end is None:
        raise InputError("its list of physical names is cut short")
    rows = re.findall(
        r'^\s*(\d+)\s+(\d+)\s+"(.*)"\s*$', bytes(data[place : end.start()]).decode("utf-8", "replace"), re.M
    )
    return {(int(dimension), int(tag)): name for dimension, tag, name in rows}, end.end()


class _Values:
    """Numbers of a section, one after the other, whether text or binary."""

    def __init__(self, data: memoryview, place: int, *, binary: bool) -> None:
        self.data = data
        self.place = place
        self.binary = binary
        if not binary:
            end = re.compile(rb"^\$End", re.MULTILINE).search(data, place)
            if end is None:
                raise InputError("a section has no end: the file is cut short")
            try:
                self.numbers = np.array(bytes(data[place : end.start()]).split(), dtype=np.float64)
            except ValueError as error:
                raise InputError(f"a number is no number ({error})") from None
            self.place = end.start()
            self.at = 0

    def take(self, n: int, dtype: Any) -> np.ndarray:
        if self.binary:
            size = n * np.dtype(dtype).itemsize
            if n < 0 or self.place + size > len(self.data):
                raise InputError("a section is longer than the file: the file is cut short or damaged")
            values = np.frombuffer(self.data, dtype=dtype, count=n, offset=self.place)
            self.place += size
            return values
        if n < 0 or self.at + n > len(self.numbers):
            raise InputError("a section has fewer numbers than it says: the file is cut short or damaged")
        values = self.numbers[self.at : self.at + n]
        self.at += n
        return values.astype(dtype)

    def size(self) -> int:
        return int(self.take(1, np.int64)[0])

    def integer(self) -> int:
        return int(self.take(1, np.int32)[0])

    def line(self) -> int:
        """A count that stands as text on a line of its own, also in a binary file (MSH 2)."""
        if not self.binary:
            return self.size()
        found = re.compile(rb"\s*(\d+)[ \t]*\r?\n").match(self.data, self.place)
        if found is None:
            raise InputError("a section has no count")
        self.place = found.end()
        return int(found[1])


def _entities(values: _Values) -> Iterator[tuple[tuple[int, int], tuple[int, ...]]]:
    counts = values.take(4, np.int64)
    for dimension, n in enumerate(counts.tolist()):
        for _ in range(n):
            tag = values.integer()
            values.take(3 if dimension == 0 else 6, np.float64)
            physical = tuple(values.take(values.size(), np.int32).tolist())
            if dimension:
                values.take(values.size(), np.int32)
            yield (dimension, tag), physical


def _nodes4(values: _Values) -> tuple[IntArray, FloatArray]:
    n_blocks, n_nodes = values.take(4, np.int64)[:2].tolist()
    tags, points = [], []
    for _ in range(n_blocks):
        _, _, parametric = values.take(3, np.int32).tolist()
        if parametric:
            raise InputError("it has nodes with surface parameters; save it without (Mesh.SaveParametric=0)")
        n = values.size()
        tags.append(values.take(n, np.int64))
        points.append(values.take(3 * n, np.float64).reshape(n, 3))
    if sum(map(len, tags)) != n_nodes or not tags:
        raise InputError("it has another number of nodes than it says")
    if len(tags) == 1:
        return tags[0], points[0]
    return np.concatenate(tags), np.concatenate(points)


def _nodes2(values: _Values) -> tuple[IntArray, FloatArray]:
    n = values.line()
    if values.binary:
        rows = values.take(n, np.dtype([("tag", "<i4"), ("xyz", "<f8", 3)]))
        return rows["tag"].astype(np.int64), np.ascontiguousarray(rows["xyz"])
    table = values.take(4 * n, np.float64).reshape(n, 4)
    return table[:, 0].astype(np.int64), np.ascontiguousarray(table[:, 1:])


def _elements4(values: _Values, groups: Groups, entities: dict[tuple[int, int], tuple[int, ...]]) -> None:
    n_blocks = int(values.take(4, np.int64)[0])
    for _ in range(n_blocks):
        dimension, tag, kind = values.take(3, np.int32).tolist()
        n = values.size()
        if kind not in NODES_OF_TYPE:
            raise InputError(f"it has elements of the gmsh type {kind}, which is not read")
        rows = values.take(n * (1 + NODES_OF_TYPE[kind]), np.int64).reshape(n, -1)
        groups.add(kind, rows[:, 0], rows[:, 1:], entities.get((dimension, tag), ()))


def _elements2(values: _Values, groups: Groups, entities: dict[tuple[int, int], tuple[int, ...]]) -> None:
    del entities  # MSH 2 has none
    n = values.line()
    done = 0
    while done < n:
        if values.binary:
            kind, count, n_tags = values.take(3, np.int32).tolist()
            width = NODES_OF_TYPE.get(kind, 0)
            rows = values.take(max(count, 1) * (1 + n_tags + width), np.int32).reshape(max(count, 1), -1)
        else:
            rest = values.numbers[values.at :]
            if len(rest) < 3:
                raise InputError("a section has fewer numbers than it says: the file is cut short or damaged")
            kind, n_tags = int(rest[1]), int(rest[2])
            width = NODES_OF_TYPE.get(kind, 0)
            stride = 3 + n_tags + width
            table = rest[: len(rest) // stride * stride].reshape(-1, stride)[: n - done]
            same = (table[:, 1] == kind) & (table[:, 2] == n_tags)
            count = len(table) if same.all() else int(np.argmin(same))
            rows = np.delete(values.take(count * stride, np.int64).reshape(-1, stride), [1, 2], axis=1)
        if width == 0 or n_tags < 0 or len(rows) == 0:
            raise InputError(f"it has elements of the gmsh type {kind}, which is not read")
        done += len(rows)
        rows = rows.astype(np.int64)
        physical = rows[:, 1] if n_tags else np.zeros(len(rows), dtype=np.int64)
        for tag in dict.fromkeys(physical.tolist()):
            these = physical == tag
            groups.add(kind, rows[these, 0], rows[these, 1 + n_tags :], (tag,) if tag else ())
