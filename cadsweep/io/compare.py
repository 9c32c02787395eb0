"""Whether what was read back is what was written.

Place in the flow: :func:`cadsweep.io.write` calls :func:`check_same` between writing a file and putting it in place.
"""

from __future__ import annotations

import ctypes
import sys
from typing import Any, BinaryIO

import numpy as np

from ..arrays import IntArray
from ..cells import HEX_EDGES, HEX_FACES
from ..errors import CadSweepError
from ..mesh import HexMesh
from .labels import LabelledMesh
from .sides import cyclic

_CHUNK = 1 << 16
_PIECE = 1 << 20

_memcmp: Any = getattr(ctypes.CDLL(None), "memcmp", None) if sys.platform != "win32" else None
if _memcmp is not None:
    _memcmp.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t)
    _memcmp.restype = ctypes.c_int


Groups = tuple[dict[str, IntArray], dict[str, IntArray]]
"""Boundaries (name to quads) and parts (name to hex ids)."""


def check_same(
    mesh: LabelledMesh, back: HexMesh, groups: Groups, *, tolerance: float = 0.0, turned: bool = False
) -> None:
    """Compare a mesh with what a reader made of its file: nodes, hexes, names, and the quads and hexes of each name.

    Quads may come in another order and begin at another corner, but not turn the other way.

    Parameters
    ----------
    mesh : LabelledMesh
        What was sent.
    back : HexMesh
        What was read.
    groups : (dict, dict)
        Boundaries and parts as the format keeps them.
    tolerance : float
        Relative difference allowed of a coordinate; 0: bit for bit.
    turned : bool
        A hex may begin at another corner, of the same 24 rotations of a cube.

    Raises
    ------
    CadSweepError
        The first difference.
    """
    for what, sent, got in (("nodes", mesh.points, back.points), ("hexes", mesh.hexes, back.hexes)):
        if sent.shape != got.shape:
            raise CadSweepError(f"reading it back gave {what} of shape {got.shape} instead of {sent.shape}")
    for start in range(0, len(mesh.points), _CHUNK):
        sent, got = mesh.points[start : start + _CHUNK], back.points[start : start + _CHUNK]
        if not np.array_equal(sent, got) and not (np.abs(sent - got) <= tolerance * np.abs(sent)).all():
            raise CadSweepError(f"reading it back gave other nodes, the first in rows {start} and after")
    for start in range(0, len(mesh.hexes), _CHUNK):
        sent, got = mesh.hexes[start : start + _CHUNK], back.hexes[start : start + _CHUNK]
        if np.array_equal(sent, got) or (turned and _turned_alike(sent, got)):
            continue
        raise CadSweepError(f"reading it back gave other hexes, the first in rows {start} and after")
    _check_groups(groups, back)


def _check_groups(groups: Groups, back: HexMesh) -> None:
    boundaries, parts = groups
    for what, sent_groups, got_groups in (("boundary", boundaries, back.boundaries), ("part", parts, back.parts)):
        if set(sent_groups) != set(got_groups):
            missing = sorted(set(sent_groups) ^ set(got_groups))
            raise CadSweepError(f"reading it back, the {what} names differ: {', '.join(missing[:5])}")
    for name, quads in boundaries.items():
        if not same_quads(quads, back.boundaries[name]):
            raise CadSweepError(f"reading it back gave other quads of boundary {name!r}")
    for name, ids in parts.items():
        if not np.array_equal(np.sort(ids), np.sort(back.parts[name])):
            raise CadSweepError(f"reading it back gave other hexes of part {name!r}")


class ExpectedBytes:
    """Takes what a writer writes and compares it with what stands in a file.

    Raises
    ------
    CadSweepError
        At the first difference.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._file = np.memmap(stream, dtype=np.uint8, mode="r")
        self._place = 0

    def write(self, data: bytes | memoryview) -> int:
        """Compare the next bytes."""
        sent = np.frombuffer(data, dtype=np.uint8)
        for start in range(0, len(sent), _PIECE):
            part = sent[start : start + _PIECE]
            if not same_bytes(part, self._file[self._place : self._place + len(part)]):
                raise CadSweepError(f"reading it back gave other bytes, the first from {self._place} on")
            self._place += len(part)
        return len(sent)

    def finish(self) -> None:
        """Make sure that nothing else follows."""
        if self._place != len(self._file):
            raise CadSweepError("reading it back gave more bytes than were written")


def same_bytes(some: np.ndarray, others: np.ndarray) -> bool:
    """Whether two contiguous arrays of the same type hold the same bytes, at the speed of memory."""
    if some.shape != others.shape or some.dtype != others.dtype:
        return False
    if _memcmp is None:
        return np.array_equal(some, others)
    return _memcmp(some.ctypes.data, others.ctypes.data, some.nbytes) == 0


def all_boundaries(mesh: LabelledMesh) -> dict[str, IntArray]:
    """Every boundary by its name, overlapping or not."""
    return {name: mesh.quads[mesh.faces.named(name)] for name in mesh.faces.names}


def all_parts(mesh: LabelledMesh) -> dict[str, IntArray]:
    """Every part by its name, overlapping or not."""
    return {name: mesh.volumes.named(name) for name in mesh.volumes.names}


def disjoint_boundaries(mesh: LabelledMesh) -> dict[str, IntArray]:
    """The disjoint blocks of the boundaries, for formats with one group a face."""
    return {name: mesh.quads[mesh.faces.cells(j)] for j, name in enumerate(mesh.faces.exclusive_names())}


def disjoint_parts(mesh: LabelledMesh) -> dict[str, IntArray]:
    """The disjoint blocks of the parts, for formats with one group a hex."""
    return {name: mesh.volumes.cells(j) for j, name in enumerate(mesh.volumes.exclusive_names())}


def _rotations() -> IntArray:
    """Corners (8, 8, 8) of a hexahedron turned so that edge 0-1 is a-b, by a and b; -1 where that is no edge."""
    table = np.full((8, 8, 8), -1, dtype=np.int64)
    joined = {frozenset(edge) for edge in HEX_EDGES.tolist()}
    for face in HEX_FACES[:, ::-1].tolist():
        beyond = [next(c for c in range(8) if c not in face and frozenset((c, own)) in joined) for own in face]
        for k in range(4):
            table[face[k], face[(k + 1) % 4]] = [*face[k:], *face[:k], *beyond[k:], *beyond[:k]]
    return table


_ROTATIONS = _rotations()


def _turned_alike(some: IntArray, others: IntArray) -> bool:
    """Whether each of some hexahedra (m, 8) is the other one, turned."""
    first, second = ((some == others[:, k : k + 1]).argmax(axis=1) for k in (0, 1))
    corners = _ROTATIONS[first, second]
    return bool((corners >= 0).all()) and np.array_equal(np.take_along_axis(some, corners, axis=1), others)


def same_quads(some: IntArray, others: IntArray) -> bool:
    """Whether two sets of quads are the same, the order of the quads and their first corners aside."""
    if some.shape != others.shape:
        return False
    if np.array_equal(some, others):
        return True
    return np.array_equal(_ordered(some), _ordered(others))


def _ordered(quads: IntArray) -> IntArray:
    width = quads.shape[1]
    first = quads[:, :4].argmin(axis=1)[:, None]
    turned = cyclic(quads[:, :4])
    if width >= 8:  # the middles of the edges turn with the corners
        turned = np.hstack(
            [turned, np.take_along_axis(quads[:, 4:8], (first + np.arange(4)) % 4, axis=1), quads[:, 8:]]
        )
    return turned[np.lexsort(turned.T[::-1])]
