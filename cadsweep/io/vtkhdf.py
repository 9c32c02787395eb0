"""VTK's HDF5 format, ``.vtkhdf``: an unstructured grid of one or several pieces.

Place in the flow: a format module of :mod:`cadsweep.io`. Names are kept in the same arrays as in ``.vtu`` (see
:mod:`cadsweep.io.vtu`), in the groups ``CellData`` and ``FieldData``. Times are not tracked, so that the same mesh
gives the same bytes.

Not handled on reading: time steps, composite datasets, polyhedra.

References
----------
VTK file formats, "VTKHDF File Format" (docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html), version
2.2; node order: see :mod:`cadsweep.io.vtk_cells`.
"""

from __future__ import annotations

from typing import Any, BinaryIO

import h5py
import numpy as np

from ..errors import CadSweepError, InputError
from ..lattice import MOST
from ..mesh import HexMesh
from . import vtk_cells
from .compare import same_bytes
from .hdf5 import load
from .labels import LabelledMesh

VERSION = (2, 2)
MOST_ORDER = MOST


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh as one piece."""
    # Not in a thread beside: every piece that is written would wait for the interpreter to come back from there.
    cells, fields, points = vtk_cells.grid_arrays(mesh)
    with h5py.File(stream, "w", libver=("v108", "v110")) as file:
        root = open_grid(file)
        for name, n in _numbers(mesh).items():
            root[f"NumberOf{name}"] = np.array([n], dtype=np.int64)
        root["Points"] = mesh.points
        root["Connectivity"] = mesh.hexes.reshape(-1)
        root["Offsets"] = vtk_cells.offsets(mesh.hexes)
        root["Types"] = vtk_cells.types(mesh.hexes)
        for group, arrays in (("CellData", cells), ("PointData", points), ("FieldData", fields)):
            write_arrays(root.require_group(group), arrays)


def verify(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Compare a file that was just written with the mesh, array by array, without making a second mesh of it.

    Raises
    ------
    CadSweepError
        An array is missing, is one too many, or differs.
    """
    cells, fields, points = vtk_cells.grid_arrays(mesh)
    expected: dict[str, Any] = {
        "Points": mesh.points,
        "Connectivity": mesh.hexes.reshape(-1),
        "Offsets": vtk_cells.offsets(mesh.hexes),
        "Types": vtk_cells.types(mesh.hexes),
        **{f"NumberOf{k}": np.array([v]) for k, v in _numbers(mesh).items()},
    }
    for group, arrays in (("CellData", cells), ("PointData", points), ("FieldData", fields)):
        expected |= {f"{group}/{name}": values for name, values in arrays.items()}
    with h5py.File(stream, "r") as file:
        found: dict[str, h5py.Dataset] = {}
        file["VTKHDF"].visititems(lambda name, item: found.update({name: item} if hasattr(item, "dtype") else {}))
        if set(found) != set(expected):
            raise CadSweepError(f"reading it back, the arrays differ: {sorted(set(found) ^ set(expected))[:5]}")
        for name, values in expected.items():
            if not _equal(stream, found[name], values):
                raise CadSweepError(f"reading it back gave another array {name!r}")


def _numbers(mesh: LabelledMesh) -> dict[str, int]:
    return {"Points": len(mesh.points), "Cells": len(mesh.hexes), "ConnectivityIds": mesh.hexes.size}


def _equal(stream: BinaryIO, data: h5py.Dataset, values: np.ndarray) -> bool:
    if values.dtype.kind == "U":
        return [v.decode() for v in data[:]] == values.tolist()
    offset = data.id.get_offset()
    if offset is None:
        return False
    return same_bytes(np.memmap(stream, dtype=data.dtype, mode="r", offset=offset, shape=data.shape), values)


def open_grid(file: h5py.File) -> h5py.Group:
    """Make the root group of an unstructured grid."""
    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array(VERSION, dtype=np.int64)
    root.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", len("UnstructuredGrid")))
    return root


def write_arrays(group: h5py.Group, arrays: dict[str, np.ndarray]) -> None:
    """Write arrays of numbers or of names into a data group."""
    for name, values in arrays.items():
        if values.dtype.kind == "U":
            group.create_dataset(
                name, data=[str(v) for v in values], dtype=h5py.string_dtype("ascii")
            )  # VTK reads no other strings
        else:
            group[name] = values


def read(stream: BinaryIO) -> HexMesh:
    """Read a grid of hexes with whatever names it holds; pieces are joined."""
    with h5py.File(stream, "r") as file:
        root = file.get("VTKHDF")
        kind = root.attrs.get("Type", b"") if isinstance(root, h5py.Group) else b""
        kind = kind.decode() if isinstance(kind, bytes) else str(kind)
        if not isinstance(root, h5py.Group) or kind != "UnstructuredGrid":
            raise InputError("it holds no VTKHDF unstructured grid")
        if "Steps" in root:
            raise InputError("it holds time steps; one mesh is read")
        n_points = load(root["NumberOfPoints"]).astype(np.int64)
        n_cells = load(root["NumberOfCells"]).astype(np.int64)
        n_ids = load(root["NumberOfConnectivityIds"]).astype(np.int64)
        connectivity = load(root["Connectivity"]).astype(np.int64, copy=False)
        stored = load(root["Offsets"]).astype(np.int64, copy=False)
        if len(stored) != n_cells.sum() + len(n_cells) or len(connectivity) != n_ids.sum():
            raise InputError("its list of cells is cut short or does not fit together")
        offsets = [np.zeros(1, dtype=np.int64)]
        for j in range(len(n_cells)):
            first_id, first_cell = n_ids[:j].sum(), n_cells[:j].sum() + j
            offsets.append(stored[first_cell + 1 : first_cell + 1 + n_cells[j]] + first_id)
            connectivity[first_id : first_id + n_ids[j]] += n_points[:j].sum()
        points, types = load(root["Points"]).astype(np.float64, copy=False), load(root["Types"])
        starts = np.concatenate(offsets) if len(offsets) != 2 else stored
        cell_data, point_data = _arrays(root, "CellData"), _arrays(root, "PointData")
        if vtk_cells.NODE_IDS in point_data and vtk_cells.HEX_IDS in cell_data and len(n_cells) > 1:
            points, connectivity, kept = vtk_cells.join_pieces(
                points, connectivity, starts, point_data=point_data, cell_data=cell_data
            )
            starts, types = 8 * np.arange(len(kept) + 1, dtype=np.int64), types[kept]
            cell_data = {name: values[kept] for name, values in cell_data.items()}
        return vtk_cells.grid_mesh(
            points=points,
            connectivity=connectivity,
            offsets=starts,
            types=types,
            cell_data=cell_data,
            field_data=_arrays(root, "FieldData"),
        )


def _arrays(root: h5py.Group, group: str) -> dict[str, Any]:
    found = {}
    for name, data in root.get(group, {}).items():
        if not isinstance(data, h5py.Dataset):
            continue
        text = h5py.check_string_dtype(data.dtype) is not None
        values = load(data)
        found[name] = [v.decode() for v in values] if text else values
    return found
