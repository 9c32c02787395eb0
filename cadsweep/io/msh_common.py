"""What the versions of gmsh's MSH share: element types, node orders, physical names, and the making of a mesh."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..mesh import HexMesh
from .labels import check_nodes

HEX_TYPES = {8: 5, 20: 17, 27: 12}
QUAD_TYPES = {4: 3, 8: 16, 9: 10}
HEX_ORDER = {
    8: np.arange(8),
    20: np.array([*range(8), 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14]),
    27: np.array([*range(8), 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14, 24, 22, 20, 21, 23, 25, 26]),
}
"""``gmsh_nodes = vtk_nodes[:, HEX_ORDER[n]]``. Gmsh reference manual, "Node ordering": the middles of the edges 0-1,
0-3, 0-4, 1-2, 1-5, 2-3, 2-6, 3-7, 4-5, 4-7, 5-6, 6-7, then of the faces 0-3-2-1, 0-1-5-4, 0-4-7-3, 1-2-6-5, 2-3-7-6,
4-5-6-7."""

NODES_OF_TYPE = {
    1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 8: 3, 9: 6, 10: 9, 11: 10, 12: 27, 13: 18, 14: 14, 15: 1, 16: 8,
    17: 20, 18: 15, 19: 13, 20: 9, 21: 10, 26: 4, 36: 16, 92: 64,
}  # fmt: skip
"""Nodes of every element type that may stand in a file beside hexes."""

_SOLID_TYPES = {4, 5, 6, 7, 11, 12, 13, 14, 17, 18, 19, 92}


@dataclass(kw_only=True, eq=False)
class Groups:
    """Cells of a file as they are found: tags, nodes, and which physical groups they are in."""

    names: dict[tuple[int, int], str] = field(default_factory=dict)
    nodes: dict[int, list[IntArray]] = field(default_factory=dict)
    tags: dict[int, list[IntArray]] = field(default_factory=dict)
    physical: dict[int, list[tuple[int, ...]]] = field(default_factory=dict)

    def add(self, kind: int, tags: IntArray, nodes: IntArray, physical: Sequence[int]) -> None:
        """Add a block of cells of one element type and one set of physical groups."""
        self.nodes.setdefault(kind, []).append(nodes)
        self.tags.setdefault(kind, []).append(tags)
        self.physical.setdefault(kind, []).append(tuple(physical))


def physical_names(faces: Iterable[str], volumes: Iterable[str]) -> bytes:
    """The section of physical names: surfaces, then volumes, numbered in one row."""
    rows = [(2, name) for name in faces] + [(3, name) for name in volumes]
    lines = [f'{dimension} {j + 1} "{name}"' for j, (dimension, name) in enumerate(rows)]
    return ("\n".join(["$PhysicalNames", str(len(rows)), *lines, "$EndPhysicalNames"]) + "\n").encode()


def collect(points: FloatArray, node_tags: IntArray, groups: Groups) -> HexMesh:
    """Make a mesh of what was found in a file; hexes come back in the order of their tags."""
    solids = sorted(kind for kind in groups.nodes if kind in _SOLID_TYPES)
    by_type = {code: size for size, code in HEX_TYPES.items()}
    if not solids:
        raise InputError("it has no hexahedra")
    if len(solids) > 1 or solids[0] not in by_type:
        raise InputError(f"it has elements of the gmsh types {', '.join(map(str, solids))}; one kind of hex is read")
    kind = solids[0]
    size = by_type[kind]
    renumber = _renumbering(node_tags)
    inverse = np.argsort(HEX_ORDER[size])
    blocks = groups.nodes[kind]
    tags = np.concatenate(groups.tags[kind])
    nodes = np.concatenate(blocks) if len(blocks) > 1 else blocks[0]
    hexes = renumber(nodes if size == 8 else nodes[:, inverse])
    lengths = [len(block) for block in blocks]
    order = None if (np.diff(tags) > 0).all() else np.argsort(tags, kind="stable")
    place = np.arange(len(hexes))
    if order is not None:
        hexes = hexes[order]
        place[order] = np.arange(len(hexes))
    parts = _named(groups, kind, 3, np.split(place, np.cumsum(lengths)[:-1]))
    width = {8: 4, 20: 8, 27: 9}[size]
    quad_kind = QUAD_TYPES[width]
    quads = [renumber(block) for block in groups.nodes.get(quad_kind, [])]
    boundaries = _named(groups, quad_kind, 2, quads)
    for (dimension, _), name in groups.names.items():
        if dimension == 2:  # a name without quads is still a name
            boundaries.setdefault(name, np.empty((0, width), dtype=np.int64))
    return HexMesh(
        points=np.array(points),  # not a view of the file, which others may cut short
        hexes=hexes,
        boundaries=boundaries,
        parts={name: np.sort(ids) for name, ids in parts.items()},
    )


def _named(groups: Groups, kind: int, dimension: int, blocks: Sequence[IntArray]) -> dict[str, IntArray]:
    found: dict[int, list[IntArray]] = {}
    for block, physical in zip(blocks, groups.physical.get(kind, []), strict=True):
        for tag in physical:
            found.setdefault(abs(tag), []).append(block)
    stem = {2: "surface", 3: "volume"}[dimension]
    # The order of the names section is the order of the mesh that was written.
    order = [tag for dim, tag in groups.names if dim == dimension and tag in found]
    order += sorted(set(found) - set(order))
    return {groups.names.get((dimension, tag), f"{stem}_{tag}"): np.concatenate(found[tag]) for tag in order}


def _renumbering(tags: IntArray) -> Callable[[IntArray], IntArray]:
    """A function that turns node tags into row numbers."""
    n = len(tags)
    if n and tags[0] >= 0 and tags[-1] - tags[0] == n - 1 and (np.diff(tags) == 1).all():
        first = tags[0]

        def shift(nodes: IntArray) -> IntArray:
            rows = nodes - first
            check_nodes(rows, n)
            return rows

        return shift
    order = np.argsort(tags, kind="stable")
    ascending = tags[order]

    def look_up(nodes: IntArray) -> IntArray:
        place = np.searchsorted(ascending, nodes)
        check_nodes(place, n)
        if (ascending[place] != nodes).any():
            raise InputError("an element names a node that is not there")
        return order[place]

    return look_up
