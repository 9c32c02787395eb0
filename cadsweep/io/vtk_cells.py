"""What the VTK formats (``.vtu``, ``.vtkhdf``, ``.pvtu``) share: cell types, and names as data arrays.

The layout of the arrays is drawn in :mod:`cadsweep.io.vtu`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, BinaryIO

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..lattice import MOST, quad_size
from ..mesh import HexMesh
from .labels import LabelledMesh, check_nodes
from .sides import find_sides

LAGRANGE = 72
CELL_TYPES = {8: 12, 20: 25, 27: 29} | {(order + 1) ** 3: LAGRANGE for order in range(3, MOST + 1)}
"""Nodes of a hex to VTK's cell type; cadsweep's node order is VTK's (``vtkCellType.h``; 72 are Lagrange)."""

NODE_IDS, HEX_IDS, GHOSTS = "GlobalNodeIds", "GlobalHexIds", "vtkGhostType"
"""Data arrays of a grid in pieces; see :mod:`cadsweep.io.pvtu`."""

QUAD_PLACES = "boundary_places:"
"""What stands before the name of a boundary where a piece says which of its quads the piece's own are."""

_COLOR = re.compile(r"#[0-9a-f]{6}([0-9a-f]{2})?\Z")

_FLAT_TYPES = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 68, 69, 70}
"""Cells of fewer than three dimensions, which may stand beside the hexes."""


def grid_arrays(
    mesh: LabelledMesh,
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Cell, field and point arrays that carry the names."""
    part_of_block = [mesh.volumes.names.index(names[0]) for names in mesh.volumes.members]
    cells: dict[str, np.ndarray] = {"part": np.array(part_of_block, dtype=np.int32)[mesh.volumes.of_cell]}
    touched = np.full(len(mesh.hexes), -1, dtype=np.int32)
    if len(mesh.quads):
        face_of_block = [mesh.faces.names.index(names[0]) for names in mesh.faces.members]
        boundary = np.array(face_of_block, dtype=np.int32)[mesh.faces.of_cell]
        # Least boundary last, so that it is the one that stays on a hex with several.
        order = np.argsort(-boundary, kind="stable")
        touched[mesh.sides[0][order]] = boundary[order]
    cells["boundary"] = touched
    fields: dict[str, np.ndarray] = {"part_names": np.array(mesh.volumes.names, dtype=str)}
    if mesh.faces.names:
        fields["boundary_names"] = np.array(mesh.faces.names, dtype=str)
    for name in mesh.faces.names:
        fields[f"boundary:{name}"] = mesh.quads[mesh.faces.named(name)]
    if len(mesh.volumes.names) > 1:
        for name in mesh.volumes.names:
            fields[f"part:{name}"] = mesh.volumes.named(name)
    fields |= color_fields(mesh.info.get("colors", {}), mesh.faces.names, mesh.volumes.names)
    return cells, fields, {}


def color_fields(
    colors: Mapping[str, Mapping[str, str]], boundaries: Sequence[str], parts: Sequence[str]
) -> dict[str, np.ndarray]:
    """Field arrays with the colours of the CAD model; none where there are no colours."""
    fields = {}
    for key, kind, names in (("boundary", "boundaries", boundaries), ("part", "parts", parts)):
        known = colors.get(kind, {})
        if any(name in known for name in names):
            fields[f"{key}_colors"] = np.array([known.get(name, "") for name in names], dtype=str)
    return fields


def colors_of_fields(fields: Mapping[str, Any]) -> dict[str, Any]:
    """What ``HexMesh.info`` holds of the colours in field arrays."""
    colors: dict[str, dict[str, str]] = {}
    for key, kind in (("boundary", "boundaries"), ("part", "parts")):
        pairs = zip(fields.get(f"{key}_names", ()), fields.get(f"{key}_colors", ()), strict=False)
        colors[kind] = {str(name): str(color) for name, color in pairs if _COLOR.match(str(color))}
    return {"colors": colors} if any(colors.values()) else {}


def grid_mesh(
    *,
    points: FloatArray,
    connectivity: IntArray,
    offsets: IntArray,
    types: IntArray,
    cell_data: dict[str, Any],
    field_data: dict[str, Any],
) -> HexMesh:
    """Make a mesh of a VTK grid's arrays; cells of fewer than three dimensions are left out."""
    hexes, is_hex = hexes_of_cells(connectivity, offsets, types)
    check_nodes(hexes, len(points))
    boundaries = {}
    width = quad_size(hexes.shape[1])
    for name in field_data.get("boundary_names", []):
        quads = np.asarray(field_data.get(f"boundary:{name}", np.empty((0, width))), dtype=np.int64)
        boundaries[str(name)] = quads.reshape(-1, width)
    parts = {}
    names = [str(name) for name in field_data.get("part_names", [])]
    if len(names) == 1:
        parts[names[0]] = np.arange(len(hexes))
    elif names:
        of_hex = np.asarray(cell_data.get("part", np.zeros(len(is_hex))))[is_hex]
        for j, name in enumerate(names):
            stored = field_data.get(f"part:{name}")
            parts[name] = np.flatnonzero(of_hex == j) if stored is None else np.asarray(stored, dtype=np.int64)
    info = colors_of_fields(field_data)
    return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts=parts, info=info)


