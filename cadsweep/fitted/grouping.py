"""Which faces of a solid are taken as one: those that run smoothly into each other, and what is far too narrow.

Faces are united across smooth edges, small ones first, but never so that a sharp edge would have one face on both its
sides: it would end inside that face. Faces that are far narrower than a cell are united with one beside them as well,
whatever the angle: they are bridged, and whoever asks is told.
"""

from __future__ import annotations

from collections import defaultdict
from math import pi

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Edge, Solid

SMOOTH = 0.05
"""Angle, radians, up to which two faces run into each other along an edge, and two edges at a vertex."""
BRIDGED = 0.15
"""Width over the size below which a face is bridged: of what is wider a row of quads is good enough."""


def group_faces(solid: Solid, axes: FloatArray, size: float, *, ridges: bool) -> tuple[IntArray, tuple[int, ...]]:
    """The group (n_faces,) of every face, numbered in the order of their first ones, and the faces that are bridged.

    With `ridges` blends narrower than a cell that do not run along the grid stay parted from the faces on one of
    their sides: quads laid across such a blend would cut it in steps.
    """
    smooth = [edge for edge in solid.edges if is_smooth(solid, edge)]
    kept = _ridges(solid, axes, smooth, size) if ridges else set[int]()
    return _bridged(solid, _groups(solid, smooth, kept), BRIDGED * size)


def is_smooth(solid: Solid, edge: Edge) -> bool:
    """Whether the faces beside an edge run into each other all along it."""
    if abs(edge.dihedral - pi) > SMOOTH:
        return False
    places = edge.curve.evaluate(np.array([0.05, 0.3, 0.7, 0.95]))
    one, other = (solid.faces[face].surface for face in edge.faces)
    cosines = np.einsum("md,md->m", one.normals(one.project(places)), other.normals(other.project(places)))
    return bool(cosines.min() > np.cos(SMOOTH))


def _ridges(solid: Solid, axes: FloatArray, smooth: list[Edge], size: float) -> set[int]:
    """Smooth edges between a blend narrower than a cell and a face beside it, of the faces with most of these.

    Of the two faces that a blend lies between one has them: the strip between two would be narrower than a cell.
    """
    widths = [2.0 * face.area / max(sum(solid.edges[e].length for e in face.edges), 1e-300) for face in solid.faces]
    is_blend = [face.kind != "plane" and width < size for face, width in zip(solid.faces, widths, strict=True)]
    beside: dict[int, list[tuple[int, Edge]]] = defaultdict(list)
    of_blend: dict[int, set[int]] = defaultdict(set)
    for edge in smooth:
        for face, blend in (edge.faces, edge.faces[::-1]):
            if is_blend[blend] and not is_blend[face]:
                beside[face].append((blend, edge))
                of_blend[blend].add(face)

    def unaligned(face: int) -> float:
        return sum(edge.length for _, edge in beside[face] if edge.kind != "line" or _leans(edge, axes))

    found, barred = set[int](), set[int]()
    for face in sorted(beside, key=unaligned, reverse=True):
        if face not in barred and unaligned(face) > size:
            found |= {edge.id for _, edge in beside[face]}
            barred |= {other for blend, _ in beside[face] for other in of_blend[blend]}
    return found


def _leans(edge: Edge, axes: FloatArray) -> bool:
    return bool(np.sort(np.abs(axes @ edge.tangents[0]))[1] > SMOOTH)


def _groups(solid: Solid, smooth: list[Edge], kept: set[int]) -> IntArray:
    """The united face of every face, numbered in the order of their first ones; not across edges that are kept."""
    of_face = np.arange(len(solid.faces))
    passed = {edge.id for edge in smooth}
    sharp = np.array([edge.faces for edge in solid.edges if edge.id not in passed], dtype=np.int64).reshape(-1, 2)

    def order(edge: Edge) -> tuple[bool, float, float]:
        one, other = (solid.faces[face] for face in edge.faces)
        return not (one.key and one.key == other.key), min(one.area, other.area), -edge.length

    for edge in sorted((edge for edge in smooth if edge.id not in kept), key=order):
        low, high = sorted(of_face[list(edge.faces)].tolist())
        tried = np.where(of_face == high, low, of_face)
        if not (tried[sharp[:, 0]] == tried[sharp[:, 1]]).any():
            of_face = tried
    return np.unique(of_face, return_inverse=True)[1].astype(np.int64)


def _bridged(solid: Solid, of_face: IntArray, length: float) -> tuple[IntArray, tuple[int, ...]]:
    """Groups narrower than a length united with the one beside that they share most of their border with."""
    found: list[int] = []
    while True:
        border: dict[int, dict[int, float]] = defaultdict(lambda: defaultdict(float))
        for edge in solid.edges:
            low, high = of_face[list(edge.faces)].tolist()
            if low != high:
                border[low][high] += edge.length
                border[high][low] += edge.length
        areas = np.bincount(of_face, weights=[face.area for face in solid.faces])
        widths = {own: 2.0 * areas[own] / sum(beside.values()) for own, beside in border.items()}
        narrowest = min(widths, key=lambda own: widths[own], default=None)
        if narrowest is None or widths[narrowest] >= length:
            return np.unique(of_face, return_inverse=True)[1].astype(np.int64), tuple(found)
        beside = border[narrowest]
        found += np.flatnonzero(of_face == narrowest).tolist()
        of_face = np.where(of_face == narrowest, max(beside, key=lambda other: beside[other]), of_face)
