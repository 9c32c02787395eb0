"""Hexahedra of a stack, and the face of every boundary quad.

Place in the flow: last step of :mod:`cadsweep.stacks`. Everything is known from the cells: where a column has material,
every quad of its cell gives a hexahedron; where one of two neighbouring cells has material in a layer and the other has
not, the line between them gives quads of a wall. No two quads are compared.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..errors import SurfaceMeshError
from ..mesh import QuadMesh
from ..stack import Levels, Stack, StackMesh
from .nodes import place_nodes


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
    heights = place_nodes(stack, levels, mesh)
    material = find_material(stack, levels)
    cells = np.searchsorted(np.sort(stack.arrangement.bottoms), mesh.faces)
    cells = np.argsort(stack.arrangement.bottoms)[cells]
    n_layers, n = levels.n_layers, len(mesh.points)
    used = np.zeros((n_layers + 1, n), dtype=bool)
    layers: list[IntArray] = []
    for k in range(n_layers):
        quads = mesh.quads[material[cells, k]]
        used[k, quads] = used[k + 1, quads] = True
        layers.append(quads)
    number = np.where(used, np.cumsum(used).reshape(used.shape) - 1, -1)
    hexes = [np.concatenate([number[k][quads], number[k + 1][quads]], axis=1) for k, quads in enumerate(layers)]
    caps = _cap_quads(stack, levels, mesh, number)
    walls = _wall_quads(stack, levels, mesh, material, number)
    return StackMesh(
        points=_points(stack, mesh, heights, used),
        hexes=np.concatenate(hexes).astype(np.int64),
        quads=np.concatenate([q for q, _ in caps + walls]),
        faces=np.concatenate([f for _, f in caps + walls]),
    )


def find_material(stack: Stack, levels: Levels) -> npt.NDArray[np.bool_]:
    """Which cell has material in which layer, (n_cells, n_layers)."""
    material = np.zeros((len(stack.columns), levels.n_layers), dtype=bool)
    for c, columns in enumerate(stack.columns):
        for a, b in columns:
            material[c, levels.caps[a] : levels.caps[b]] = True
    return material


def _points(stack: Stack, mesh: QuadMesh, heights: FloatArray, used: npt.NDArray[np.bool_]) -> FloatArray:
    base = mesh.points @ stack.direction
    flat = mesh.points - np.outer(base, stack.direction)
    level, node = np.nonzero(used)
    return flat[node] + heights[level, node][:, None] * stack.direction


def _cap_quads(stack: Stack, levels: Levels, mesh: QuadMesh, number: IntArray) -> list[tuple[IntArray, IntArray]]:
    found = []
    for f, columns in zip(stack.arrangement.bottoms, stack.columns, strict=True):
        quads = mesh.quads[mesh.faces == f]
        for a, b in columns:
            for cap, outward in ((a, quads[:, ::-1]), (b, quads)):
                found.append((number[levels.caps[cap]][outward], np.full(len(quads), cap, dtype=np.int64)))
    return found


def _wall_quads(
    stack: Stack, levels: Levels, mesh: QuadMesh, material: npt.NDArray[np.bool_], number: IntArray
) -> list[tuple[IntArray, IntArray]]:
    """Quads over the lines of the arrangement where the material ends."""
    solid, arrangement = stack.solid, stack.arrangement
    beside: dict[int, list[int]] = {e: [-1, -1] for e in arrangement.over}
    for c, f in enumerate(arrangement.bottoms):
        for loop in arrangement.prism.faces[f].loops:
            for e, forward in loop.directed:
                # The bottom is seen from below by its own loops, from above by its quads.
                beside[e][forward] = c
    walls = set(stack.walls)
    found = []
    for e, over in arrangement.over.items():
        left, right = (material[c] if c >= 0 else np.zeros(levels.n_layers, dtype=bool) for c in beside[e])
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
        nodes = mesh.edge_nodes[e]
        for k in ends.tolist():
            a, b = (nodes[:-1], nodes[1:]) if left[k] else (nodes[1:], nodes[:-1])
            quads = np.stack([number[k][a], number[k][b], number[k + 1][b], number[k + 1][a]], axis=1)
            found.append((quads, np.full(len(quads), owners[k], dtype=np.int64)))
    return found
