"""Sheets of hexahedra under faces where the grid's own hexahedra would be flat once they lie on the model.

Two things make them flat: two quads of one hexahedron on one smooth patch (their common edge becomes one of 180
degrees), and two sides of one quad on one curve (so does their common corner). A sheet under a patch gives every quad
of it a hexahedron of its own, and every face beside it a row of quads along the border::

    before           a sheet under the face above
    --+--+--         --+--+--      of the face
      |  |             |  |        new hexahedra
    --+--+           ..+..+..
      |  |             |  |        as before, a copy of its nodes
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Solid
from ..cells import HEX_FACES
from ..errors import NotSweepableError

SMOOTH = 0.6
"""Angle from pi of the solid across an edge, radians, up to which the two faces are one patch: the scaled Jacobian of
one hexahedron there is at most the sine of this angle."""

_THICK = 0.3
"""Thickness of a sheet at first over the size of the grid; untangling evens it out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Fitted:
    """A mesh of one solid whose boundary knows the solid's faces and edges.

    Attributes
    ----------
    points : (n, 3) float64
    hexes : (m, 8) int64
    quads : (q, 4) int64
        The boundary, outward.
    labels : (q,) int64
        Face of every quad.
    chains : dict of int to int64 array
        Nodes of every edge, by id, from its start to its end.
    """

    points: FloatArray
    hexes: IntArray
    quads: IntArray
    labels: IntArray
    chains: dict[int, IntArray]


def lay_sheets(solid: Solid, mesh: Fitted, size: float) -> Fitted:
    """The mesh with a sheet under every face and smooth patch that needs one."""
    patches = _patches(solid)
    group_of = {face: j for j, own in enumerate(patches) for face in own}
    concave = {face for edge in solid.edges if edge.dihedral > pi + SMOOTH for face in edge.faces}
    for face in range(len(solid.faces)):
        if face in concave:
            continue
        if len(patches[group_of[face]]) > 1 and _bends(mesh, [face], patches[group_of[face]]):
            mesh = _with_sheet(mesh, [face], size)
    for own in patches:
        beyond = [f for f in range(len(solid.faces)) if f not in own]
        if _shares_hexes(mesh, own) or _bends(mesh, own, beyond):
            mesh = _with_sheet(mesh, own, size)
    _refuse_bent(solid, mesh)
    return mesh


def _refuse_bent(solid: Solid, mesh: Fitted) -> None:
    """Raise where a quad keeps two sides in turn on one edge: it would be flat there, however fine the grid.

    Raises
    ------
    NotSweepableError
        Names the edge.
    """
    ends = {(a, b): edge for edge, chain in mesh.chains.items() for a, b in itertools.pairwise(chain)}
    on_edge = {(int(a), int(b)): edge for (a, b), edge in ends.items()}
    on_edge |= {(b, a): edge for (a, b), edge in on_edge.items()}
    for quad in mesh.quads.tolist():
        own = [on_edge.get((quad[j], quad[(j + 1) % 4]), -1) for j in range(4)]
        bent = [own[j] for j in range(4) if own[j] >= 0 and own[j] == own[j - 1]]
        if bent:
            raise NotSweepableError(
                f"{solid.edges[bent[0]].label()} turns a corner on the grid, where no sheet can be laid"
            )


def _patches(solid: Solid) -> list[list[int]]:
    """Faces that smooth and concave edges join: at a concave one a sheet under one face would lie outside the solid."""
    patches = [{face} for face in range(len(solid.faces))]
    for edge in solid.edges:
        if edge.dihedral > pi - SMOOTH:
            joined = [own for own in patches if set(edge.faces) & own]
            patches = [own for own in patches if not set(edge.faces) & own] + [set[int]().union(*joined)]
    return [sorted(own) for own in patches]


def _shares_hexes(mesh: Fitted, faces: Sequence[int]) -> bool:
    """Whether some hexahedron has two quads on the faces."""
    own = np.sort(mesh.quads[np.isin(mesh.labels, faces)], axis=1)
    every = np.sort(mesh.hexes[:, HEX_FACES].reshape(-1, 4), axis=1)
    rows = np.concatenate([own, every])
    _, numbers = np.unique(rows, axis=0, return_inverse=True)
    is_own = np.isin(numbers[len(own) :], numbers[: len(own)]).reshape(-1, 6)
    return bool((is_own.sum(axis=1) > 1).any())


def _bends(mesh: Fitted, faces: Sequence[int], beyond: Sequence[int]) -> bool:
    """Whether some quad of `beyond` has two sides in turn on one edge of the faces."""
    inner = np.isin(mesh.labels, faces)
    border = {frozenset(side) for side in _sides(mesh.quads[inner]).tolist()}
    vertices = {int(chain[j]) for chain in mesh.chains.values() for j in (0, -1)}
    for quad in mesh.quads[np.isin(mesh.labels, beyond)].tolist():
        on = [frozenset((quad[j], quad[(j + 1) % 4])) in border for j in range(4)]
        if any(on[j - 1] and on[j] and quad[j] not in vertices for j in range(4)):
            return True
    return False


def _sides(quads: IntArray) -> IntArray:
    return np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)


def _with_sheet(mesh: Fitted, faces: Sequence[int], size: float) -> Fitted:
    """A sheet under the faces: what was there keeps to a copy of their nodes, hexahedra join the two."""
    on = np.isin(mesh.labels, faces)
    own = mesh.quads[on]
    nodes = np.unique(own)
    inner = np.arange(len(mesh.points))
    inner[nodes] = len(mesh.points) + np.arange(len(nodes))
    others, labels = mesh.quads[~on], mesh.labels[~on]
    sides = _sides(others)
    border = {tuple(side) for side in _sides(own).tolist()}
    beside = np.array([(b, a) in border for a, b in sides.tolist()], dtype=bool).reshape(len(sides))
    a, b = sides[beside].T
    chains = {edge: _stretched(chain, inner, mesh, on) for edge, chain in mesh.chains.items()}
    return Fitted(
        points=np.concatenate([mesh.points, mesh.points[nodes] - _THICK * size * _outward(mesh, own)[nodes]]),
        hexes=np.concatenate([inner[mesh.hexes], np.concatenate([inner[own], own], axis=1)]),
        quads=np.concatenate([own, inner[others], np.stack([a, b, inner[b], inner[a]], axis=1)]),
        labels=np.concatenate([mesh.labels[on], labels, np.repeat(labels, 4)[beside]]),
        chains=chains,
    )


def _outward(mesh: Fitted, quads: IntArray) -> FloatArray:
    """Unit normals (n, 3) at the nodes of the quads, zero where they cancel."""
    corners = mesh.points[quads]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    total = np.zeros_like(mesh.points)
    np.add.at(total, quads.ravel(), np.repeat(normals, 4, axis=0))
    lengths = np.linalg.norm(total, axis=1, keepdims=True)
    return np.where(lengths > 1e-9, total / np.maximum(lengths, 1e-9), 0.0)


def _stretched(chain: IntArray, inner: IntArray, mesh: Fitted, on: np.ndarray) -> IntArray:
    """Nodes of an edge: those of the faces' own edges stay, one that ends at the faces gets a segment more there."""
    sides = {frozenset(side) for side in _sides(mesh.quads[on]).tolist()}
    if frozenset(chain[:2].tolist()) in sides and frozenset(chain[-2:].tolist()) in sides:
        return chain
    moved = inner[chain]
    first = chain[:1] if moved[0] != chain[0] else chain[:0]
    last = chain[-1:] if moved[-1] != chain[-1] else chain[:0]
    return np.concatenate([first, moved, last])
