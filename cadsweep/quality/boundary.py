"""Named boundary quads against the faces that have one user.

Place in the flow: called by :func:`cadsweep.quality.check_mesh`. A quad is known again, wherever it
begins, by its least node, the node across, and the two others in order. Boundaries may overlap (a face and a
group that it is in); within one boundary a quad comes once.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray, IntArray
from ..compiled import compiled
from ..mesh import HexMesh
from . import conformity


def place(point: FloatArray) -> str:
    """A point for a message."""
    return "(" + ", ".join(f"{c:.5g}" for c in point) + ")"


def quad_keys(quads: IntArray, n: int) -> tuple[IntArray, IntArray]:
    """Two integers that name an oriented quad: (least node, the node across), (next, previous)."""
    keys = np.empty((2, len(quads)), dtype=np.int64)
    _fill_keys(np.asarray(quads, dtype=np.int64), n, keys)
    return keys[0], keys[1]


@compiled(cache=True, nogil=True)
def _fill_keys(quads, n, keys):  # type: ignore[no-untyped-def]
    for q in range(quads.shape[0]):
        at = 0
        for i in range(1, 4):
            if quads[q, i] < quads[q, at]:
                at = i
        keys[0, q] = quads[q, at] * n + quads[q, (at + 2) & 3]
        keys[1, q] = quads[q, (at + 1) & 3] * n + quads[q, (at + 3) & 3]


def boundary_problems(mesh: HexMesh, expected: IntArray) -> list[str]:
    """Hold the named boundary quads against the faces that have one user."""
    if not mesh.boundaries:
        return []
    n = max(mesh.n_nodes, 1)
    problems = []
    pieces, owners = [], []
    for name, given in mesh.boundaries.items():
        quads = np.asarray(given)
        if quads.ndim != 2 or quads.shape[1] < 4:
            problems.append(f"boundary '{name}' has shape {quads.shape}, not (q, 4)")
        elif len(quads) and (np.min(quads) < 0 or np.max(quads) >= n):
            problems.append(f"boundary '{name}' refers to nodes outside 0 .. {n - 1}")
        else:
            pieces.append(quads[:, :4].astype(np.int64))
            owners += [(name, len(quads))]
    named = np.concatenate(pieces) if pieces else np.zeros((0, 4), dtype=np.int64)
    named_keys, expected_keys = quad_keys(named, n), quad_keys(expected, n)
    if _same_quads(named_keys, expected_keys, n):
        return problems
    have, want = _pairs(named_keys), _pairs(expected_keys)
    turned = _pairs(quad_keys(named[:, ::-1], n))
    owner = np.repeat(np.arange(len(owners)), [n_quads for _, n_quads in owners])
    inward = np.isin(turned, want)
    foreign = ~np.isin(have, want) & ~inward
    if len(mesh.parts) > 1 and np.any(foreign):
        foreign &= ~_interfaces(mesh, named, n)
    order = np.lexsort((owner, have["b"], have["a"]))
    again = (have[order[1:]] == have[order[:-1]]) & (owner[order[1:]] == owner[order[:-1]])
    twice = np.zeros(len(have), dtype=bool)
    twice[order[1:]] = again
    missing = ~np.isin(want, have) & ~np.isin(want, turned)
    for rows, text in (
        (inward, "boundary quads turn inward"),
        (foreign, "boundary quads are not on the boundary of the hexahedra"),
        (twice, "boundary quads come twice in one boundary"),
    ):
        if np.any(rows):
            i = int(np.flatnonzero(rows)[0])
            problems.append(
                f"{np.count_nonzero(rows)} {text}, the first is {named[i].tolist()} of '{owners[owner[i]][0]}' "
                f"at {place(mesh.points[named[i]].mean(axis=0))}"
            )
    if np.any(missing):
        i = int(np.flatnonzero(missing)[0])
        problems.append(
            f"{np.count_nonzero(missing)} quads on the boundary have no name, the first is {expected[i].tolist()} "
            f"at {place(mesh.points[expected[i]].mean(axis=0))}"
        )
    return problems


def boundary_blocks(boundaries: Mapping[str, IntArray], n: int) -> dict[tuple[str, ...], IntArray]:
    """Quads by the set of boundaries that they are in, each once.

    Parameters
    ----------
    boundaries : mapping of name to (q, 4), (q, 8) or (q, 9) int64
        All of one width.
    n : int
        Number of nodes.

    Returns
    -------
    dict of tuple of str to (q, 4, 8 or 9) int64
        Where none overlap, the boundaries under their own names.
    """
    names = list(boundaries)
    if not names:
        return {}
    stacked = np.concatenate(list(boundaries.values()))
    keys = quad_keys(stacked[:, :4], max(n, 1))
    mixed = np.sort(keys[0] * np.int64(0x9E3779B97F4A7C1) + keys[1])  # quads with different values are different
    if np.all(mixed[1:] != mixed[:-1]):
        return {(name,): boundaries[name] for name in names}
    _, first, ids = np.unique(_pairs(keys), return_index=True, return_inverse=True)
    owner = np.repeat(np.arange(len(names)), [len(quads) for quads in boundaries.values()])
    holders = np.zeros((len(first), len(names)), dtype=bool)
    holders[ids.reshape(-1), owner] = True
    sets, block = np.unique(np.packbits(holders, axis=1), axis=0, return_inverse=True)
    block = block.reshape(-1)
    blocks = {}
    for j in range(len(sets)):
        inside = np.flatnonzero(block == j)
        blocks[tuple(names[i] for i in np.flatnonzero(holders[inside[0]]))] = stacked[first[inside]]
    return blocks


def _pairs(keys: tuple[IntArray, IntArray]) -> np.ndarray:
    """Two integers a quad as one value that can be sorted and looked up."""
    result = np.empty(len(keys[0]), dtype=[("a", np.int64), ("b", np.int64)])
    result["a"], result["b"] = keys
    return result


def _same_quads(one: tuple[IntArray, IntArray], other: tuple[IntArray, IntArray], n: int) -> bool:
    if len(one[0]) != len(other[0]):
        return False
    return _are_same(np.stack(one), np.stack(other), n)


@compiled(cache=True, nogil=True)
def _are_same(one, other, n):  # type: ignore[no-untyped-def]
    """Whether keys (2, q) and (2, q) are the same in any order, each as often: found by their least nodes."""
    head = np.full(n, -1, dtype=np.int64)
    follower = np.empty(one.shape[1], dtype=np.int64)
    for q in range(one.shape[1]):
        least = one[0, q] // n
        follower[q] = head[least]
        head[least] = q
    for q in range(other.shape[1]):
        least, before = other[0, q] // n, -1
        at = head[least]
        while at >= 0 and (one[0, at] != other[0, q] or one[1, at] != other[1, q]):
            before, at = at, follower[at]
        if at < 0:
            return False
        if before < 0:
            head[least] = follower[at]
        else:
            follower[before] = follower[at]
    return True


def _interfaces(mesh: HexMesh, quads: IntArray, n: int) -> np.ndarray:
    """Which quads lie between hexahedra that are not in the same parts."""
    part = np.zeros(mesh.n_hexes, dtype=np.int64)
    for ids in mesh.parts.values():
        inside = np.zeros(mesh.n_hexes, dtype=np.int64)
        inside[ids] = 1
        part = np.unique(2 * part + inside, return_inverse=True)[1].reshape(-1)  # a number for each set of parts
    faces = conformity.face_nodes(mesh.hexes, np.arange(6 * mesh.n_hexes))
    keys = _pairs(quad_keys(faces, n))
    order = np.argsort(keys)
    owner = np.repeat(part, 6)[order]
    keys = keys[order]

    def part_of(q: IntArray) -> np.ndarray:
        wanted = _pairs(quad_keys(q, n))
        at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        return np.where(keys[at] == wanted, owner[at], -2)

    one, other = part_of(quads), part_of(quads[:, ::-1])
    return (one >= 0) & (other >= 0) & (one != other)
