"""Solids that nearly touch: gaps too small to be meant, and too wide for the imprint to close.

Place in the flow: called by :mod:`.joining` on the finished cells; what it finds becomes notes.

Method: faces of two solids that no solid shares, whose boxes are near, are asked at some points inside each: how far is
the other face along the normal, and does it look back? Solids that touch nowhere are asked for the least distance of
such faces, too; where another solid fills what is between them, as a layer of glue does, there is no gap. Not found:
gaps narrower across than the points are apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt, gp_Pnt2d
from OCP.TopAbs import TopAbs_State

from ...arrays import FloatArray
from ...brep import Face, Part
from ..shapes import bounds, near_boxes, shapes_of

WIDEST = 1e-3
"""Gap, as a share of the part's size, below which it is asked whether it was meant."""
_FACING = -0.9
"""Greatest cosine between the normals of two faces that face each other."""
_GRID = (0.5, 0.1, 0.9, 0.3, 0.7)
"""Where on a face distances are measured, its middle first, and never at the rim, where neighbours meet."""
_MOST_MEASURED = 32
"""Pairs of faces of two solids whose least distance is measured, which takes milliseconds each."""


@dataclass(frozen=True, kw_only=True)
class Gap:
    """Two cells a little apart where they face each other: the least distance found, where, and the greatest."""

    cells: tuple[int, int]
    distance: float
    place: FloatArray
    widest: float


@dataclass(frozen=True, eq=False)
class _Side:
    """A face of one cell alone."""

    cell: int
    face: Face
    shape: Any

    @cached_property
    def box(self) -> FloatArray:
        return bounds(self.shape)

    @cached_property
    def _classifier(self) -> Any:
        return BRepTopAdaptor_FClass2d(self.shape, 1e-9)

    def contains(self, uv: FloatArray) -> list[bool]:
        return [self._classifier.Perform(gp_Pnt2d(float(u), float(v))) == TopAbs_State.TopAbs_IN for u, v in uv]

    @cached_property
    def samples(self) -> tuple[FloatArray, FloatArray]:
        """Points (m, 3) inside the face and the outward normals (m, 3) there."""
        u0, u1, v0, v1 = BRepTools.UVBounds_s(self.shape)
        uv = np.array([(u0 + a * (u1 - u0), v0 + b * (v1 - v0)) for a in _GRID for b in _GRID])
        uv = uv[self.contains(uv)]
        return self.face.surface.evaluate(uv), self.face.surface.normals(uv)


def find_gaps(part: Part, *, tolerance: float) -> list[Gap]:
    """Find pairs of cells of different solids that are a little apart where they face each other.

    Parameters
    ----------
    part : Part
        Imprinted.
    tolerance : float
        Distance, working units, up to which faces count as touching.
    """
    corners = np.array([[solid.vertices.min(axis=0), solid.vertices.max(axis=0)] for solid in part.solids])
    limit = WIDEST * float(np.linalg.norm(corners[:, 1].max(axis=0) - corners[:, 0].min(axis=0)))
    if limit <= tolerance:
        return []
    uses = Counter(key for solid in part.solids for key in solid.face_keys.tolist())
    sides: list[list[_Side]] = []
    for cell, solid in enumerate(part.solids):
        holder = shapes_of(solid)
        alone = [face for face in solid.faces if uses[int(solid.face_keys[face.id])] == 1]
        sides.append([_Side(cell, face, holder.faces[face.id]) for face in alone])
    found = []
    for i, j in _near_cells(part, sides, limit):
        gap = _gap(part, _near_sides(sides[i], sides[j], limit), tolerance, limit)
        if gap is not None:
            found.append(gap)
    return found


def _near_cells(part: Part, sides: Sequence[Sequence[_Side]], reach: float) -> Iterator[tuple[int, int]]:
    boxes = np.array([_around(own) for own in sides])
    near = np.triu(near_boxes(boxes, boxes, reach), 1)
    for i, j in np.argwhere(near):
        if part.owners[i] != part.owners[j]:
            yield int(i), int(j)


