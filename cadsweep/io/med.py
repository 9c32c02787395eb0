"""MED 4, ``.med``: what Salome and Code_Aster read.

Place in the flow: a format module of :mod:`cadsweep.io`. A MED file is HDF5 of a fixed layout, written with h5py so
that the same mesh gives the same bytes. Every boundary and part is a group; cells in several
groups belong to a family that lists them all. Names have 80 characters at the most.

Not handled on reading: several meshes in a file (the first is read), fields, profiles, polyhedra.

References
----------
MED file format 4.1 (Salome, "MED fichier: modèle de données"); its hexahedra turn the other way round than VTK's: the
bottom 1-2-3-4 is seen from outside counter-clockwise. The orders below equal those that the MED library's own files
show for one hexahedron of each kind (test_med_order).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import BinaryIO

import h5py
import numpy as np

from ..arrays import IntArray
from ..errors import InputError
from ..mesh import HexMesh
from .hdf5 import load
from .labels import Blocks, LabelledMesh, check_nodes

MAX_NAME = 80
HEX_TYPES = {8: ("HE8", 308), 20: ("H20", 320), 27: ("H27", 327)}
QUAD_TYPES = {4: ("QU4", 204), 8: ("QU8", 208), 9: ("QU9", 209)}
_MIRRORED = [0, 3, 2, 1, 4, 7, 6, 5, 11, 10, 9, 8, 15, 14, 13, 12, 16, 19, 18, 17, 24, 20, 23, 21, 22, 25, 26]
HEX_ORDER = {size: np.array(_MIRRORED[:size]) for size in (8, 20, 27)}
"""``med_nodes = vtk_nodes[:, HEX_ORDER[n]]``; quads stand in VTK's order."""

_STEP = "-0000000000000000001-0000000000000000001"
_SOLIDS = {"TE4", "T10", "PY5", "P13", "PE6", "P15", "P18", "HE8", "H20", "H27", "OC6", "OCG"}


def write(stream: BinaryIO, mesh: LabelledMesh) -> None:
    """Write a labelled mesh under the name ``mesh``."""
    # The MED library walks groups in the order in which they were made, so that order is kept.
    with h5py.File(stream, "w", libver=("earliest", "v110"), track_order=True) as file:
        info = file.create_group("INFOS_GENERALES", track_order=True)
        for key, value in (("MAJ", 4), ("MIN", 1), ("REL", 0)):
            info.attrs[key] = np.int32(value)
        root = file.create_group("ENS_MAA/mesh", track_order=True)
        for key, value in (("DIM", 3), ("ESP", 3), ("NXI", -1), ("NXT", -1), ("REP", 0), ("SRT", 0), ("TYP", 0)):
            root.attrs[key] = np.int32(value)
        for key, text in (("DES", "cadsweep"), ("NOM", "x".ljust(16) + "y".ljust(16) + "z".ljust(16))):
            root.attrs[key] = np.bytes_(text)
        for key in ("UNI", "UNT"):
            root.attrs[key] = np.bytes_(" " * (48 if key == "UNI" else 16))
        step = root.create_group(_STEP, track_order=True)
        step.attrs["PDT"] = 0.0
        for key, value in (("CGT", 1), ("NDT", -1), ("NOR", -1), ("NXI", -1), ("NXT", -1), ("PVI", -1), ("PVT", -1)):
            step.attrs[key] = np.int32(value)
        nodes = step.create_group("NOE", track_order=True)
        _mark(nodes)
        _put(nodes, "COO", mesh.points.T.reshape(-1), len(mesh.points))
        _put(nodes, "FAM", np.zeros(len(mesh.points), dtype=np.int64), len(mesh.points))
        cells = step.create_group("MAI", track_order=True)
        cells.attrs["CGT"] = np.int32(1)
        size, width = mesh.hexes.shape[1], mesh.quads.shape[1]
        n_face_families = len(mesh.faces.members)
        if len(mesh.quads):
            _put_cells(cells, QUAD_TYPES[width], mesh.quads, -1 - mesh.faces.of_cell, len(mesh.hexes) + 1)
        hexes = mesh.hexes[:, HEX_ORDER[size]]
        _put_cells(cells, HEX_TYPES[size], hexes, -1 - n_face_families - mesh.volumes.of_cell, 1)
        families = file.create_group("FAS/mesh", track_order=True)
        families.create_group("FAMILLE_ZERO", track_order=True).attrs["NUM"] = np.int32(0)
        elements = families.create_group("ELEME", track_order=True)
        _put_families(elements, "F_2D", mesh.faces, -1)
        _put_families(elements, "F_3D", mesh.volumes, -1 - n_face_families)


def _mark(group: h5py.Group) -> None:
    group.attrs["CGT"] = np.int32(1)
    group.attrs["CGS"] = np.int32(1)
    group.attrs["PFL"] = np.bytes_("MED_NO_PROFILE_INTERNAL")


