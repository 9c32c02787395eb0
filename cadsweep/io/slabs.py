"""A ``.vtkhdf`` file written slab by slab, for meshes that never exist as a whole.

Place in the flow: ``blocks.stream`` and ``pipeline.ranks`` fill it from the factors; nothing else knows that the
file was not written at once. Sizes are known beforehand, so every array has its place from the start and any
slab can be written at any time. The arrays are those of :mod:`cadsweep.io.vtkhdf`.

Several pieces are several partitions of one grid: each has its own points, and its cells number them
from 0, as VTK wants it.

References
----------
VTK file formats, "VTKHDF File Format", version 2.2.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import h5py
import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import CadSweepError
from .vtk_cells import CELL_TYPES
from .vtkhdf import open_grid, write_arrays

READ_BYTES = 1 << 24
"""Bytes that are compared at a time when the file is read back."""


@dataclass(frozen=True, kw_only=True)
class PieceSizes:
    """Nodes and hexahedra of one partition."""

    n_points: int
    n_hexes: int


class SlabWriter:
    """Arrays of one file, filled slab by slab.

    Parameters
    ----------
    stream : BinaryIO
        Open for reading and writing.
    pieces : sequence of PieceSizes
        One for a serial mesh.
    fields : mapping of str to array
        Field data: names, and the quads of every boundary.
    cell_arrays, point_arrays : mapping of str to dtype
        Data arrays that the slabs will fill.
    lists : mapping of str to int
        Field data that the slabs will fill: lists of int64, and how long they are.
    """

    def __init__(
        self,
        stream: BinaryIO,
        pieces: Sequence[PieceSizes],
        *,
        fields: Mapping[str, np.ndarray],
        cell_arrays: Mapping[str, Any],
        point_arrays: Mapping[str, Any] | None = None,
        lists: Mapping[str, int] | None = None,
    ) -> None:
        self._file = h5py.File(stream, "w", libver=("v108", "v110"))
        root = open_grid(self._file)
        n_points = np.array([p.n_points for p in pieces], dtype=np.int64)
        n_hexes = np.array([p.n_hexes for p in pieces], dtype=np.int64)
        root["NumberOfPoints"] = n_points
        root["NumberOfCells"] = n_hexes
        root["NumberOfConnectivityIds"] = 8 * n_hexes
        total_points, total_hexes = int(n_points.sum()), int(n_hexes.sum())
        self._first_point = np.concatenate([[0], np.cumsum(n_points)])
        self._first_hex = np.concatenate([[0], np.cumsum(n_hexes)])
        self._points = root.create_dataset("Points", (total_points, 3), dtype=np.float64)
        self._hexes = root.create_dataset("Connectivity", (8 * total_hexes,), dtype=np.int64)
        self._offsets = root.create_dataset("Offsets", (total_hexes + len(pieces),), dtype=np.int64)
        self._types = root.create_dataset("Types", (total_hexes,), dtype=np.uint8)
        cells, nodes = root.create_group("CellData"), root.create_group("PointData")
        self._cells = {name: cells.create_dataset(name, (total_hexes,), dtype=t) for name, t in cell_arrays.items()}
        self._nodes = {
            name: nodes.create_dataset(name, (total_points,), dtype=t) for name, t in (point_arrays or {}).items()
        }
        known = root.create_group("FieldData")
        write_arrays(known, dict(fields))
        self._lists = {name: known.create_dataset(name, (n,), dtype=np.int64) for name, n in (lists or {}).items()}
        self._sums: dict[tuple[str, int], tuple[int, int]] = {}

    def add_points(self, start: int, points: FloatArray, *, piece: int = 0, **arrays: np.ndarray) -> None:
        """Write points (m, 3) and their data from place `start` of a piece."""
        at = int(self._first_point[piece]) + start
        self._write(self._points, at, points)
        for name, values in arrays.items():
            self._write(self._nodes[name], at, values)

    def add_hexes(self, start: int, hexes: IntArray, *, piece: int = 0, **arrays: np.ndarray) -> None:
        """Write hexes (m, 8), in the piece's own node numbers, and their data from place `start` of a piece."""
        at, m = int(self._first_hex[piece]) + start, len(hexes)
        self._write(self._hexes, 8 * at, hexes.reshape(-1))
        # Every piece has one offset more than it has cells: where its last cell ends.
        self._write(self._offsets, at + piece + 1, 8 * np.arange(start + 1, start + m + 1, dtype=np.int64))
        self._write(self._types, at, np.full(m, CELL_TYPES[8], dtype=np.uint8))
        for name, values in arrays.items():
            self._write(self._cells[name], at, values)

    def add_list(self, name: str, start: int, values: IntArray) -> None:
        """Write some of a list of the field data, from place `start` on."""
        self._write(self._lists[name], start, values)

    def close(self, *, verify: bool = True) -> None:
        """Flush; read back what was written and compare.

        Raises
        ------
        CadSweepError
            The file does not hold what was written to it.
        """
        self._file.flush()
        if verify:
            for (name, start), (stop, checksum) in self._sums.items():
                if _checksum(self._file[name], start, stop) != checksum:
                    raise CadSweepError(f"{name} reads back otherwise than it was written; is the disk sound?")
        self._file.close()

    def _write(self, array: h5py.Dataset, start: int, values: np.ndarray) -> None:
        stop = start + len(values)
        values = np.ascontiguousarray(values, dtype=array.dtype)
        array[start:stop] = values
        self._sums[array.name, start] = stop, zlib.crc32(values.reshape(-1).view(np.uint8).data)


def _checksum(array: h5py.Dataset, start: int, stop: int) -> int:
    row = max(1, int(np.prod(array.shape[1:]))) * array.dtype.itemsize
    step, found = max(1, READ_BYTES // row), 0
    for at in range(start, stop, step):
        block = np.ascontiguousarray(array[at : min(at + step, stop)])
        found = zlib.crc32(block.reshape(-1).view(np.uint8).data, found)
    return found