def _around(sides: Sequence[_Side]) -> FloatArray:
    if not sides:  # a cell whose faces are all shared is near nothing
        return np.array([[np.inf] * 3, [-np.inf] * 3])
    boxes = np.array([side.box for side in sides])
    return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _near_sides(first: Sequence[_Side], second: Sequence[_Side], reach: float) -> list[tuple[_Side, _Side]]:
    near = near_boxes(np.array([s.box for s in first]), np.array([s.box for s in second]), reach)
    return [(first[a], second[b]) for a, b in np.argwhere(near)]


def _gap(part: Part, pairs: Sequence[tuple[_Side, _Side]], tolerance: float, limit: float) -> Gap | None:
    """The gap between two cells, from their near faces."""
    if not pairs:
        return None
    cells = pairs[0][0].cell, pairs[0][1].cell
    widths: list[FloatArray] = []
    places: list[FloatArray] = []
    for one, other in pairs:
        if one.face.kind == other.face.kind == "plane" and not one.face.normal @ other.face.normal < _FACING:
            continue
        for near, far in ((one, other), (other, one)):
            width, place = _facing(near, far, tolerance, limit)
            widths.append(width)
            places.append(place)
    width, place = np.concatenate([np.empty(0), *widths]), np.concatenate([np.empty((0, 3)), *places])
    if not len(width) and len(pairs) <= _MOST_MEASURED and not _touch(part, *cells):
        width, place = _least(part, pairs, tolerance, limit)
    if not len(width):
        return None
    k = int(width.argmin())
    return Gap(cells=cells, distance=float(width[k]), place=place[k], widest=float(width.max()))


def _facing(near: _Side, far: _Side, tolerance: float, limit: float) -> tuple[FloatArray, FloatArray]:
    """Widths (m,) and places (m, 3) of gaps at points inside one face whose feet lie inside the other."""
    points, normals = near.samples
    inside = (points >= far.box[0] - limit).all(axis=1) & (points <= far.box[1] + limit).all(axis=1)
    points, normals = points[inside], normals[inside]
    if not len(points):
        return np.empty(0), np.empty((0, 3))
    surface = far.face.surface
    uv = surface.project(points)
    away = surface.evaluate(uv) - points
    width = np.linalg.norm(away, axis=1)
    ahead = np.einsum("md,md->m", away, normals) > -_FACING * width
    chosen = np.flatnonzero((width > tolerance) & (width < limit) & ahead)
    looks_back = np.einsum("md,md->m", surface.normals(uv[chosen]), normals[chosen]) < _FACING
    chosen = chosen[looks_back]
    chosen = chosen[far.contains(uv[chosen])]
    return width[chosen], points[chosen]


def _touch(part: Part, i: int, j: int) -> bool:
    return bool(np.isin(part.solids[i].vertex_keys, part.solids[j].vertex_keys).any())


def _least(
    part: Part, pairs: Sequence[tuple[_Side, _Side]], tolerance: float, limit: float
) -> tuple[FloatArray, FloatArray]:
    """The least distance (1,) of the faces, and its place (1, 3); both empty where it is no small gap."""
    best, place, middle = limit, None, np.zeros(3)
    for one, other in pairs:
        measured = BRepExtrema_DistShapeShape(one.shape, other.shape)
        if measured.IsDone() and measured.Value() < best:
            ends = np.array([[p.X(), p.Y(), p.Z()] for p in (measured.PointOnShape1(1), measured.PointOnShape2(1))])
            best, place, middle = measured.Value(), ends[:1], ends.mean(axis=0)
    cells = pairs[0][0].cell, pairs[0][1].cell
    if place is None or best <= tolerance or _is_filled(part, middle, tolerance, beside=cells):
        return np.empty(0), np.empty((0, 3))
    return np.array([best]), place


def _is_filled(part: Part, place: FloatArray, tolerance: float, *, beside: tuple[int, int]) -> bool:
    """Whether a point (3,) lies in or on a cell other than two."""
    for cell, solid in enumerate(part.solids):
        holder = shapes_of(solid)
        low, high = bounds(holder.shape)
        if cell in beside or not ((place >= low - tolerance) & (place <= high + tolerance)).all():
            continue
        state = BRepClass3d_SolidClassifier(holder.shape, gp_Pnt(*place.tolist()), tolerance).State()
        if state in (TopAbs_State.TopAbs_IN, TopAbs_State.TopAbs_ON):
            return True
    return False
