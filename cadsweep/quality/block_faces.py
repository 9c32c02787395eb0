"""What the blocks of a mesh, each quads times layers, say about its hexahedra.

Place in the flow: :func:`cadsweep.quality.check_mesh` asks it where whoever made the mesh knows its blocks, instead of
matching all faces; where the blocks do not tell everything, all faces are matched.

Method. One pass holds the hexahedra of every block against its structure, node by node. Inside of a block the faces
then conform as those of a sweep do (:mod:`.structure`), and a face with a node that is inside of one has no users
elsewhere. What is left, faces all of whose nodes other blocks may have, belongs to hexahedra at caps and sides, and to
those that are in no block: only these are matched with each other.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..arrays import BoolArray, IntArray, distinct
from ..cells import HEX_FACES, BlockStructure, SweptStructure
from ..compiled import compiled
from . import conformity
from .conformity import FaceUse
from .structure import structure_problems

_CORNERS = (1 << HEX_FACES).sum(axis=1)
"""The corners of each face of a hexahedron, a bit a corner."""


def block_problems(block: BlockStructure) -> list[str]:
    """What is wrong with a block's structure; nothing where its hexahedra conform with each other."""
    if block.whole is not None:
        own = block.whole
        return structure_problems(own, (own.n_layers + (not own.periodic)) * own.n_nodes)
    found = structure_problems(_alone(block), (block.n_layers + 1) * block.n_nodes)
    borrowed = _borrowed(block)
    if len(distinct(borrowed)) != len(borrowed):
        found.append("a node of its caps and sides stands in two places")
    return found


def match_blocks(hexes: IntArray, n_nodes: int, blocks: Sequence[BlockStructure]) -> FaceUse | None:
    """The users of the faces of hexahedra, those inside of blocks left out, where blocks tell that all is well.

    Parameters
    ----------
    hexes : (m, 8) int64
    n_nodes : int
    blocks : sequence of BlockStructure
        In the order of their hexahedra; there may be others between them.

    Returns
    -------
    FaceUse or None
        None where a block does not describe its hexahedra, or these do not conform: what is wrong then is to be found
        without the blocks.
    """
    owned = _owned(n_nodes, blocks)
    if owned is None:
        return None
    seen = np.zeros(n_nodes, dtype=np.int64)
    faces, at = [], 0
    for block in blocks:
        before = hexes[at : block.first_hex]
        shared = _shared_faces(hexes, block, owned, seen) if block.first_hex >= at else None
        if shared is None or not _is_sound(before, owned, seen):
            return None
        faces += [np.arange(6 * at, 6 * block.first_hex), shared]
        at = block.first_hex + block.n_hexes
    if not _is_sound(hexes[at:], owned, seen) or not (owned | (seen > 0)).all():
        return None
    left = np.concatenate([*faces, np.arange(6 * at, 6 * len(hexes))])
    use = conformity.match_quads(conformity.face_nodes(hexes, left), n_nodes)
    return None if len(use.crowded) or len(use.clashing) else use.of(left)


def _shared_faces(hexes: IntArray, block: BlockStructure, owned: BoolArray, seen: IntArray) -> IntArray | None:
    """Faces of a block's hexahedra that others may have; None where it does not describe these."""
    last = block.first_hex + block.n_hexes
    # Nodes of the caps and sides must be no block's own, each in one place: then no two nodes of a layer are one.
    if last > len(hexes) or not _are_apart(_borrowed(block), owned, last, seen):
        return None
    if structure_problems(_alone(block), (block.n_layers + 1) * block.n_nodes):
        return None
    shared = np.zeros((block.n_hexes, 6), dtype=np.bool_)
    nodes = block.layers(np.arange(block.n_layers + 1))
    if not _follows_block(hexes[block.first_hex : last], nodes, block.quads, owned, _CORNERS, shared):
        return None
    return 6 * block.first_hex + np.flatnonzero(shared)


def _is_sound(hexes: IntArray, owned: BoolArray, seen: IntArray) -> bool:
    """Whether hexahedra of no block have eight nodes, none of them a block's own; marks these in `seen`."""
    if not len(hexes):
        return True
    (outside, _, repeated, _), used = conformity.scan_hexes(hexes, len(owned))
    seen[used] = 1
    return not outside and not repeated and not (used & owned).any()


def _owned(n_nodes: int, blocks: Sequence[BlockStructure]) -> BoolArray | None:
    """Which nodes are inside of a block; None where two blocks have one, or the mesh has not so many."""
    owned = np.zeros(n_nodes, dtype=np.bool_)
    for block in blocks:
        own = slice(block.first_node, block.first_node + block.n_own)
        if block.first_node < 0 or own.stop > n_nodes or owned[own].any():
            return None
        owned[own] = True
    return owned


def _alone(block: BlockStructure) -> SweptStructure:
    """A block as if it were a mesh."""
    return SweptStructure(quads=block.quads, loops=block.loops, n_nodes=block.n_nodes, n_layers=block.n_layers)


def _borrowed(block: BlockStructure) -> IntArray:
    """Nodes of a block's caps and sides, each once where all is well."""
    return np.concatenate([block.bottom, block.top, block.rings[1:-1].reshape(-1)])


@compiled(cache=True, nogil=True)
def _are_apart(nodes, owned, mark, seen):  # type: ignore[no-untyped-def]
    """Whether nodes are in range, no block's own, and each once; marks them by a number that is no other block's."""
    for i in range(nodes.shape[0]):
        node = nodes[i]
        if node < 0 or node >= owned.shape[0] or owned[node] or seen[node] == mark:
            return False
        seen[node] = mark
    return True


@compiled(cache=True, nogil=True)
def _follows_block(hexes, nodes, quads, owned, corners, shared):  # type: ignore[no-untyped-def]  # noqa: PLR0917
    """Whether hexahedra are quads times layers of nodes; mark the faces none of whose nodes is inside."""
    n = quads.shape[0]
    for h in range(hexes.shape[0]):
        k = h // n
        inner = 0
        for i in range(4):
            place = quads[h - k * n, i]
            low, high = nodes[k, place], nodes[k + 1, place]
            if hexes[h, i] != low or hexes[h, 4 + i] != high:
                return False
            if owned[low]:
                inner |= 1 << i
            if owned[high]:
                inner |= 16 << i
        if inner == 255:  # as of most: no face of it is anybody else's
            continue
        for f in range(6):
            shared[h, f] = inner & corners[f] == 0
    return True
