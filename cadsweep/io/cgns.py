"""CGNS in its HDF5 form, ``.cgns``.

Place in the flow: a format module of :mod:`cadsweep.io`. One base. A mesh with interfaces between its parts has a zone
a part, and a ``GridConnectivity_t`` (``Abutting1to1``, of faces) an interface in both of its zones; any other mesh is
one zone (:mod:`.cgns_zones`). In a zone: an element section a part, an
element section a disjoint block of boundary quads, and a boundary condition (``BC_t`` of the family of the same name)
a boundary, by the numbers of its quads, so that boundaries may overlap. Sections are disjoint: where parts overlap, the
names of :meth:`~cadsweep.io.labels.Blocks.exclusive_names` stand. Names have 32 characters at the most.

With the option `structured` the zones are structured blocks (:mod:`.cgns_grids`).

Written with h5py: gmsh's writer numbers the nodes anew. Where parts are not runs of hexes, or zones, an array
``HexOrder`` under ``UserDefinedData_t`` keeps the mesh's order, and ``NodeOrder`` says which nodes a zone's are.

Not handled on reading: several zones that do not say so, mixed sections, boundary conditions by ranges of nodes, ADF
files.

References
----------
CGNS SIDS, "Element numbering conventions" (HEXA_8, HEXA_20, HEXA_27), and "SIDS-to-HDF5 file mapping" (cgns.github.io).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, BinaryIO

import h5py
import numpy as np

from ..arrays import IntArray
from ..contacts import solids_of
from ..errors import InputError
from ..lattice import quad_size
from ..mesh import HexMesh
from .cgns_grids import is_grid, read_grids, write_grids
from .cgns_nodes import attributes, children, data, node, text
from .cgns_orders import HEX_TYPES, QUAD_TYPES, hex_order, quad_order
from .cgns_zones import RESERVED, ZonePiece, turned_quads, zone_pieces
from .compare import Groups, all_boundaries, disjoint_parts
from .grids import MOST_BLOCKS
from .labels import LabelledMesh, check_nodes

MAX_NAME = 32
MOST_ORDER = 4

_FLAT_TYPES = {2, 3, 4, 5, 6, 7, 8, 9, 24, 25, 26, 27, 28, 40, 41, 42, 43, 44}


def kept_groups(mesh: LabelledMesh, **_options: object) -> Groups:
    """Boundaries may overlap, sections of hexes may not."""
    return all_boundaries(mesh), disjoint_parts(mesh)


def write(stream: BinaryIO, mesh: LabelledMesh, *, structured: bool = False, max_blocks: int = MOST_BLOCKS) -> None:
    """Write a labelled mesh.

    Parameters
    ----------
    structured : bool
        Write structured zones, a block each (:mod:`.grids`), instead of unstructured ones.
    max_blocks : int
        Structured blocks of a part at the most; a mesh of more was not mapped.
    """
    n, size = len(mesh.points), mesh.hexes.shape[1]
    whole: Any = np.int32 if max(n, len(mesh.hexes) * size) < 1 << 31 else np.int64
    with h5py.File(stream, "w", libver=("earliest", "v110"), track_order=True) as file:
        attributes(file, "HDF5 MotherNode", "Root Node of HDF5 File", "MT")
        file[" format"] = np.frombuffer(b"IEEE_LITTLE_32\0", dtype=np.int8)
        file[" hdf5version"] = np.frombuffer(b"HDF5 Version 1.10.0".ljust(33, b"\0"), dtype=np.int8)
        node(file, "CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([3.4], dtype=np.float32))
        base = node(file, "Base", "CGNSBase_t", np.array([3, 3], dtype=np.int32))
        if structured:
            if size != 8:
                raise InputError("structured zones have corners alone; make the mesh with order=1")
            write_grids(base, mesh, max_blocks, whole)
            return
        pieces = zone_pieces(mesh)
        numbers = [_write_zone(base, mesh, piece, whole) for piece in pieces]
        for name in mesh.faces.names:
            if name not in pieces[0].contacts:
                node(base, name, "Family_t", None)
        _connect(base, mesh, pieces, numbers, whole)


def _write_zone(base: h5py.Group, mesh: LabelledMesh, piece: ZonePiece, whole: Any) -> IntArray:
    """Write one zone; returns the numbers that its elements have of the mesh's quads, 0 where it has none."""
    size, width = mesh.hexes.shape[1], mesh.quads.shape[1]
    hexes, quads = piece.numbered(mesh.hexes), mesh.quads[piece.quads]
    quads = piece.numbered(np.where(piece.turned[:, None], turned_quads(quads), quads))
    shape = np.array([[len(piece.nodes)], [len(piece.hexes)], [0]], dtype=whole)
    zone = node(base, piece.name, "Zone_t", shape)
    node(zone, "ZoneType", "ZoneType_t", "Unstructured")
    grid = node(zone, "GridCoordinates", "GridCoordinates_t", None)
    for axis, name in enumerate("XYZ"):
        node(grid, f"Coordinate{name}", "DataArray_t", np.ascontiguousarray(mesh.points[piece.nodes, axis]))
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
        conditions = node(zone, "ZoneBC", "ZoneBC_t", None)
    for name, numbers in named.items():
        if len(numbers):
            condition = node(conditions, name, "BC_t", "FamilySpecified")
            node(condition, "PointList", "IndexArray_t", numbers.astype(whole)[:, None])
            node(condition, "GridLocation", "GridLocation_t", "FaceCenter")
            node(condition, "FamilyName", "FamilyName_t", name)
    order = np.concatenate(orders)
    if piece.is_part or (np.diff(order) < 0).any():
        user = node(zone, "UserData", "UserDefinedData_t", None)
        node(user, "HexOrder", "DataArray_t", order)
        if piece.is_part:
            node(user, "NodeOrder", "DataArray_t", piece.nodes)
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
                node(zone, "ZoneGridConnectivity", "ZoneGridConnectivity_t", None)
            own = node(zone["ZoneGridConnectivity"], contact, "GridConnectivity_t", pieces[there].name)
            node(own, "GridConnectivityType", "GridConnectivityType_t", "Abutting1to1")
            node(own, "GridLocation", "GridLocation_t", "FaceCenter")
            quads = mesh.faces.named(contact)
            for name, side in (("PointList", here), ("PointListDonor", there)):
                node(own, name, "IndexArray_t", numbers[side][quads].astype(whole)[:, None])


