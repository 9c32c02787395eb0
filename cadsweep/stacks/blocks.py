"""Hexahedra of a stack, and the face of every boundary quad.

Place in the flow: last step of :mod:`cadsweep.stacks`. Everything is known from the cells: where a column has material,
every quad of its cell gives a hexahedron; where one of two neighbouring cells has material in a layer and the other has
not, the line between them gives quads of a wall. No two quads are compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..errors import SurfaceMeshError
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from ..stack_mesh import StackMesh
from .lines import nodes_on_edges
from .nodes import Heights, place_nodes, quads_by_cell
from .places import find_places


def build_mesh(stack: Stack, levels: Levels, mesh: QuadMesh) -> StackMesh:
    """Make the hexahedra of a stack.

    Parameters
    ----------
    stack : Stack
    levels : Levels
    mesh : QuadMesh
        The source cap of ``stack.plan``.

    Raises
    ------
    SurfaceMeshError
        Two caps of one level have different heights over one node, or a wall is missing.
    """
    places = find_places(stack, levels, mesh)
    heights = place_nodes(stack, levels, mesh, places)
    material, cells = find_material(stack, levels), find_owners(stack, mesh)
    filled = [material[cells, k] for k in range(levels.n_layers)]
    layers = [mesh.quads[own] for own in filled]
    numbers, points, level_of, place_of = _number(stack, places, heights, layers)
    hexes = np.empty((sum(map(len, layers)), 8), dtype=np.int64)
    first = 0
    for k, q in enumerate(layers):
        own = hexes[first : first + len(q)]
        own[:, :4], own[:, 4:] = numbers.above[k][q], numbers.below[k + 1][q]
        first += len(q)
    numbered = _number_columns(stack, levels)
    columns = np.concatenate([numbered[cells[own], k] for k, own in enumerate(filled)])
    caps = _cap_quads(stack, levels, mesh, numbers)
    walls = _wall_quads(stack, levels, mesh, material, numbers)
    return StackMesh(
        points=points,
        hexes=hexes[np.argsort(columns, kind="stable")],
        columns=tuple(np.bincount(columns).tolist()),
        quads=np.concatenate([q for q, _ in caps + walls]),
        faces=np.concatenate([f for _, f in caps + walls]),
        edge_nodes=nodes_on_edges(stack, levels, mesh, numbers.row, points),
        levels=level_of,
        places=place_of,
    )


def _number_columns(stack: Stack, levels: Levels) -> IntArray:
    """Which column a cell has in a layer, (n_cells, n_layers); -1 where it has no material there."""
    found = np.full((len(stack.columns), levels.n_layers), -1, dtype=np.int64)
    spans = [(c, levels.caps[a], levels.caps[b]) for c, columns in enumerate(stack.columns) for a, b in columns]
    for number, (c, low, high) in enumerate(spans):
        found[c, low:high] = number
    return found


def find_owners(stack: Stack, mesh: QuadMesh) -> IntArray:
    """Cell (q,) of the arrangement that every quad lies in."""
    bottoms = np.array(stack.arrangement.bottoms)
    order = np.argsort(bottoms)
    return np.asarray(order[np.searchsorted(bottoms[order], mesh.faces)])


def find_material(stack: Stack, levels: Levels) -> npt.NDArray[np.bool_]:
    """Which cell has material in which layer, (n_cells, n_layers)."""
    material = np.zeros((len(stack.columns), levels.n_layers), dtype=bool)
    for c, columns in enumerate(stack.columns):
        for a, b in columns:
            material[c, levels.caps[a] : levels.caps[b]] = True
    return material


def find_presence(stack: Stack, levels: Levels, mesh: QuadMesh) -> npt.NDArray[np.bool_]:
    """Which quad of the arrangement has material below or above which level, (n_layers + 1, n_quads)."""
    material = find_material(stack, levels)
    reached = np.pad(material, ((0, 0), (0, 1))) | np.pad(material, ((0, 0), (1, 0)))
    return reached.T[:, find_owners(stack, mesh)]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Numbers:
    """Node numbers (n_layers + 1, n_nodes) where the layer below a level ends, and where the layer above it begins."""

    below: IntArray
    above: IntArray

    def row(self, level: int, begins: bool) -> IntArray:
        """Those of one level."""
        return (self.above if begins else self.below)[level]


def _number(
    stack: Stack, places: FloatArray, heights: Heights, layers: list[IntArray]
) -> tuple[_Numbers, FloatArray, IntArray, IntArray]:
    """Number the nodes that hexahedra use, level by level, and place them; levels and places of each."""
    shape = heights.below.shape
    used = np.zeros((shape[0], 2, shape[1]), dtype=bool)  # level by level: below, then above where it is another
    is_open = heights.open
    for k, quads in enumerate(layers):
        begins, ends = np.zeros((2, shape[1]), dtype=bool)
        begins[quads] = ends[quads] = True
        used[k, 0] |= begins & ~is_open[k]
        used[k, 1] |= begins & is_open[k]
        used[k + 1, 0] |= ends
    number = np.cumsum(used).reshape(used.shape) - 1
    numbers = _Numbers(below=number[:, 0], above=np.where(is_open, number[:, 1], number[:, 0]))
    level, copy, node = np.nonzero(used)
    height = np.where(copy == 0, heights.below[level, node], heights.above[level, node])
    return numbers, places[level, node] + height[:, None] * stack.direction, level, node


def _cap_quads(stack: Stack, levels: Levels, mesh: QuadMesh, numbers: _Numbers) -> list[tuple[IntArray, IntArray]]:
    found = []
    for quads, columns in zip(quads_by_cell(stack, mesh), stack.columns, strict=True):
        for a, b in columns:
            for cap, ids in (
                (a, numbers.above[levels.caps[a]][quads[:, ::-1]]),
                (b, numbers.below[levels.caps[b]][quads]),
            ):
                found.append((ids, np.full(len(quads), cap, dtype=np.int64)))
    return found


def find_walls(
    stack: Stack, levels: Levels, material: npt.NDArray[np.bool_]
) -> dict[int, tuple[IntArray, npt.NDArray[np.bool_], IntArray]]:
    """Lines of the arrangement over which the material ends.

    Returns
    -------
    dict of int to (layers, left, owners)
        By edge: the layers with material on one side alone, for every layer (n_layers,) whether that is the left one,
        and the wall that stands there, -1 for none.

    Raises
    ------
    SurfaceMeshError
        A wall is missing.
    """
    solid, arrangement = stack.solid, stack.arrangement
    beside: dict[int, list[int]] = {e: [-1, -1] for e in arrangement.over}
    for c, f in enumerate(arrangement.bottoms):
        for loop in arrangement.prism.faces[f].loops:
            for e, forward in loop.directed:
                # The bottom is seen from below by its own loops, from above by its quads.
                beside[e][forward] = c
    walls = set(stack.walls)
    found = {}
    nothing = np.zeros(levels.n_layers, dtype=bool)
    for e, over in arrangement.over.items():
        left, right = (material[c] if c >= 0 else nothing for c in beside[e])
        ends = np.flatnonzero(left != right)
        if not len(ends):
            continue
        rims: dict[int, list[int]] = {}
        for one in over:
            faces = solid.edges[one].faces
            level = levels.stations.get(one)
            for f, other in (faces, faces[::-1]):
                if f in walls and (other in levels.caps or level is not None):
                    rims.setdefault(f, []).append(levels.caps[other] if level is None else level)
        owners = np.full(levels.n_layers, -1, dtype=np.int64)
        for f, at in rims.items():
            for low, high in zip(sorted(at)[::2], sorted(at)[1::2], strict=False):
                owners[low:high] = f
        if (owners[ends] < 0).any():
            place = solid.units.place(arrangement.prism.edges[e].midpoint)
            raise SurfaceMeshError(f"no wall of the part stands where its material ends, at ({place})")
        owners[left == right] = -1
        found[e] = ends, left, owners
    return found


def _wall_quads(
    stack: Stack, levels: Levels, mesh: QuadMesh, material: npt.NDArray[np.bool_], numbers: _Numbers
) -> list[tuple[IntArray, IntArray]]:
    """Quads over the lines of the arrangement where the material ends."""
    found = []
    for e, (ends, left, owners) in find_walls(stack, levels, material).items():
        nodes = mesh.edge_nodes[e]
        for k in ends.tolist():
            a, b = (nodes[:-1], nodes[1:]) if left[k] else (nodes[1:], nodes[:-1])
            low, high = numbers.above[k], numbers.below[k + 1]
            quads = np.stack([low[a], low[b], high[b], high[a]], axis=1)
            found.append((quads, np.full(len(quads), owners[k], dtype=np.int64)))
    return found
