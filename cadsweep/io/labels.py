"""A mesh made ready for writing: names made portable, every boundary quad once, groups as disjoint blocks.

Place in the flow: :func:`cadsweep.io.write` labels a mesh once; every writer takes the result. Formats differ in what
they allow: several groups on one cell (msh 4.1, MED, node and side sets), or one only (msh 2.2, OpenFOAM patches, MFEM
attributes). The disjoint blocks serve both: a block is the set of all cells that carry the same set of names.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from ..errors import InputError
from ..lattice import MOST, order_of, quad_size
from ..mesh import HexMesh
from .names import portable_names
from .sides import corner_keys, find_sides

logger = logging.getLogger(__name__)

DEFAULT_PART = "volume"
"""Name of the hexes that belong to no part."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Blocks:
    """Named, possibly overlapping sets of cells as disjoint blocks.

    Attributes
    ----------
    names : tuple of str
        Every name, in the mesh's order.
    members : tuple of tuple of str
        The names that the cells of each block carry; blocks with no name have ``()``.
    of_cell : (n,) int64
        Block of each cell.
    max_name : int
        Most characters of a name.
    """

    names: tuple[str, ...]
    members: tuple[tuple[str, ...], ...]
    of_cell: IntArray
    max_name: int = 80

    def cells(self, block: int) -> IntArray:
        """Ids of the cells of a block, ascending."""
        if len(self.members) == 1:
            return np.arange(len(self.of_cell))
        return np.flatnonzero(self.of_cell == block)

    def named(self, name: str) -> IntArray:
        """Ids of the cells that carry a name, ascending."""
        wanted = np.array([name in names for names in self.members], dtype=bool)
        return np.flatnonzero(wanted[self.of_cell])

    def exclusive_names(self) -> tuple[str, ...]:
        """One name a block, for formats that allow one group a cell.

        The rule: a block takes the first of its names that no other block shares. Where there is none its names are
        joined by ``_and_``; and a block with one name that other blocks share too is ``<name>_only``. A block without
        a name is ``unnamed``.
        """
        uses = {name: sum(name in names for names in self.members) for name in self.names}
        chosen = []
        for names in self.members:
            own = [name for name in names if uses[name] == 1]
            if own:
                chosen.append(own[0])
            elif not names:
                chosen.append("unnamed")
            else:
                chosen.append(f"{names[0]}_only" if len(names) == 1 else "_and_".join(names))
        return tuple(portable_names(_distinct(chosen, reserved=self.names), max_length=self.max_name).values())


def _distinct(chosen: list[str], *, reserved: tuple[str, ...]) -> list[str]:
    result: list[str] = []
    for name in chosen:
        candidate, count = name, 1
        while candidate in result or (candidate != name and candidate in reserved):
            count += 1
            candidate = f"{name}_{count}"
        result.append(candidate)
    return result