def _section(zone: h5py.Group, name: str, kind: int, nodes: IntArray, *, first: int, whole: Any) -> None:
    section = node(zone, name, "Elements_t", np.array([kind, 0], dtype=np.int32))
    node(section, "ElementRange", "IndexRange_t", np.array([first, first + len(nodes) - 1], dtype=whole))
    node(section, "ElementConnectivity", "DataArray_t", nodes.reshape(-1).astype(whole))


def read(stream: BinaryIO) -> HexMesh:
    """Read the one zone of a file, or the zones of the parts of one mesh."""
    with h5py.File(stream, "r") as file:
        zones = [zone for base in children(file, "CGNSBase_t") for zone in children(base, "Zone_t")]
        if zones and all(map(is_grid, zones)):
            return read_grids(zones)
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
    grids = list(children(zone, "GridCoordinates_t"))
    if not grids or any(f"Coordinate{axis}" not in grids[0] for axis in "XYZ"):
        raise InputError("it has no Cartesian coordinates in three dimensions")
    points = np.column_stack([data(grids[0][f"Coordinate{axis}"]) for axis in "XYZ"]).astype(np.float64)
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
        for own in children(zone, group):
            for entry in children(own, label):
                named[label][text(entry)] = table[np.isin(numbers, _numbers(entry))]
    ends = np.cumsum([len(block) for block in hexes.values()])
    order, known = np.arange(len(stacked)), None
    for user in children(zone, "UserDefinedData_t"):
        if "HexOrder" in user and len(data(user["HexOrder"])) == len(stacked):
            order = data(user["HexOrder"]).astype(np.int64)
        if "NodeOrder" in user:
            known = data(user["NodeOrder"]).astype(np.int64)
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
    for section in sorted(children(zone, "Elements_t"), key=lambda s: int(data(s["ElementRange"]).reshape(-1)[0])):
        kind = int(data(section)[0])
        first = int(data(section["ElementRange"]).reshape(-1)[0])
        nodes = data(section["ElementConnectivity"]).astype(np.int64) - 1
        check_nodes(nodes, n_points)
        if kind in sizes:
            hexes[text(section)] = nodes.reshape(-1, sizes[kind])[:, np.argsort(hex_order(sizes[kind]))]
        elif kind in widths:
            first_quad.append((first, nodes.reshape(-1, widths[kind])[:, np.argsort(quad_order(widths[kind]))]))
        elif kind not in _FLAT_TYPES:
            raise InputError(f"it has elements of the CGNS type {kind}; hexes and quads are read")
    return hexes, first_quad


def _numbers(condition: h5py.Group) -> IntArray:
    if "PointList" in condition:
        return data(condition["PointList"]).reshape(-1).astype(np.int64)
    if "PointRange" in condition:
        low, high = data(condition["PointRange"]).reshape(-1)[:2].tolist()
        return np.arange(low, high + 1)
    return np.empty(0, dtype=np.int64)
