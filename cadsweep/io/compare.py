"""Whether what was read back is what was written.

Place in the flow: :func:`cadsweep.io.write` calls :func:`check_same` between writing a file and putting it in place.
"""

from __future__ import annotations

import numpy as np

from ..errors import CadSweepError
from ..mesh import HexMesh
from ..topology import IntArray
from .labels import LabelledMesh, cyclic

_CHUNK = 1 << 16


def check_same(mesh: LabelledMesh, back: HexMesh, *, one_group: bool = False) -> None:
    """Compare a mesh with what a reader made of its file: nodes, hexes, names, and the quads and hexes of each name.

    Quads may come in another order and begin at another corner, but not turn the other way.

    Parameters
    ----------
    one_group : bool
        The format keeps one group a cell: the disjoint blocks are expected.

    Raises
    ------
    CadSweepError
        The first difference.
    """
    for what, sent, got in (("nodes", mesh.points, back.points), ("hexes", mesh.hexes, back.hexes)):
        if sent.shape != got.shape:
            raise CadSweepError(f"reading it back gave {what} of shape {got.shape} instead of {sent.shape}")
        for start in range(0, len(sent), _CHUNK):
            if not np.array_equal(sent[start : start + _CHUNK], got[start : start + _CHUNK]):
                raise CadSweepError(f"reading it back gave other {what}, first in rows {start} and after")
    boundaries, parts = expected_groups(mesh, one_group=one_group)
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


def expected_groups(mesh: LabelledMesh, *, one_group: bool) -> tuple[dict[str, IntArray], dict[str, IntArray]]:
    """Boundaries (quads) and parts (hex ids) as the file should hold them."""
    if one_group:
        faces = mesh.faces.exclusive_names() if len(mesh.quads) else ()
        return (
            {name: mesh.quads[mesh.faces.cells(j)] for j, name in enumerate(faces)},
            {name: mesh.volumes.cells(j) for j, name in enumerate(mesh.volumes.exclusive_names())},
        )
    return (
        {name: mesh.quads[mesh.faces.named(name)] for name in mesh.faces.names},
        {name: mesh.volumes.named(name) for name in mesh.volumes.names},
    )


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
        turned = np.hstack([turned, np.take_along_axis(quads[:, 4:8], (first + np.arange(4)) % 4, axis=1), quads[:, 8:]])
    return turned[np.lexsort(turned.T[::-1])]
