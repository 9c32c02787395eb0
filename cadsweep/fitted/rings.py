"""Narrow ring faces, such as chamfers and steps around a bore, left out of a solid and laid in later.

A ring of a cell's width is seldom found on a grid, and needs not be: without it the two faces on its sides meet along
one of its borders, and a sheet around one of them leaves a rim of quads there, which are the ring's.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import IntArray
from ..brep import Solid

_NARROW = 2.0
"""Width of a ring over the size of the grid up to which it is left out."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Ring:
    """A ring that was left out, by ids in the solid that it is of.

    Attributes
    ----------
    face : int
    inner : int
        The face beside it around which a sheet is to be laid.
    lost, kept : tuple of int
        Its edges to that face, which are left out as well, and the others.
    """

    face: int
    inner: int
    lost: tuple[int, ...]
    kept: tuple[int, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class Reduced:
    """A solid without its narrow rings.

    Attributes
    ----------
    solid : Solid
    faces, edges : int64 arrays
        Those of the whole solid that its faces and edges are.
    of_face : (n_faces,) int64
        For every face of the whole solid the one here that covers it.
    rings : tuple of Ring
        In the order in which they were left out.
    """

    solid: Solid
    faces: IntArray
    edges: IntArray
    of_face: IntArray
    rings: tuple[Ring, ...]


def without_rings(solid: Solid, size: float, among: Collection[int] | None = None) -> Reduced:
    """The solid without rings that are narrow for a grid of a size, of all its faces or `among` some."""
    beside = {edge.id: edge.faces for edge in solid.edges}
    loops = {face.id: [loop.edges for loop in face.loops] for face in solid.faces}
    covers = np.arange(len(solid.faces))
    rings: list[Ring] = []
    with_two = [
        face
        for face in solid.faces
        if len(face.loops) == 2 and not face.handles and (among is None or face.id in among)
    ]
    widths = {face.id: 2.0 * face.area / sum(solid.edges[e].length for e in face.edges) for face in with_two}
    for face in sorted(with_two, key=lambda face: widths[face.id]):
        own = loops[face.id]
        across = [{f for e in loop for f in beside[e]} - {face.id} for loop in own]
        if widths[face.id] > _NARROW * size or any(len(faces) != 1 for faces in across) or across[0] == across[1]:
            continue
        (one,), (other,) = across
        lost, kept = own
        if solid.faces[one].area > solid.faces[other].area:
            one, lost, kept = other, kept, lost
        if not any(set(loop) == set(lost) for loop in loops[one]):
            continue
        rings.append(Ring(face=face.id, inner=one, lost=lost, kept=kept))
        covers[covers == face.id] = one
        for e in kept:
            beside[e] = tuple(one if f == face.id else f for f in beside[e])  # type: ignore[assignment]
        for e in lost:
            del beside[e]
        loops[one] = [kept if set(loop) == set(lost) else loop for loop in loops[one]]
        del loops[face.id]
    faces, edges = np.array(sorted(loops), dtype=np.int64), np.array(sorted(beside), dtype=np.int64)
    number = np.full(len(solid.faces), -1, dtype=np.int64)
    number[faces] = np.arange(len(faces))
    edge_number = {int(e): j for j, e in enumerate(edges)}
    reduced = replace(
        solid,
        faces=tuple(
            replace(
                solid.faces[f],
                id=j,
                number=solid.faces[f].known,
                loops=tuple(
                    replace(solid.faces[f].loops[0], edges=tuple(edge_number[e] for e in loop)) for loop in loops[f]
                ),
            )
            for j, f in enumerate(faces.tolist())
        ),
        edges=tuple(
            replace(solid.edges[e], id=j, faces=(int(number[beside[e][0]]), int(number[beside[e][1]])))
            for j, e in enumerate(edges.tolist())
        ),
    )
    return Reduced(solid=reduced, faces=faces, edges=edges, of_face=number[covers], rings=tuple(rings))
