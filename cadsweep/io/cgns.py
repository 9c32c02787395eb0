"""CGNS in its HDF5 form, ``.cgns``.

Place in the flow: a format module of :mod:`cadsweep.io`. One base, one unstructured zone: an element section a part, an
element section a disjoint block of boundary quads, and a boundary condition (``BC_t`` of the family of the same name)
a boundary, by the numbers of its quads, so that boundaries may overlap. Sections are disjoint: where parts overlap, the
names of :meth:`~cadsweep.io.labels.Blocks.exclusive_names` stand. Names have 32 characters at the most.

Written with h5py: gmsh's writer numbers the nodes anew. Where parts are not runs of hexes, an array ``HexOrder`` under
``UserDefinedData_t`` keeps the mesh's order.

Not handled on reading: several zones, mixed sections, boundary conditions by ranges of nodes, ADF files.

References
----------
CGNS SIDS, "Element numbering conventions" (HEXA_8, HEXA_20, HEXA_27), and "SIDS-to-HDF5 file mapping" (cgns.github.io).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO

import h5py
import numpy as np

from ..arrays import IntArray
from ..errors import InputError
from ..mesh import HexMesh
from .compare import Groups, all_boundaries, disjoint_parts
from .hdf5 import load
from .labels import LabelledMesh, check_nodes

MAX_NAME = 32
HEX_TYPES = {8: 17, 20: 18, 27: 19}
QUAD_TYPES = {4: 7, 8: 8, 9: 9}
_ORDER = [*range(12), 16, 17, 18, 19, 12, 13, 14, 15, 24, 22, 21, 23, 20, 25, 26]
HEX_ORDER = {size: np.array(_ORDER[:size]) for size in (8, 20, 27)}
"""``cgns_nodes = vtk_nodes[:, HEX_ORDER[n]]``: bottom, upright, top edges; bottom, y-, x+, y+, x-, top; volume."""

_FLAT_TYPES = {2, 3, 4, 5, 6, 7, 8, 9, 24, 25, 26, 27, 28}
RESERVED = ("Zone", "GridCoordinates", "ZoneBC", "ZoneType", "UserData")
"""Names of nodes that stand beside those of parts and boundaries."""


def kept_groups(mesh: LabelledMesh) -> Groups:
    """Boundaries may overlap, sections of hexes may not."""
    return all_boundaries(mesh), disjoint_parts(mesh)


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    n, m, q = len(mesh.points), len(mesh.hexes), len(mesh.quads)
    size, width = mesh.hexes.shape[1], mesh.quads.shape[1]
    whole: Any = np.int32 if max(n, m * size) < 1 << 31 else np.int64
    with h5py.File(stream, "w", libver=("earliest", "v110"), track_order=True) as file:
        _attributes(file, "HDF5 MotherNode", "Root Node of HDF5 File", "MT")
        file[" format"] = np.frombuffer(b"IEEE_LITTLE_32\0", dtype=np.int8)
        file[" hdf5version"] = np.frombuffer(b"HDF5 Version 1.10.0".ljust(33, b"\0"), dtype=np.int8)
        _node(file, "CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([3.4], dtype=np.float32))
        base = _node(file, "Base", "CGNSBase_t", np.array([3, 3], dtype=np.int32))
        zone = _node(base, "Zone", "Zone_t", np.array([[n], [m], [0]], dtype=whole))
        _node(zone, "ZoneType", "ZoneType_t", "Unstructured")
        grid = _node(zone, "GridCoordinates", "GridCoordinates_t", None)
        for axis, name in enumerate("XYZ"):
            _node(grid, f"Coordinate{name}", "DataArray_t", np.ascontiguousarray(mesh.points[:, axis]))
        parts, faces = mesh.volumes.exclusive_names(), mesh.faces.exclusive_names()
        taken = {*parts, *RESERVED}
        first, orders = 1, []
        for block, name in enumerate(parts):
            ids = mesh.volumes.cells(block)
            _section(zone, name, HEX_TYPES[size], mesh.hexes[ids][:, HEX_ORDER[size]] + 1, first=first, whole=whole)
            first += len(ids)
            orders.append(ids)
        place = np.empty(q, dtype=np.int64)
        for block, name in enumerate(faces):
            ids = mesh.faces.cells(block)
            label, count = name, 1
            while label in taken:  # a part and a boundary may have one name, sections may not
                count += 1
                label = f"{name[:24]}_{count}"
            taken.add(label)
            _section(zone, label, QUAD_TYPES[width], mesh.quads[ids] + 1, first=first, whole=whole)
            place[ids] = np.arange(first, first + len(ids))
            first += len(ids)
        if mesh.faces.names:
            conditions = _node(zone, "ZoneBC", "ZoneBC_t", None)
        for name in mesh.faces.names:
            condition = _node(conditions, name, "BC_t", "FamilySpecified")
            _node(condition, "PointList", "IndexArray_t", place[mesh.faces.named(name)].astype(whole)[:, None])
            _node(condition, "GridLocation", "GridLocation_t", "FaceCenter")
            _node(condition, "FamilyName", "FamilyName_t", name)
            _node(base, name, "Family_t", None)
        order = np.concatenate(orders)
        if (np.diff(order) < 0).any():
            user = _node(zone, "UserData", "UserDefinedData_t", None)
            _node(user, "HexOrder", "DataArray_t", order)


def _section(zone: h5py.Group, name: str, kind: int, nodes: IntArray, *, first: int, whole: Any) -> None:
    section = _node(zone, name, "Elements_t", np.array([kind, 0], dtype=np.int32))
    _node(section, "ElementRange", "IndexRange_t", np.array([first, first + len(nodes) - 1], dtype=whole))
    _node(section, "ElementConnectivity", "DataArray_t", nodes.reshape(-1).astype(whole))


def _node(parent: h5py.Group, name: str, label: str, data: np.ndarray | str | None) -> h5py.Group:
    group = parent.create_group(name, track_order=True)
    if isinstance(data, str):
        data, kind = np.frombuffer(data.encode(), dtype=np.int8), "C1"
    elif data is None:
        kind = "MT"
    else:
        kind = {"i4": "I4", "i8": "I8", "f4": "R4", "f8": "R8"}[data.dtype.str[1:]]
    _attributes(group, name, label, kind)
    if data is not None:
        group[" data"] = data
    return group


def _attributes(group: h5py.Group, name: str, label: str, kind: str) -> None:
    for key, text, length in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
        group.attrs.create(key, text.encode(), dtype=h5py.string_dtype("ascii", length))
    if label != "Root Node of HDF5 File":
        group.attrs["flags"] = np.array([1], dtype=np.int32)


def read(stream: BinaryIO) -> HexMesh:
    """Read the one zone of a file."""
    with h5py.File(stream, "r") as file:
        zones = [zone for base in _children(file, "CGNSBase_t") for zone in _children(base, "Zone_t")]
        if len(zones) != 1:
            raise InputError(f"it has {len(zones)} CGNS zones; one is read")
        zone = zones[0]
        grids = list(_children(zone, "GridCoordinates_t"))
        if not grids or any(f"Coordinate{axis}" not in grids[0] for axis in "XYZ"):
            raise InputError("it has no Cartesian coordinates in three dimensions")
        points = np.column_stack([_data(grids[0][f"Coordinate{axis}"]) for axis in "XYZ"]).astype(np.float64)
        hexes, quads = {}, {}
        first_quad: list[tuple[int, IntArray]] = []
        sizes = {code: size for size, code in HEX_TYPES.items()}
        widths = {code: size for size, code in QUAD_TYPES.items()}
        for section in sorted(
            _children(zone, "Elements_t"), key=lambda s: int(_data(s["ElementRange"]).reshape(-1)[0])
        ):
            kind = int(_data(section)[0])
            first = int(_data(section["ElementRange"]).reshape(-1)[0])
            nodes = _data(section["ElementConnectivity"]).astype(np.int64) - 1
            check_nodes(nodes, len(points))
            if kind in sizes:
                hexes[_text(section)] = nodes.reshape(-1, sizes[kind])[:, np.argsort(HEX_ORDER[sizes[kind]])]
            elif kind in widths:
                first_quad.append((first, nodes.reshape(-1, widths[kind])))
            elif kind not in _FLAT_TYPES:
                raise InputError(f"it has elements of the CGNS type {kind}; hexes and quads are read")
        if len({block.shape[1] for block in hexes.values()}) != 1:
            raise InputError("it has no hexahedra, or hexahedra of several orders")
        stacked = np.concatenate(list(hexes.values()))
        width = {8: 4, 20: 8, 27: 9}[stacked.shape[1]]
        quads = {first: block for first, block in first_quad if block.shape[1] == width}
        numbers = np.concatenate([np.arange(f, f + len(b)) for f, b in quads.items()] or [np.empty(0, dtype=np.int64)])
        table = np.concatenate([*quads.values(), np.empty((0, width), dtype=np.int64)])
        boundaries = {}
        for group in _children(zone, "ZoneBC_t"):
            for condition in _children(group, "BC_t"):
                wanted = _numbers(condition)
                boundaries[_text(condition)] = table[np.isin(numbers, wanted)]
        ends = np.cumsum([len(block) for block in hexes.values()])
        order = np.arange(len(stacked))
        for user in _children(zone, "UserDefinedData_t"):
            if "HexOrder" in user and len(_data(user["HexOrder"])) == len(stacked):
                order = _data(user["HexOrder"]).astype(np.int64)
    result = np.empty_like(stacked)
    result[order] = stacked
    parts = {name: np.sort(ids) for name, ids in zip(hexes, np.split(order, ends[:-1]), strict=True)}
    return HexMesh(points=points, hexes=result, boundaries=boundaries, parts=parts)


def _children(group: h5py.Group, label: str) -> Iterator[h5py.Group]:
    for child in group.values():
        if isinstance(child, h5py.Group) and child.attrs.get("label", b"").strip(b"\0 ") == label.encode():
            yield child


def _data(group: h5py.Group) -> np.ndarray:
    return load(group[" data"])


def _text(group: h5py.Group) -> str:
    return group.attrs["name"].decode("ascii", "replace").strip("\0 ")


def _numbers(condition: h5py.Group) -> IntArray:
    if "PointList" in condition:
        return _data(condition["PointList"]).reshape(-1).astype(np.int64)
    if "PointRange" in condition:
        low, high = _data(condition["PointRange"]).reshape(-1)[:2].tolist()
        return np.arange(low, high + 1)
    return np.empty(0, dtype=np.int64)
