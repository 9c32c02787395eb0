"""What the versions of gmsh's MSH share: element types, node orders, physical names, and the making of a mesh."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from ..arrays import FloatArray, IntArray
from ..errors import InputError
from ..lattice import lexicographic, order_of, quad_lexicographic, quad_size
from ..mesh import HexMesh
from .labels import check_nodes

HEX_TYPES = {8: 5, 20: 17, 27: 12, 64: 92, 125: 93, 216: 94, 343: 95, 512: 96, 729: 97}
QUAD_TYPES = {4: 3, 8: 16, 9: 10, 16: 36, 25: 37, 36: 38, 49: 47, 64: 48, 81: 49}

_CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
_EDGES = ((0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7))
_FACES = ((0, 3, 2, 1), (0, 1, 5, 4), (0, 4, 7, 3), (1, 2, 6, 5), (2, 3, 7, 6), (4, 5, 6, 7))


def _quad_places(order: int) -> IntArray:
    """Places ((p + 1)^2, 2) of the nodes of a quad: corners, edges around, and inside a quad of order p - 2."""
    if order == 0:
        return np.zeros((1, 2), dtype=np.int64)
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * order
    steps = np.arange(1, order)[:, None]
    edges = [a + (b - a) // order * steps for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    inside = [_quad_places(order - 2) + 1] if order > 1 else []
    return np.concatenate([corners, *edges, *inside])


def _hex_places(order: int) -> IntArray:
    """Places ((p + 1)^3, 3) of the nodes of a hexahedron: corners, edges, faces as quads, inside as of order p - 2."""
    if order == 0:
        return np.zeros((1, 3), dtype=np.int64)
    corners = np.array(_CORNERS) * order
    if order == 1:
        return corners
    steps = np.arange(1, order)[:, None]
    edges = [corners[a] + (corners[b] - corners[a]) // order * steps for a, b in _EDGES]
    across = _quad_places(order - 2) + 1
    faces = [
        corners[a] + across @ np.stack([corners[b] - corners[a], corners[d] - corners[a]]) // order
        for a, b, _, d in _FACES
    ]
    return np.concatenate([corners, *edges, *faces, _hex_places(order - 2) + 1])


@cache
def hex_order(size: int) -> IntArray:
    """``gmsh_nodes = vtk_nodes[:, hex_order(n)]``: gmsh reference manual, "Node ordering"."""
    order = order_of(size)
    numbers = lexicographic(order)[_hex_places(order) @ (order + 1) ** np.arange(3)]
    return numbers[numbers < size]  # of 20 nodes the first of 27


@cache
def quad_order(size: int) -> IntArray:
    """The same of quads."""
    if size == 8:
        return np.arange(8)
    order = int(size**0.5) - 1
    return quad_lexicographic(order)[_quad_places(order) @ (order + 1) ** np.arange(2)]


def in_gmsh_order(nodes: IntArray, order: IntArray) -> IntArray:
    """Columns of cells in another order; without a copy where that is the same."""
    return nodes if (np.diff(order) == 1).all() else nodes[:, order]


NODES_OF_TYPE = {
    1: 2, 2: 3, 3: 4, 4: 4, 5: 8, 6: 6, 7: 5, 8: 3, 9: 6, 10: 9, 11: 10, 12: 27, 13: 18, 14: 14, 15: 1, 16: 8,
    17: 20, 18: 15, 19: 13, 20: 9, 21: 10, 26: 4,
    **{code: size for kinds in (HEX_TYPES, QUAD_TYPES) for size, code in kinds.items()},
}  # fmt: skip
"""Nodes of every element type that may stand in a file beside hexes."""

_SOLID_TYPES = {4, 6, 7, 11, 13, 14, 18, 19, *HEX_TYPES.values()}


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
    blocks = groups.nodes[kind]
    tags = np.concatenate(groups.tags[kind])
    nodes = np.concatenate(blocks) if len(blocks) > 1 else blocks[0]
    hexes = renumber(in_gmsh_order(nodes, np.argsort(hex_order(size))))
    lengths = [len(block) for block in blocks]
    order = None if (np.diff(tags) > 0).all() else np.argsort(tags, kind="stable")
    place = np.arange(len(hexes))
    if order is not None:
        hexes = hexes[order]
        place[order] = np.arange(len(hexes))
    parts = _named(groups, kind, 3, np.split(place, np.cumsum(lengths)[:-1]))
    width = quad_size(size)
    quad_kind = QUAD_TYPES[width]
    back = np.argsort(quad_order(width))
    quads = [renumber(in_gmsh_order(block, back)) for block in groups.nodes.get(quad_kind, [])]
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
