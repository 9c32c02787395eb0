"""Exodus II, ``.e``, ``.exo``, ``.ex2``: element blocks and side sets with names.

Place in the flow: a format module of :mod:`cadsweep.io`. Written as a netCDF file of the classic model with 64-bit
offsets (scipy); read too where it is netCDF-4 (h5py).

Every boundary is a side set, and a node set of the same name; the node sets of periodic boundaries list their nodes
pair by pair. Blocks are disjoint: where parts overlap, the names of
:meth:`~cadsweep.io.labels.Blocks.exclusive_names` stand. Names have 32 characters at the most. Node and element ids are
32-bit integers.

Not handled on reading: time steps and fields (passed over).

References
----------
L. A. Schoof, V. R. Yarberry, "EXODUS II: A Finite Element Data Model", SAND92-2137, figures of HEX8, HEX20, HEX27 and
table of the sides: 1 = 1-2-6-5, 2 = 2-3-7-6, 3 = 3-4-8-7, 4 = 1-5-8-4, 5 = 1-4-3-2, 6 = 5-6-7-8.
"""

from __future__ import annotations

import re
from typing import Any, BinaryIO

import h5py
import numpy as np
from scipy.io import netcdf_file

from ..errors import InputError
from ..mesh import HexMesh
from .compare import Groups, all_boundaries, disjoint_parts
from .hdf5 import load
from .labels import LabelledMesh, check_nodes
from .sides import quads_of_sides

MAX_NAME = 32
NODE_ORDER = {
    8: np.arange(8),
    20: np.array([*range(12), 16, 17, 18, 19, 12, 13, 14, 15]),
    27: np.array([*range(12), 16, 17, 18, 19, 12, 13, 14, 15, 26, 24, 25, 20, 21, 22, 23]),
}
"""``exodus_nodes = vtk_nodes[:, NODE_ORDER[n]]``: bottom, upright, top edges; volume; bottom, top, x-, x+, y-, y+."""

SIDE_NUMBERS = np.array([5, 6, 1, 2, 3, 4])
"""Exodus number of the sides in the order of ``HEX_FACES``."""


def kept_groups(mesh: LabelledMesh) -> Groups:
    """Side sets may overlap, element blocks may not."""
    return all_boundaries(mesh), disjoint_parts(mesh)


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    n, m, size = len(mesh.points), len(mesh.hexes), mesh.hexes.shape[1]
    if max(n, m) >= 1 << 31:
        raise InputError("Exodus keeps 32-bit ids: the mesh has too many nodes or hexes; write .vtkhdf")
    blocks = mesh.volumes.exclusive_names()
    cells = [mesh.volumes.cells(j) for j in range(len(blocks))]
    order = np.concatenate(cells)
    place = np.empty(m, dtype=np.int64)
    place[order] = np.arange(m)
    names = mesh.faces.names
    with netcdf_file(_Kept(stream), "w", version=2) as file:
        file.title = b"cadsweep"
        file.api_version = np.float32(5.14)
        file.version = np.float32(5.14)
        file.floating_point_word_size = np.int32(8)
        file.file_size = np.int32(1)
        file.maximum_name_length = np.int32(MAX_NAME)
        file.int64_status = np.int32(0)
        for name, value in (
            # scipy wants the unlimited dimension first.
            ("time_step", None), ("len_string", 33), ("len_name", MAX_NAME + 1), ("len_line", 81), ("four", 4),
            ("num_dim", 3), ("num_nodes", n), ("num_elem", m), ("num_el_blk", len(blocks)),
        ):  # fmt: skip
            file.createDimension(name, value)
        file.createVariable("time_whole", "f8", ("time_step",))
        for axis, name in enumerate("xyz"):
            _put(file, f"coord{name}", "f8", ("num_nodes",), mesh.points[:, axis])
        _put_names(file, "coor_names", "num_dim", list("xyz"))
        _put(file, "elem_num_map", "i4", ("num_elem",), order + 1)
        _put_ids(file, "eb", "num_el_blk", blocks)
        for j, ids in enumerate(cells, 1):
            file.createDimension(f"num_el_in_blk{j}", len(ids))
            file.createDimension(f"num_nod_per_el{j}", size)
            shape = (f"num_el_in_blk{j}", f"num_nod_per_el{j}")
            connect = _put(file, f"connect{j}", "i4", shape, mesh.hexes[ids][:, NODE_ORDER[size]] + 1)
            connect.elem_type = f"HEX{size}".encode()
        if names:
            _write_sets(file, mesh, names, place)


