"""An assembly drawn apart: every part moved away from the others, so that their contacts are seen.

Place in the flow: before a mesh is drawn; what comes out is for looking at only.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arrays import FloatArray
from ..errors import InputError
from ..mesh import HexMesh
from ..quality import part_surfaces

_SAME_PLACE = 0.05
"""Distance of two parts' middles, in sizes of the mesh, below which moving both outward does not part them."""

_BESIDE = 1.2
"""Room for a part drawn beside another, over its thickness."""


def explode(mesh: HexMesh, factor: float) -> HexMesh:
    """Move the parts of a mesh apart.

    Parameters
    ----------
    mesh : HexMesh
    factor : float
        How far, over the distance of each part's middle from that of all; parts in one place, such as a shaft in its
        bush, are drawn side by side along their shortest axis, by this share of the thicker one's thickness.

    Returns
    -------
    HexMesh
        Parts share no nodes; contacts, which are open now, are boundaries of their names on both sides.

    Raises
    ------
    InputError
        The factor is negative, or no number.
    """
    if not 0.0 <= factor < np.inf:
        raise InputError(f"explode is how far parts are drawn apart, a number from 0, not {factor!r}")
    surfaces = part_surfaces(mesh)
    if len(surfaces) < 2 or factor == 0.0:
        return mesh
    points, hexes, boundaries, parts = [], [], dict[str, list[np.ndarray]](), {}
    n_nodes = n_hexes = 0
    moves = _moves(mesh, factor)
    for surface, move in zip(surfaces, moves, strict=True):
        ids = mesh.parts[surface.name]
        used = np.unique(mesh.hexes[ids])
        number = np.full(mesh.n_nodes, -1, dtype=np.int64)
        number[used] = np.arange(n_nodes, n_nodes + len(used))
        points.append(mesh.points[used] + move)
        hexes.append(number[mesh.hexes[ids]])
        for name, quads in surface.named.items():
            boundaries.setdefault(name, []).append(number[quads])
        parts[surface.name] = np.arange(n_hexes, n_hexes + len(ids))
        n_nodes, n_hexes = n_nodes + len(used), n_hexes + len(ids)
    return replace(
        mesh,
        points=np.concatenate(points),
        hexes=np.concatenate(hexes),
        boundaries={name: np.concatenate(quads) for name, quads in boundaries.items()},
        interfaces={},
        parts=parts,
        structure=None,
        parents=None,
        origin=None,
    )


def _moves(mesh: HexMesh, factor: float) -> FloatArray:
    """By how much every part moves, (p, 3)."""
    boxes = np.array(
        [[f(mesh.points[mesh.hexes[ids]], axis=(0, 1)) for f in (np.min, np.max)] for ids in mesh.parts.values()]
    )
    middles = boxes.mean(axis=1)
    whole = np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])
    moves = factor * (middles - whole.mean(axis=0))
    size = float(np.linalg.norm(whole[1] - whole[0]))
    groups: list[list[int]] = []
    for part, middle in enumerate(middles):
        group = next(
            (
                g
                for g in groups
                if np.linalg.norm(middles[g[0]] - middle) < _SAME_PLACE * size and _overlap(boxes[g[0]], boxes[part])
            ),
            None,
        )
        if group is None:
            groups.append([part])
        else:
            group.append(part)
    for group in groups:
        extents = np.ptp(boxes[group], axis=1)
        axis = int(extents.max(axis=0).argmin())
        for rank, part in enumerate(group):
            moves[part, axis] += rank * factor * _BESIDE * extents[:, axis].max()
    return moves


def _overlap(one: FloatArray, other: FloatArray) -> bool:
    """Whether boxes (2, 3) have more than half of the smaller one's length along every axis in common."""
    common = np.minimum(one[1], other[1]) - np.maximum(one[0], other[0])
    return bool((common > 0.5 * np.minimum(one[1] - one[0], other[1] - other[0])).all())