def _put(group: h5py.Group, name: str, values: np.ndarray, n: int) -> None:
    data = group.create_dataset(name, data=values)
    data.attrs["CGT"] = np.int32(1)
    data.attrs["NBR"] = np.int32(n)


def _put_cells(group: h5py.Group, kind: tuple[str, int], nodes: IntArray, families: IntArray, first: int) -> None:
    cells = group.create_group(kind[0], track_order=True)
    _mark(cells)
    cells.attrs["GEO"] = np.int32(kind[1])
    _put(cells, "NOD", nodes.T.reshape(-1) + 1, len(nodes))
    _put(cells, "NUM", np.arange(first, first + len(nodes)), len(nodes))
    _put(cells, "FAM", families, len(nodes))


def _put_families(group: h5py.Group, stem: str, blocks: Blocks, first: int) -> None:
    for j, names in enumerate(blocks.members):
        family = group.create_group(f"{stem}_{j + 1}", track_order=True)
        family.attrs["NUM"] = np.int32(first - j)
        if names:
            members = family.create_group("GRO", track_order=True)
            members.attrs["NBR"] = np.int32(len(names))
            table = members.create_dataset("NOM", (len(names),), dtype=np.dtype((np.int8, (MAX_NAME,))))
            # Padded with blanks, as the MED library's own writers do.
            table[:] = np.array([list(name.ljust(MAX_NAME).encode()) for name in names], dtype=np.int8)


def read(stream: BinaryIO) -> HexMesh:
    """Read the first mesh of a file, with the groups of its quads and hexes."""
    with h5py.File(stream, "r") as file:
        meshes = file.get("ENS_MAA")
        if not isinstance(meshes, h5py.Group) or not len(meshes):
            raise InputError("it holds no MED mesh")
        name = next(iter(meshes))
        step = meshes[name][next(iter(meshes[name]))]
        if "NOE" not in step or "MAI" not in step:
            raise InputError("its mesh has no nodes or no cells")
        flat = load(step["NOE/COO"])
        n = int(step["NOE/COO"].attrs["NBR"])
        points = np.ascontiguousarray(flat.reshape(-1, n).T, dtype=np.float64)
        if points.shape[1] != 3:
            raise InputError(f"its nodes have {points.shape[1]} coordinates; three are read")
        groups = dict(_families(file.get(f"FAS/{name}/ELEME")))
        cells = step["MAI"]
        solids = [kind for kind in cells if kind in _SOLIDS]
        by_name = {kind: size for size, (kind, _) in HEX_TYPES.items()}
        if not solids:
            raise InputError("it has no hexahedra")
        if len(solids) > 1 or solids[0] not in by_name:
            raise InputError(f"it has cells of the kinds {', '.join(sorted(solids))}; one kind of hex is read")
        size = by_name[solids[0]]
        hexes, hex_families = _cells(cells[solids[0]], size, n)
        width = {8: 4, 20: 8, 27: 9}[size]
        quads, quad_families = np.empty((0, width), dtype=np.int64), np.empty(0, dtype=np.int64)
        if QUAD_TYPES[width][0] in cells:
            quads, quad_families = _cells(cells[QUAD_TYPES[width][0]], width, n)
    parts = {key: np.flatnonzero(found) for key, found in _members(groups, hex_families)}
    boundaries = {key: quads[found] for key, found in _members(groups, quad_families)}
    hexes = np.ascontiguousarray(hexes[:, np.argsort(HEX_ORDER[size])])
    return HexMesh(points=points, hexes=hexes, boundaries=boundaries, parts=parts)


def _cells(group: h5py.Group, size: int, n_points: int) -> tuple[IntArray, IntArray]:
    nodes = load(group["NOD"]).reshape(size, -1).T.astype(np.int64) - 1
    check_nodes(nodes, n_points)
    families = load(group["FAM"]).astype(np.int64) if "FAM" in group else np.zeros(len(nodes), dtype=np.int64)
    if len(families) != len(nodes):
        raise InputError("its families do not fit its cells")
    return nodes, families


def _families(group: h5py.Group | None) -> Iterator[tuple[int, tuple[str, ...]]]:
    for family in (group or {}).values():
        rows = load(family["GRO/NOM"]) if "GRO/NOM" in family else np.empty((0, MAX_NAME), dtype=np.int8)
        names = (np.asarray(row, dtype=np.int8).tobytes().split(b"\0")[0].decode("utf-8", "replace") for row in rows)
        yield int(family.attrs["NUM"]), tuple(name.strip() for name in names)


def _members(groups: dict[int, tuple[str, ...]], families: IntArray) -> Iterator[tuple[str, np.ndarray]]:
    present = set(np.unique(families).tolist())
    names = {name: None for number in sorted(groups, reverse=True) if number in present for name in groups[number]}
    for name in names:
        yield name, np.isin(families, [number for number, members in groups.items() if name in members])