def join_pieces(
    points: FloatArray,
    connectivity: IntArray,
    offsets: IntArray,
    *,
    point_data: dict[str, Any],
    cell_data: dict[str, Any],
) -> tuple[FloatArray, IntArray, IntArray]:
    """Join pieces of 8-node cells by their global ids; cells that are another piece's ghosts are left out.

    Returns
    -------
    points : (n, 3) float64
        By global id.
    connectivity : (8 * m,) int64
    kept : (m,) int64
        The cells that were kept, in the order of their global ids.
    """
    if (np.diff(offsets) != 8).any():
        raise InputError("its pieces hold cells that are no hexahedra of 8 nodes")
    ids = np.asarray(point_data[NODE_IDS], dtype=np.int64)
    joined = np.full((int(np.max(ids)) + 1, 3), np.nan)
    joined[ids] = points
    own = np.flatnonzero(np.asarray(cell_data.get(GHOSTS, np.zeros(len(offsets) - 1))) == 0)
    kept = own[np.argsort(np.asarray(cell_data[HEX_IDS])[own], kind="stable")]
    return joined, ids[connectivity.reshape(-1, 8)[kept]].reshape(-1), kept


def hexes_of_cells(connectivity: IntArray, offsets: IntArray, types: IntArray) -> tuple[IntArray, np.ndarray]:
    """Hexes (m, 8 | 20 | (p + 1)^3) of a list of mixed cells, and which cells they are."""
    types = np.asarray(types)
    sizes = np.diff(offsets)
    if len(sizes) != len(types) or (sizes < 0).any() or (len(offsets) and offsets[-1] > len(connectivity)):
        raise InputError("its list of cells is cut short or does not fit together")
    solid = ~np.isin(types, list(_FLAT_TYPES))
    kinds = sorted(set(types[solid].tolist()))
    if not kinds:
        raise InputError("it has no hexahedra")
    if len(kinds) > 1 or kinds[0] not in CELL_TYPES.values():
        raise InputError(f"it has cells of the VTK types {', '.join(map(str, kinds))}; one kind of hexahedron is read")
    size = int(sizes[solid][0])
    if (sizes[solid] != size).any() or CELL_TYPES.get(size) != kinds[0]:
        known = sorted(nodes for nodes, code in CELL_TYPES.items() if code == kinds[0])
        raise InputError(f"its hexahedra should have one number of nodes, of {', '.join(map(str, known))}")
    if solid.all():
        return connectivity[: len(types) * size].reshape(-1, size), solid
    return connectivity[offsets[:-1][solid][:, None] + np.arange(size)], solid


def offsets(hexes: IntArray) -> IntArray:
    """Where each hex begins in the flat connectivity, and where the last one ends."""
    return np.arange(0, hexes.size + 1, hexes.shape[1], dtype=np.int64)


def types(hexes: IntArray) -> np.ndarray:
    """VTK's cell type of each hex."""
    return np.full(len(hexes), CELL_TYPES[hexes.shape[1]], dtype=np.uint8)


def write_bytes(stream: BinaryIO, data: np.ndarray) -> None:
    """Write an array's bytes, all of them: an unbuffered stream may take fewer at a time."""
    view = np.ascontiguousarray(data).reshape(-1).view(np.uint8).data
    while len(view):
        view = view[stream.write(view[: 1 << 30]) :]


__all__ = [
    "CELL_TYPES",
    "GHOSTS",
    "HEX_IDS",
    "LAGRANGE",
    "NODE_IDS",
    "QUAD_PLACES",
    "color_fields",
    "colors_of_fields",
    "find_sides",
    "grid_arrays",
    "grid_mesh",
    "hexes_of_cells",
    "join_pieces",
    "offsets",
    "types",
    "write_bytes",
]