def _write_sets(file: netcdf_file, mesh: LabelledMesh, names: tuple[str, ...], place: np.ndarray) -> None:
    of, sides = mesh.sides
    # The nodes of periodic boundaries answer each other one by one.
    ordered = {name: pairs[:, k] for names, pairs in mesh.periodic.items() for k, name in enumerate(names)}
    for kind, dimension in (("ss", "num_side_sets"), ("ns", "num_node_sets")):
        file.createDimension(dimension, len(names))
        _put_ids(file, kind, dimension, names)
    for j, name in enumerate(names, 1):
        ids = mesh.faces.named(name)
        file.createDimension(f"num_side_ss{j}", len(ids))
        _put(file, f"elem_ss{j}", "i4", (f"num_side_ss{j}",), place[of[ids]] + 1)
        _put(file, f"side_ss{j}", "i4", (f"num_side_ss{j}",), SIDE_NUMBERS[sides[ids]])
        nodes = ordered.get(name, np.unique(mesh.quads[ids])) + 1
        file.createDimension(f"num_nod_ns{j}", len(nodes))
        _put(file, f"node_ns{j}", "i4", (f"num_nod_ns{j}",), nodes)


def _put(file: netcdf_file, name: str, kind: str, shape: tuple[str, ...], values: Any) -> Any:
    variable = file.createVariable(name, kind, shape)
    variable[:] = values
    return variable


def _put_ids(file: netcdf_file, kind: str, dimension: str, names: Any) -> None:
    _put(file, f"{kind}_status", "i4", (dimension,), np.ones(len(names)))
    _put(file, f"{kind}_prop1", "i4", (dimension,), np.arange(1, len(names) + 1)).name = b"ID"
    _put_names(file, f"{kind}_names", dimension, names)


def _put_names(file: netcdf_file, name: str, dimension: str, names: Any) -> None:
    table = np.zeros((len(names), MAX_NAME + 1), dtype="S1")
    for j, text in enumerate(names):
        table[j, : len(text)] = np.frombuffer(text.encode(), dtype="S1")
    _put(file, name, "c", (dimension, "len_name"), table)


class _Kept:
    """A stream that stays open when scipy closes its file."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.closed = False

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def close(self) -> None:
        """Only be closed for scipy: the stream belongs to the caller."""
        self.closed = True


def read(stream: BinaryIO) -> HexMesh:
    """Read blocks of hexes and side sets."""
    start = stream.read(8)
    stream.seek(0)
    if start[:3] == b"CDF":
        with netcdf_file(_Kept(stream), "r", mmap=False) as file:
            return _mesh({name: np.array(v[:]) for name, v in file.variables.items()})
    if start != b"\x89HDF\r\n\x1a\n":
        raise InputError("it is no netCDF file")
    with h5py.File(stream, "r") as file:
        return _mesh({name: load(v) for name, v in file.items() if isinstance(v, h5py.Dataset) and v.shape})


def _mesh(found: dict[str, np.ndarray]) -> HexMesh:
    if "coord" in found:
        points = np.ascontiguousarray(found["coord"].T, dtype=np.float64)
    elif "coordx" in found and "coordz" in found:
        points = np.column_stack([found[f"coord{axis}"] for axis in "xyz"]).astype(np.float64)
    else:
        raise InputError("it has no nodes in three dimensions")
    blocks = [found[name].astype(np.int64) - 1 for name in _numbered(found, "connect")]
    sizes = {block.shape[1] for block in blocks}
    if len(sizes) != 1 or not sizes <= set(NODE_ORDER):
        raise InputError(f"its blocks have elements of {sorted(sizes)} nodes; one kind of hex (8, 20, 27) is read")
    size = sizes.pop()
    hexes = np.concatenate(blocks)[:, np.argsort(NODE_ORDER[size])]
    check_nodes(hexes, len(points))
    tags = found.get("elem_num_map", np.arange(1, len(hexes) + 1))
    order = np.argsort(tags, kind="stable")
    place = np.empty(len(hexes), dtype=np.int64)
    place[order] = np.arange(len(hexes))
    names = _names(found, "eb_names", len(blocks), "block")
    ends = np.cumsum([len(block) for block in blocks])[:-1]
    parts = {name: np.sort(ids) for name, ids in zip(names, np.split(place, ends), strict=True)}
    sets = _numbered(found, "elem_ss")
    side_of_number = np.argsort(SIDE_NUMBERS)
    boundaries = {}
    for name, key in zip(_names(found, "ss_names", len(sets), "side_set"), sets, strict=True):
        of = place[found[key].astype(np.int64) - 1]
        sides = side_of_number[found[key.replace("elem_", "side_")].astype(np.int64) - 1]
        boundaries[name] = quads_of_sides(hexes[order], of, sides)
    return HexMesh(points=points, hexes=hexes[order], boundaries=boundaries, parts=parts)


def _numbered(found: dict[str, np.ndarray], stem: str) -> list[str]:
    return sorted(
        (name for name in found if re.fullmatch(stem + r"\d+", name)), key=lambda name: int(name[len(stem) :])
    )


def _names(found: dict[str, np.ndarray], key: str, n: int, stem: str) -> list[str]:
    rows = found.get(key, np.zeros((n, 1), dtype="S1"))
    names = [b"".join(row.tolist()).split(b"\0")[0].decode("utf-8", "replace").strip() for row in rows]
    return [name or f"{stem}_{j}" for j, name in enumerate(names, 1)]
