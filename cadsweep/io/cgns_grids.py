"""Structured zones of a CGNS file: a block each, with boundary conditions and ``GridConnectivity1to1_t``.

Place in the flow: for :mod:`.cgns`, where its option `structured` is set. Blocks are those of :mod:`.grids`; a zone is
of the family of its part. A boundary has a ``BC_t`` of its family for each rectangle of a side that it covers, by the
range of its nodes; named quads inside, as interfaces are, are words of a ``Descriptor_t`` of the rectangle where blocks
meet, on the side for which they point outwards. Under ``UserDefinedData_t`` stand the mesh's numbers: ``NodeOrder``,
``HexOrder``, and ``HexCorners``, which corner of a cell each of a hexahedron is, where they begin elsewhere.

References
----------
CGNS SIDS, "Zone_t", "1-to-1 interface connectivity structure".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import h5py
import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from ..mesh import HexMesh
from .cgns_nodes import children, data, node, text
from .grids import find_grids
from .labels import LabelledMesh
from .patches import AXES, NORMALS, Patch, Range, find_patches, join, joined_mesh

_WORDS = "Boundary"


def write_grids(base: h5py.Group, mesh: LabelledMesh, most: int, whole: Any) -> None:
    """Write the blocks of a mesh into a base."""
    grids = find_grids(mesh, most=most)
    parts = mesh.volumes.exclusive_names()
    zones, shapes = [], grids.shapes.tolist()
    for block, shape in enumerate(shapes):
        sizes = np.array([[n + 1 for n in shape], shape, [0, 0, 0]], dtype=whole)
        zone = node(base, f"Block_{block + 1}", "Zone_t", sizes)
        zones.append(zone)
        node(zone, "ZoneType", "ZoneType_t", "Structured")
        nodes, own = grids.nodes(block), slice(grids.first[block], grids.first[block + 1])
        grid = node(zone, "GridCoordinates", "GridCoordinates_t", None)
        for axis, name in enumerate("XYZ"):
            node(grid, f"Coordinate{name}", "DataArray_t", mesh.points[nodes, axis])
        node(zone, "FamilyName", "FamilyName_t", parts[mesh.volumes.of_cell[grids.order[own.start]]])
        user = node(zone, "UserData", "UserDefinedData_t", None)
        node(user, "NodeOrder", "DataArray_t", nodes)
        node(user, "HexOrder", "DataArray_t", grids.order[own])
        corners = (mesh.hexes[grids.order[own], :, None] == grids.hexes[own, None, :]).argmax(axis=2)
        if (corners != np.arange(8)).any():
            node(user, "HexCorners", "DataArray_t", corners.astype(np.int32))
    for name in dict.fromkeys((*mesh.faces.names, *parts)):
        node(base, name, "Family_t", None)
    for patch in find_patches(mesh, grids):
        names = mesh.faces.members[patch.label] if patch.label >= 0 else ()
        if patch.there is None:
            for name in names:
                _condition(zones[patch.here.block], name, patch.here.nodes(shapes[patch.here.block]), whole)
            continue
        there_names = mesh.faces.members[patch.there_label] if patch.there_label >= 0 else ()
        _match(zones, shapes, patch, names, whole)
        _match(zones, shapes, _seen_from_there(patch), there_names, whole)


def _free(group: h5py.Group, stem: str) -> str:
    """The stem, or with a number where it is taken."""
    name, count = stem, 1
    while name in group:
        count += 1
        name = f"{stem[:24]}_{count}"
    return name


def _under(zone: h5py.Group, name: str) -> h5py.Group:
    return zone[name] if name in zone else node(zone, name, f"{name}_t", None)


def _range(ends: tuple[tuple[int, ...], tuple[int, ...]], whole: Any) -> np.ndarray:
    return np.array(ends, dtype=whole) + np.array(1, dtype=whole)


def _condition(zone: h5py.Group, name: str, ends: tuple[tuple[int, ...], tuple[int, ...]], whole: Any) -> None:
    conditions = _under(zone, "ZoneBC")
    condition = node(conditions, _free(conditions, name), "BC_t", "FamilySpecified")
    node(condition, "PointRange", "IndexRange_t", _range(ends, whole))
    node(condition, "FamilyName", "FamilyName_t", name)


def _seen_from_there(patch: Patch) -> Patch:
    """The same rectangle from the other side, ascending there."""
    assert patch.there is not None
    here, there = ([list(part.begin), list(part.end)] for part in (patch.there, patch.here))
    for k in range(2):
        if here[0][k] > here[1][k]:
            for ends, j in ((here, k), (there, 1 - k if patch.swapped else k)):
                ends[0][j], ends[1][j] = ends[1][j], ends[0][j]
    parts = [
        replace(part, begin=(ends[0][0], ends[0][1]), end=(ends[1][0], ends[1][1]))
        for part, ends in ((patch.there, here), (patch.here, there))
    ]
    return Patch(here=parts[0], label=patch.there_label, there=parts[1], swapped=patch.swapped)


def _match(
    zones: Sequence[h5py.Group], shapes: list[list[int]], patch: Patch, names: Sequence[str], whole: Any
) -> None:
    here, there = patch.here, patch.there
    assert there is not None
    group = _under(zones[here.block], "ZoneGridConnectivity")
    match = node(group, _free(group, "Match"), "GridConnectivity1to1_t", text(zones[there.block]))
    node(match, "PointRange", "IndexRange_t", _range(here.nodes(shapes[here.block]), whole))
    node(match, "PointRangeDonor", "IndexRange_t", _range(there.nodes(shapes[there.block]), whole))
    node(match, "Transform", '"int[IndexDimension]"', _transform(patch))
    if names:
        node(match, _WORDS, "Descriptor_t", " ".join(names))


def _transform(patch: Patch) -> np.ndarray:
    """For i, j and k here the axis there, from 1, minus where it runs the other way."""
    here, there = patch.here, patch.there
    assert there is not None
    found = np.zeros(3, dtype=np.int32)
    # Out of a greatest side one enters at a least one along the positive axis.
    sign = 1 if here.side % 2 != there.side % 2 else -1
    found[NORMALS[here.side]] = sign * (NORMALS[there.side] + 1)
    for k in range(2):
        other = 1 - k if patch.swapped else k
        rises = [part.end[j] > part.begin[j] for part, j in ((here, k), (there, other))]
        found[AXES[here.side][k]] = (AXES[there.side][other] + 1) * (1 if rises[0] == rises[1] else -1)
    return found


def is_grid(zone: h5py.Group) -> bool:
    """Whether a zone is a structured one."""
    kinds = [data(kind).tobytes() for kind in children(zone, "ZoneType_t")]
    return kinds == [b"Structured"]


def read_grids(zones: Sequence[h5py.Group]) -> HexMesh:
    """One mesh of structured zones, by the numbers that they bring along or by where they meet.

    Raises
    ------
    InputError
        A zone is not of three dimensions, or a range names no rectangle of a side.
    """
    shapes = []
    for zone in zones:
        sizes = data(zone)
        if sizes.shape != (3, 3):
            raise InputError("a structured zone has not three dimensions")
        shapes.append((int(sizes[0, 0]), int(sizes[0, 1]), int(sizes[0, 2])))
    places = [_places(zone, shape) for zone, shape in zip(zones, shapes, strict=True)]
    named = [own for block, zone in enumerate(zones) for own in _named(block, zone, shapes[block])]
    names = {text(zone): block for block, zone in enumerate(zones)}
    shared = []
    for block, zone in enumerate(zones):
        for match in _entries(zone, "ZoneGridConnectivity_t", "GridConnectivity1to1_t"):
            donor = names.get(data(match).tobytes().decode(), -1)
            if donor < 0:
                raise InputError("a zone meets one that is not there")
            here = _side(block, data(match["PointRange"]), shapes[block])
            there = _side(donor, data(match["PointRangeDonor"]), shapes[donor])
            turned = abs(int(data(match["Transform"])[AXES[here.side][0]])) - 1
            shared.append((here, there, turned != AXES[there.side][0]))
            words = [data(own).tobytes().decode() for own in children(match, "Descriptor_t") if text(own) == _WORDS]
            named += [(name, here) for own in words for name in own.split()]
    families = [_family(zone) for zone in zones]
    parts = [name for name in families if name is not None]
    parts = parts if len(parts) == len(zones) else []
    if all("UserData" in zone and "NodeOrder" in zone["UserData"] for zone in zones):
        return _numbered(places, [zone["UserData"] for zone in zones], named, parts)
    points, nodes = join(places, shared, shapes)
    return joined_mesh(points, nodes, named, parts)


def _entries(zone: h5py.Group, group: str, label: str) -> list[h5py.Group]:
    return [entry for own in children(zone, group) for entry in children(own, label)]


def _family(of: h5py.Group) -> str | None:
    own = next(children(of, "FamilyName_t"), None)
    return None if own is None else str(data(own).tobytes().decode())


def _places(zone: h5py.Group, shape: tuple[int, int, int]) -> FloatArray:
    """Points (n, 3) of a zone, i running fastest."""
    grid = next(children(zone, "GridCoordinates_t"), None)
    if grid is None or any(f"Coordinate{axis}" not in grid for axis in "XYZ"):
        raise InputError("it has no Cartesian coordinates in three dimensions")
    own = [data(grid[f"Coordinate{axis}"]) for axis in "XYZ"]
    if any(values.shape != shape[::-1] for values in own):
        raise InputError("a zone has not as many nodes as it says")
    return np.column_stack([values.ravel() for values in own]).astype(np.float64)


def _named(block: int, zone: h5py.Group, shape: tuple[int, int, int]) -> list[tuple[str, Range]]:
    """Rectangles of a zone with a condition, by their family, or the condition's own name."""
    found = []
    for condition in _entries(zone, "ZoneBC_t", "BC_t"):
        if "PointRange" in condition:
            found.append((_family(condition) or text(condition), _side(block, data(condition["PointRange"]), shape)))
    return found