@dataclass(frozen=True, kw_only=True, eq=False)
class LabelledMesh:
    """What a writer gets.

    Attributes
    ----------
    points : (n, 3) float64
    hexes : (m, 8 | 20 | (p + 1)^3) int64
        VTK order.
    quads : (q, 4 | 8 | (p + 1)^2) int64
        Every boundary quad once, in the order in which the boundaries name them.
    faces : Blocks
        Named boundaries, over `quads`.
    volumes : Blocks
        Parts, over `hexes`; every hex has a name.
    info : dict
    periodic : dict of (str, str) to (p, 2) int64
        Nodes of the first boundary, and of the second those that answer them.
    """

    points: FloatArray
    hexes: IntArray
    quads: IntArray
    faces: Blocks
    volumes: Blocks
    info: dict[str, Any] = field(default_factory=dict)
    periodic: dict[tuple[str, str], IntArray] = field(default_factory=dict)

    @cached_property
    def sides(self) -> tuple[IntArray, IntArray]:
        """Hex and side (row of :data:`~cadsweep.cells.HEX_FACES`) of every quad."""
        return find_sides(self.hexes, self.quads, len(self.points))

    @cached_property
    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest coordinates, (3,) and (3,)."""
        return bounds_of(self.points)

    @cached_property
    def block_bounds(self) -> list[tuple[FloatArray, FloatArray]]:
        """The same of the corners of each block of quads."""
        blocks = range(len(self.faces.members))
        return [bounds_of(self.points[self.quads[self.faces.cells(j), :4].reshape(-1)]) for j in blocks]

    def mesh(self) -> HexMesh:
        """The mesh that a reader of a format without limits gives back."""
        return HexMesh(
            points=self.points,
            hexes=self.hexes,
            boundaries={name: self.quads[self.faces.named(name)] for name in self.faces.names},
            parts={name: self.volumes.named(name) for name in self.volumes.names},
        )


def bounds_of(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Least and greatest coordinates of points (n, 3).

    numpy reduces many rows of three slowly and few long ones fast, so rows are taken 256 at a time.
    """
    n_long = len(points) // 256 * 256
    rows, rest = points[:n_long].reshape(-1, 256 * 3), points[n_long:]
    if len(rows) == 0:
        return np.min(rest, axis=0), np.max(rest, axis=0)
    low = np.vstack([rows.min(axis=0).reshape(-1, 3), rest]).min(axis=0)
    return low, np.vstack([rows.max(axis=0).reshape(-1, 3), rest]).max(axis=0)


def label_mesh(
    mesh: HexMesh, *, max_name: int = 80, reserved: Collection[str] = (), most_order: int = MOST
) -> LabelledMesh:
    """Check a mesh's arrays and make them ready for writing.

    Raises
    ------
    InputError
        Arrays of the wrong shape, ids out of range, or coordinates that are not finite: no file of that is written.
    """
    points = np.ascontiguousarray(mesh.points, dtype=np.float64)
    hexes = np.ascontiguousarray(mesh.hexes, dtype=np.int64)
    if points.ndim != 2 or points.shape[1:] != (3,):
        raise InputError(f"points should have the shape (n, 3), not {points.shape}")
    if hexes.ndim != 2 or not order_of(hexes.shape[1]):
        raise InputError(f"hexes should have the shape (m, 8), (m, 20) or (m, (p + 1)^3), not {hexes.shape}")
    if mesh.order > most_order:
        raise InputError(
            f"the format has no hexahedra of order {mesh.order}; write .vtu, .vtkhdf, .msh or .mesh, "
            f"or take order={most_order}"
        )
    if len(hexes) == 0:
        raise InputError("the mesh has no hexes; there is nothing to write")
    # What is not finite makes the sum so, in one pass; a sum of finite numbers may still overflow.
    with np.errstate(invalid="ignore", over="ignore"):
        is_finite = np.isfinite(points.sum()) or np.isfinite(points).all()
    if not is_finite:
        raise InputError("the mesh has coordinates that are not finite")
    _check_ids(hexes, len(points), "hexes", "nodes")
    # An interface is a named set of quads as a boundary is: its name tells them apart, and its place inside the mesh.
    named = mesh.named_quads()
    boundaries = _renamed(named, max_name, reserved)
    width = quad_size(hexes.shape[1])
    for name, quads in boundaries.items():
        if quads.ndim != 2 or quads.shape[1] != width:
            raise InputError(f"boundary {name!r} should have the shape (q, {width}), not {quads.shape}")
        _check_ids(quads, len(points), f"boundary {name!r}", "nodes")
    parts = _renamed(mesh.parts, max_name, reserved)
    materials = _materials(mesh)
    for name, ids in parts.items():
        if ids.ndim != 1:
            raise InputError(f"part {name!r} should hold hex ids in one dimension, not {ids.shape}")
        _check_ids(ids, len(hexes), f"part {name!r}", "hexes")
    info = {**mesh.info, "materials": materials, "colors": _recolored(mesh.info, named, boundaries, mesh.parts, parts)}
    boundaries, parts = _without_empty(boundaries, "boundary"), _without_empty(parts, "part")
    quads, faces = _face_blocks(boundaries, width)
    faces = replace(faces, max_name=max_name)
    volumes = replace(_volume_blocks(parts, len(hexes)), max_name=max_name)
    renamed = dict(zip(named, _renamed(named, max_name, reserved), strict=True))
    periodic = {(renamed[one], renamed[other]): pairs for (one, other), pairs in _partners(mesh).items()}
    return LabelledMesh(
        points=points, hexes=hexes, quads=quads, faces=faces, volumes=volumes, info=info, periodic=periodic
    )


