"""What the structure of a swept mesh (quads times layers) says about its hexahedra.

Place in the flow: :func:`cadsweep.quality.check_mesh` asks it instead of looking at every face, where a
mesh has a structure; streamed meshes have nothing else.
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray, distinct
from ..cells import SweptStructure, side_quads
from ..compiled import compiled
from ..threads import LIGHT, map_chunks
from .conformity import duplicate_rows, scan_hexes


def structure_boundary(structure: SweptStructure) -> IntArray:
    """Outward boundary quads (b, 4) that a swept mesh must have: source, target, linking sides."""
    sides = side_quads(structure.loops, structure.n_nodes, structure.n_layers, periodic=structure.periodic)
    if structure.periodic:
        return sides.reshape(-1, 4)
    source = structure.quads[:, [0, 3, 2, 1]]
    target = structure.quads + structure.n_layers * structure.n_nodes
    return np.concatenate([source, target, sides.reshape(-1, 4)])


def structure_problems(structure: SweptStructure, n_nodes: int) -> list[str]:
    """What is wrong with a swept mesh's structure; nothing means that its hexahedra conform.

    Sound quads (distinct nodes, each edge in two opposite directions or once, the latter forming
    the loops) times layers give hexahedra whose faces have one or two users, and a boundary of
    exactly the caps and the linking sides.
    """
    quads, n = structure.quads, structure.n_nodes
    problems = []
    layers = structure.n_layers + (0 if structure.periodic else 1)
    if n_nodes != layers * n:
        problems.append(f"{n_nodes} nodes, but {layers} layers of {n}")
    if structure.n_layers < (3 if structure.periodic else 1):
        problems.append(f"{structure.n_layers} layers of hexahedra are too few")
    if len(quads) == 0:
        return [*problems, "no quads"]
    if np.min(quads) < 0 or np.max(quads) >= n:
        return [*problems, f"quads refer to nodes outside 0 .. {n - 1}"]
    (_, _, repeated, where), used = scan_hexes(quads, n)
    if repeated:
        problems.append(f"{repeated} quads use a node twice, the first is quad {where}")
    if not used.all():
        problems.append(f"{np.count_nonzero(~used)} nodes of a layer belong to no quad")
    twins = duplicate_rows(quads)
    if twins:
        problems.append(f"{len(twins)} quads occur twice, the first are {twins[0][0]} and {twins[0][1]}")
    starts, ends = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    forward = np.sort(starts * n + ends)
    if np.any(forward[1:] == forward[:-1]):
        problems.append("an edge of the quads is run through twice in one direction")
    backward = np.sort(ends * n + starts)
    met = np.searchsorted(backward[:-1], forward)
    rim = distinct(forward[backward[met] != forward])
    loops = [np.asarray(loop) for loop in structure.loops]
    ring = np.concatenate(loops) if loops else np.zeros(0, dtype=np.int64)
    expected = np.concatenate([loop * n + np.roll(loop, -1) for loop in loops]) if loops else ring
    if not np.array_equal(rim, np.sort(expected)):
        problems.append("the loops are not the rim of the quads")
    if len(distinct(ring)) != len(ring):
        problems.append("a node occurs twice in the loops")
    return problems


@compiled(cache=True, nogil=True)
def _follows_structure(hexes, first, quads, n_nodes, n_layers, periodic):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    q = quads.shape[0]
    for row in range(hexes.shape[0]):
        h = first + row
        k = h // q
        low = k * n_nodes
        high = 0 if periodic and k == n_layers - 1 else low + n_nodes
        for i in range(4):
            node = quads[h - k * q, i]
            if hexes[row, i] != node + low or hexes[row, 4 + i] != node + high:
                return False
    return True


def follows_structure(hexes: IntArray, structure: SweptStructure) -> bool:
    """Whether the hexahedra are the ones that the structure says."""
    if hexes.shape != (structure.n_layers * len(structure.quads), 8):
        return False
    layers = (structure.quads, structure.n_nodes, structure.n_layers, structure.periodic)
    follows = map_chunks(
        lambda chunk: bool(_follows_structure(hexes[chunk], chunk.start, *layers)), len(hexes), chunk=LIGHT
    )
    return all(follows)
