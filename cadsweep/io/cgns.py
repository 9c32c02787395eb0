"""CGNS in its HDF5 form, ``.cgns``.

Place in the flow: a format module of :mod:`cadsweep.io`. One base. A mesh with interfaces between its parts has a zone
a part, and a ``GridConnectivity_t`` (``Abutting1to1``, of faces) an interface in both of its zones; any other mesh is
one zone (:mod:`.cgns_zones`). In a zone: an element section a part, an
element section a disjoint block of boundary quads, and a boundary condition (``BC_t`` of the family of the same name)
a boundary, by the numbers of its quads, so that boundaries may overlap. Sections are disjoint: where parts overlap, the
names of :meth:`~cadsweep.io.labels.Blocks.exclusive_names` stand. Names have 32 characters at the most.

Written with h5py: gmsh's writer numbers the nodes anew. Where parts are not runs of hexes, or zones, an array
``HexOrder`` under ``UserDefinedData_t`` keeps the mesh's order, and ``NodeOrder`` says which nodes a zone's are.

Not handled on reading: several zones that do not say so, mixed sections, boundary conditions by ranges of nodes, ADF
files.

References
----------
CGNS SIDS, "Element numbering conventions" (HEXA_8, HEXA_20, HEXA_27), and "SIDS-to-HDF5 file mapping" (cgns.github.io).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import h5py
import numpy as np

from ..arrays import IntArray
from ..contacts import solids_of
from ..errors import InputError
from ..lattice import quad_size
from ..mesh import HexMesh
from .cgns_orders import HEX_TYPES, QUAD_TYPES, hex_order, quad_order
from .cgns_zones import RESERVED, ZonePiece, turned_quads, zone_pieces
from .compare import Groups, all_boundaries, disjoint_parts
from .hdf5 import load
from .labels import LabelledMesh, check_nodes

MAX_NAME = 32
MOST_ORDER = 4

_FLAT_TYPES = {2, 3, 4, 5, 6, 7, 8, 9, 24, 25, 26, 27, 28, 40, 41, 42, 43, 44}


def kept_groups(mesh: LabelledMesh) -> Groups:
    """Boundaries may overlap, sections of hexes may not."""
    return all_boundaries(mesh), disjoint_parts(mesh)


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh."""
    n, size = len(mesh.points), mesh.hexes.shape[1]
    whole: Any = np.int32 if max(n, len(mesh.hexes) * size) < 1 << 31 else np.int64
    with h5py.File(stream, "w", libver=("earliest", "v110"), track_order=True) as file:
        _attributes(file, "HDF5 MotherNode", "Root Node of HDF5 File", "MT")
        file[" format"] = np.frombuffer(b"IEEE_LITTLE_32\0", dtype=np.int8)
        file[" hdf5version"] = np.frombuffer(b"HDF5 Version 1.10.0".ljust(33, b"\0"), dtype=np.int8)
        _node(file, "CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([3.4], dtype=np.float32))
        base = _node(file, "Base", "CGNSBase_t", np.array([3, 3], dtype=np.int32))
        pieces = zone_pieces(mesh)
        numbers = [_write_zone(base, mesh, piece, whole) for piece in pieces]
        for name in mesh.faces.names:
            if name not in pieces[0].contacts:
                _node(base, name, "Family_t", None)
        _connect(base, mesh, pieces, numbers, whole)


def _write_zone(base: h5py.Group, mesh: LabelledMesh, piece: ZonePiece, whole: Any) -> IntArray:
    """Write one zone; returns the numbers that its elements have of the mesh's quads, 0 where it has none."""
    size, width = mesh.hexes.shape[1], mesh.quads.shape[1]
    hexes, quads = piece.numbered(mesh.hexes), mesh.quads[piece.quads]
    quads = piece.numbered(np.where(piece.turned[:, None], turned_quads(quads), quads))
    shape = np.array([[len(piece.nodes)], [len(piece.hexes)], [0]], dtype=whole)
    zone = _node(base, piece.name, "Zone_t", shape)
    _node(zone, "ZoneType", "ZoneType_t", "Unstructured")
    grid = _node(zone, "GridCoordinates", "GridCoordinates_t", None)
    for axis, name in enumerate("XYZ"):
        _node(grid, f"Coordinate{name}", "DataArray_t", np.ascontiguousarray(mesh.points[piece.nodes, axis]))
    faces = mesh.faces.exclusive_names()
    taken = {*piece.parts.values(), *RESERVED}
    first, orders = 1, []
    for block, name in piece.parts.items():
        ids = mesh.volumes.cells(block)
        _section(zone, name, HEX_TYPES[size], hexes[ids][:, hex_order(size)] + 1, first=first, whole=whole)
        first += len(ids)
        orders.append(ids)
    place = np.zeros(len(mesh.quads), dtype=np.int64)
    of_block = mesh.faces.of_cell[piece.quads]
    for block, name in enumerate(faces):
        rows = np.flatnonzero(of_block == block)
        if not len(rows):
            continue
        label, count = name, 1
        while label in taken:  # a part and a boundary may have one name, sections may not
            count += 1
            label = f"{name[:24]}_{count}"
        taken.add(label)
        _section(zone, label, QUAD_TYPES[width], quads[rows][:, quad_order(width)] + 1, first=first, whole=whole)
        place[piece.quads[rows]] = np.arange(first, first + len(rows))
        first += len(rows)
    own = place.copy()
    own[piece.quads[piece.turned]] = 0  # an interface's other names are said of its first side
    named = {name: own[mesh.faces.named(name)] for name in mesh.faces.names if name not in piece.contacts}
    named = {name: numbers[numbers > 0] for name, numbers in named.items()}
    if any(map(len, named.values())):
        conditions = _node(zone, "ZoneBC", "ZoneBC_t", None)
    for name, numbers in named.items():
        if len(numbers):
            condition = _node(conditions, name, "BC_t", "FamilySpecified")
            _node(condition, "PointList", "IndexArray_t", numbers.astype(whole)[:, None])
            _node(condition, "GridLocation", "GridLocation_t", "FaceCenter")
            _node(condition, "FamilyName", "FamilyName_t", name)
    order = np.concatenate(orders)
    if piece.is_part or (np.diff(order) < 0).any():
        user = _node(zone, "UserData", "UserDefinedData_t", None)
        _node(user, "HexOrder", "DataArray_t", order)
        if piece.is_part:
            _node(user, "NodeOrder", "DataArray_t", piece.nodes)
    return place


def _connect(
    base: h5py.Group, mesh: LabelledMesh, pieces: Sequence[ZonePiece], numbers: Sequence[IntArray], whole: Any
) -> None:
    """Say which quads of one zone are which of another."""
    by_part = {name: j for j, piece in enumerate(pieces) for name in piece.parts.values()}
    for contact, parts in pieces[0].contacts.items():
        sides = [by_part[part] for part in parts]
        for here, there in (sides, sides[::-1]):
            zone = base[pieces[here].name]
            if "ZoneGridConnectivity" not in zone:
                _node(zone, "ZoneGridConnectivity", "ZoneGridConnectivity_t", None)
            own = _node(zone["ZoneGridConnectivity"], contact, "GridConnectivity_t", pieces[there].name)
            _node(own, "GridConnectivityType", "GridConnectivityType_t", "Abutting1to1")
            _node(own, "GridLocation", "GridLocation_t", "FaceCenter")
            quads = mesh.faces.named(contact)
            for name, side in (("PointList", here), ("PointListDonor", there)):
                _node(own, name, "IndexArray_t", numbers[side][quads].astype(whole)[:, None])


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
    """Read the one zone of a file, or the zones of the parts of one mesh."""
    with h5py.File(stream, "r") as file:
        zones = [zone for base in _children(file, "CGNSBase_t") for zone in _children(base, "Zone_t")]
        if not zones or (len(zones) > 1 and not all("UserData" in z and "NodeOrder" in z["UserData"] for z in zones)):
            raise InputError(f"it has {len(zones)} CGNS zones; one is read, or those of the parts of one mesh")
        found = [_read_zone(zone) for zone in zones]
    if len(found) == 1 and found[0].nodes is None:
        return found[0].mesh
    return _joined(found)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Zone:
    """What one zone holds: its mesh by its own numbers, and which nodes and hexes these are in the whole mesh."""

    mesh: HexMesh
    nodes: IntArray | None
    hexes: IntArray
    contacts: dict[str, IntArray]


def _joined(zones: Sequence[_Zone]) -> HexMesh:
    """One mesh of zones that know their places in it."""
    nodes = [zone.nodes for zone in zones if zone.nodes is not None]
    n_nodes = 1 + max(int(np.max(ids, initial=-1)) for ids in nodes)
    n_hexes = 1 + max(int(np.max(zone.hexes, initial=-1)) for zone in zones)
    points = np.full((n_nodes, 3), np.nan)
    hexes = np.full((n_hexes, zones[0].mesh.hexes.shape[1]), -1, dtype=np.int64)
    boundaries: dict[str, list[IntArray]] = {}
    parts: dict[str, IntArray] = {}
    for zone, own in zip(zones, nodes, strict=True):
        check_nodes(zone.mesh.hexes, len(own))
        points[own] = zone.mesh.points
        hexes[zone.hexes] = own[zone.mesh.hexes]
        for name, quads in zone.mesh.boundaries.items():
            boundaries.setdefault(name, []).append(own[quads])
        parts |= {name: np.sort(zone.hexes[ids]) for name, ids in zone.mesh.parts.items()}
    if (hexes < 0).any() or np.isnan(points).any():
        raise InputError("its zones do not make one mesh: nodes or hexes are missing")
    for zone, own in zip(zones, nodes, strict=True):
        for name, quads in zone.contacts.items():
            solids = solids_of(name, parts)
            if solids is not None and solids[0] in zone.mesh.parts:  # outward from the first
                boundaries.setdefault(name, []).append(own[quads])
    merged = {name: np.concatenate(quads) for name, quads in boundaries.items()}
    return HexMesh(points=points, hexes=hexes, boundaries=merged, parts=parts)


def _read_zone(zone: h5py.Group) -> _Zone:
    grids = list(_children(zone, "GridCoordinates_t"))
    if not grids or any(f"Coordinate{axis}" not in grids[0] for axis in "XYZ"):
        raise InputError("it has no Cartesian coordinates in three dimensions")
    points = np.column_stack([_data(grids[0][f"Coordinate{axis}"]) for axis in "XYZ"]).astype(np.float64)
    hexes, first_quad = _read_sections(zone, len(points))
    if len({block.shape[1] for block in hexes.values()}) != 1:
        raise InputError("it has no hexahedra, or hexahedra of several orders")
    stacked = np.concatenate(list(hexes.values()))
    width = quad_size(stacked.shape[1])
    quads = {first: block for first, block in first_quad if block.shape[1] == width}
    numbers = np.concatenate([np.arange(f, f + len(b)) for f, b in quads.items()] or [np.empty(0, dtype=np.int64)])
    table = np.concatenate([*quads.values(), np.empty((0, width), dtype=np.int64)])
    named: dict[str, dict[str, IntArray]] = {"BC_t": {}, "GridConnectivity_t": {}}
    for group, label in (("ZoneBC_t", "BC_t"), ("ZoneGridConnectivity_t", "GridConnectivity_t")):
        for own in _children(zone, group):
            for entry in _children(own, label):
                named[label][_text(entry)] = table[np.isin(numbers, _numbers(entry))]
    ends = np.cumsum([len(block) for block in hexes.values()])
    order, known = np.arange(len(stacked)), None
    for user in _children(zone, "UserDefinedData_t"):
        if "HexOrder" in user and len(_data(user["HexOrder"])) == len(stacked):
            order = _data(user["HexOrder"]).astype(np.int64)
        if "NodeOrder" in user:
            known = _data(user["NodeOrder"]).astype(np.int64)
            if len(known) != len(points) or len(order) != len(stacked) or min(known.min(), order.min()) < 0:
                raise InputError("the numbers of a zone in the whole mesh do not fit it")
    names = zip(hexes, np.split(np.arange(len(stacked)) if known is not None else order, ends[:-1]), strict=True)
    parts = {name: np.sort(ids) for name, ids in names}
    if known is None:
        result = np.empty_like(stacked)
        result[order] = stacked
        stacked = result
    mesh = HexMesh(points=points, hexes=stacked, boundaries=named["BC_t"], parts=parts)
    return _Zone(mesh=mesh, nodes=known, hexes=order, contacts=named["GridConnectivity_t"])


def _read_sections(zone: h5py.Group, n_points: int) -> tuple[dict[str, IntArray], list[tuple[int, IntArray]]]:
    """Hexes by section, and quads with the number of the first of each section."""
    hexes: dict[str, IntArray] = {}
    first_quad: list[tuple[int, IntArray]] = []
    sizes = {code: size for size, code in HEX_TYPES.items()}
    widths = {code: size for size, code in QUAD_TYPES.items()}
    for section in sorted(_children(zone, "Elements_t"), key=lambda s: int(_data(s["ElementRange"]).reshape(-1)[0])):
        kind = int(_data(section)[0])
        first = int(_data(section["ElementRange"]).reshape(-1)[0])
        nodes = _data(section["ElementConnectivity"]).astype(np.int64) - 1
        check_nodes(nodes, n_points)
        if kind in sizes:
            hexes[_text(section)] = nodes.reshape(-1, sizes[kind])[:, np.argsort(hex_order(sizes[kind]))]
        elif kind in widths:
            first_quad.append((first, nodes.reshape(-1, widths[kind])[:, np.argsort(quad_order(widths[kind]))]))
        elif kind not in _FLAT_TYPES:
            raise InputError(f"it has elements of the CGNS type {kind}; hexes and quads are read")
    return hexes, first_quad


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