def _partners(mesh: HexMesh) -> dict[tuple[str, str], IntArray]:
    """Pairs of nodes by the names of two boundaries; of faces that are several, each with the one that it answers."""
    found: dict[tuple[str, str], IntArray] = {}
    for key, pairs in mesh.periodic.items():
        own: dict[tuple[str, str], IntArray] = {}
        for place in (match.start() for match in re.finditer("(?=__)", key)):
            groups = [_boundaries_in(mesh, words) for words in (key[:place], key[place + 2 :])]
            if all(groups):
                own = _answering(mesh, groups[0], groups[1], pairs)
                break
        if not own:
            logger.warning("periodic '%s': its boundaries do not answer each other one by one; no file says so", key)
        found |= own
    return found


def _boundaries_in(mesh: HexMesh, words: str) -> list[str]:
    """The boundaries that a name of matched faces lists; none where a part of it is none."""
    names = [words] if words in mesh.boundaries else words.split("_and_")
    return names if all(name in mesh.boundaries for name in names) else []


def _answering(
    mesh: HexMesh, ones: Sequence[str], others: Sequence[str], pairs: IntArray
) -> dict[tuple[str, str], IntArray]:
    """Boundaries of two groups whose nodes are each other's images, and their own pairs; none unless all have one."""
    if len(ones) == len(others) == 1:
        return {(ones[0], others[0]): pairs}
    nodes = {name: distinct(mesh.boundaries[name]) for name in (*ones, *others)}
    found: dict[tuple[str, str], IntArray] = {}
    for one in ones:
        own = pairs[np.isin(pairs[:, 0], nodes[one])]
        images = np.sort(own[:, 1])
        found |= {(one, other): own for other in others if np.array_equal(images, nodes[other])}
    return found if len(found) == len(ones) == len(others) else {}


def check_nodes(ids: np.ndarray, n_points: int) -> None:
    """Refuse cells of a file that name nodes it does not have.

    Raises
    ------
    InputError
    """
    if ids.size and (int(np.min(ids)) < 0 or int(np.max(ids)) >= n_points):
        raise InputError("a cell names a node that is not there")


def _check_ids(ids: IntArray, n: int, what: str, of: str) -> None:
    # Seen as unsigned a negative id is larger than any other: one pass instead of two.
    if ids.size and int(np.max(ids.view(np.uint64))) >= n:
        low, high = int(np.min(ids)), int(np.max(ids))
        raise InputError(f"{what}: ids should lie between 0 and {n - 1} ({of}), found {low} to {high}")


def _renamed(groups: Mapping[str, Any], max_name: int, reserved: Collection[str]) -> dict[str, IntArray]:
    names = portable_names(groups, max_length=max_name, reserved=reserved)
    return {names[name]: np.asarray(ids, dtype=np.int64) for name, ids in groups.items()}