def _numbered(
    places: Sequence[FloatArray], user: Sequence[h5py.Group], named: list[tuple[str, Range]], parts: list[str]
) -> HexMesh:
    """The mesh by its own numbers."""
    nodes = [data(own["NodeOrder"]).astype(np.int64) for own in user]
    numbers = np.concatenate([own.ravel() for own in nodes])
    order = np.concatenate([data(own["HexOrder"]).astype(np.int64) for own in user])
    if len(numbers) != sum(map(len, places)) or (np.sort(order) != np.arange(len(order))).any() or numbers.min() < 0:
        raise InputError("the numbers of a zone in the whole mesh do not fit it")
    points = np.full((int(numbers.max()) + 1, 3), np.nan)
    points[numbers] = np.concatenate(places)
    mesh = joined_mesh(points, nodes, named, parts)
    if np.isnan(points).any() or len(order) != len(mesh.hexes):
        raise InputError("its zones do not make one mesh: nodes or hexes are missing")
    ends = np.cumsum([(own.shape[0] - 1) * (own.shape[1] - 1) * (own.shape[2] - 1) for own in nodes])[:-1]
    hexes = np.empty_like(mesh.hexes)
    for own, ids, cells in zip(user, np.split(order, ends), np.split(mesh.hexes, ends), strict=True):
        corners = data(own["HexCorners"]) if "HexCorners" in own else np.broadcast_to(np.arange(8), cells.shape)
        hexes[ids] = np.take_along_axis(cells, corners.astype(np.int64), axis=1)
    kept = {name: np.sort(order[ids]) for name, ids in mesh.parts.items()}
    return HexMesh(points=points, hexes=hexes, boundaries=mesh.boundaries, parts=kept)


def _side(block: int, ends: np.ndarray, shape: tuple[int, int, int]) -> Range:
    """The rectangle between two nodes, from 1."""
    if ends.shape != (2, 3):
        raise InputError("a range of nodes has not three dimensions")
    begin, end = (ends - 1).tolist()
    for axis in range(3):
        if begin[axis] == end[axis] and begin[axis] in {0, shape[axis] - 1}:
            side = next(s for s in range(6) if NORMALS[s] == axis and s % 2 == (begin[axis] > 0))
            first, second = AXES[side]
            return Range(block=block, side=side, begin=(begin[first], begin[second]), end=(end[first], end[second]))
    raise InputError("a range of nodes is no rectangle of a zone's side")