def _recolored(info: Mapping[str, Any], *groups: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Colours of the CAD model by the names that are written; `groups`: old and new boundaries, old and new parts."""
    colors = info.get("colors", {})
    return {
        kind: {new: colors[kind][old] for old, new in zip(groups[i], groups[i + 1], strict=True) if old in colors[kind]}
        for i, kind in ((0, "boundaries"), (2, "parts"))
        if kind in colors
    }


def _materials(mesh: HexMesh) -> dict[str, IntArray]:
    """Hexes of every material, by a name that travels."""
    found: dict[str, list[IntArray]] = {}
    given = mesh.info.get("materials") or {}
    if not given and mesh.info.get("material"):
        given = dict.fromkeys(mesh.parts, mesh.info["material"])
    for part, material in given.items():
        if part in mesh.parts and material:
            found.setdefault(str(material), []).append(np.asarray(mesh.parts[part], dtype=np.int64))
    names = portable_names(found, max_length=80, reserved=())
    return {names[material]: distinct(np.concatenate(ids)) for material, ids in found.items()}


def _without_empty(groups: dict[str, IntArray], what: str) -> dict[str, IntArray]:
    for name, ids in groups.items():
        if len(ids) == 0:
            logger.warning("the %s %r has no members and is not written", what, name)
    return {name: ids for name, ids in groups.items() if len(ids)}


def _face_blocks(boundaries: dict[str, IntArray], n_corners: int) -> tuple[IntArray, Blocks]:
    stacked = np.concatenate([*boundaries.values(), np.empty((0, n_corners), dtype=np.int64)])
    first, codes = corner_keys(stacked[:, :4])
    order = np.sort(first)
    place = np.empty(len(first), dtype=np.int64)
    place[np.argsort(first, kind="stable")] = np.arange(len(first))
    cells = place[codes]
    ends = np.cumsum([0, *(len(quads) for quads in boundaries.values())])
    sets = {name: cells[ends[j] : ends[j + 1]] for j, name in enumerate(boundaries)}
    return stacked[order], make_blocks(sets, len(order))


def without_quads(mesh: LabelledMesh, left_out: np.ndarray) -> LabelledMesh:
    """The mesh without the quads that `left_out` (q,) marks, nor names of which none is left."""
    number = np.cumsum(~left_out) - 1
    kept = {name: ids[~left_out[ids]] for name, ids in ((name, mesh.faces.named(name)) for name in mesh.faces.names)}
    quads = mesh.quads[~left_out]
    faces = make_blocks({name: number[ids] for name, ids in kept.items() if len(ids)}, len(quads))
    return replace(mesh, quads=quads, faces=replace(faces, max_name=mesh.faces.max_name))


def _volume_blocks(parts: dict[str, IntArray], n_hexes: int) -> Blocks:
    covered = np.zeros(n_hexes, dtype=bool)
    for ids in parts.values():
        covered[ids] = True
    if not covered.all():
        name = DEFAULT_PART
        while name.lower() in {other.lower() for other in parts}:
            name += "_"
        parts = {**parts, name: np.flatnonzero(~covered)}
    return make_blocks(parts, n_hexes)


def make_blocks(sets: dict[str, IntArray], n_cells: int) -> Blocks:
    """Split cells into blocks of equal names, in the order of the blocks' first cells."""
    of_cell = np.zeros(n_cells, dtype=np.int64)
    if n_cells == 0:
        return Blocks(names=tuple(sets), members=(), of_cell=of_cell)
    members: list[tuple[str, ...]] = [()]
    for name, ids in sets.items():
        inside = np.zeros(n_cells, dtype=bool)
        inside[ids] = True
        if inside.all():
            members = [(*names, name) for names in members]
            continue
        whole = np.bincount(of_cell, minlength=len(members))
        part = np.bincount(of_cell[inside], minlength=len(members))
        for block in np.flatnonzero(part):
            if part[block] == whole[block]:
                members[block] = (*members[block], name)
            else:
                of_cell[inside & (of_cell == block)] = len(members)
                members.append((*members[block], name))
    if len(members) == 1:
        return Blocks(names=tuple(sets), members=tuple(members), of_cell=of_cell)
    used, first, renumbered = np.unique(of_cell, return_index=True, return_inverse=True)
    rank = np.empty(len(used), dtype=np.int64)
    order = np.argsort(first, kind="stable")
    rank[order] = np.arange(len(used))
    return Blocks(
        names=tuple(sets), members=tuple(members[used[j]] for j in order), of_cell=rank[renumbered.reshape(-1)]
    )
