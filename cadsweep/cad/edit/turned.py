"""A turned body: its axis, its rings and shoulders, and what it has beside them.

Place in the flow: read by :mod:`.strips` and :mod:`.spokes`, which part such a body.

Method: the axis is the one that most round faces are about. What is neither about it nor square to it hangs together,
by its vertices, in features.

A rounding between a shoulder and a cylinder is parted from the body as a ring, by the plane and the cylinder through
the middle of its arc, so that all other cells have sharp edges. The arc is divided half way, which makes a fourth
corner (:mod:`.fillets`): grids on all sides agree with any neighbour::

        ____________
       /:|          |        the ring; its plane goes on through all of the body, as those of shoulders do
      |..|..........|..
      |  |          |
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import pi
from typing import Any, Self

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.gp import gp_Ax3, gp_Cylinder, gp_Dir, gp_Pln, gp_Pnt

from ...arrays import FloatArray
from ...brep import Face, Solid
from ..shapes import shapes_of
from .axial import round_axis
from .central import rectangle_tool

ALONG = 1e-6
"""Sine of the angle of two directions up to which they are one, or square to each other."""
MEET = 1e-4
"""Distance of two axes, as a share of the cell's size, up to which they are one: what CAD programs round to."""
TANGENT = 1e-3
"""Radians from pi up to which a rounding runs tangent into its neighbour."""
MOSTLY = 0.5
"""Share of the cell's area that is about one axis, or square to it, at least."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Line:
    """The axis of a round face."""

    place: FloatArray
    direction: FloatArray

    def is_same(self, other: _Line, near: float) -> bool:
        """Whether two axes are one."""
        return self.is_along(other.direction) and self.off(other.place) < near

    def is_along(self, direction: FloatArray) -> bool:
        return float(np.linalg.norm(np.cross(self.direction, direction))) < ALONG

    def off(self, place: FloatArray) -> float:
        """Distance of a point from the axis."""
        return float(np.linalg.norm(np.cross(place - self.place, self.direction)))


def _most_about(lines: Sequence[_Line], areas: Sequence[float], near: float) -> tuple[_Line, float]:
    """The axis that faces of the greatest area are about, the first of each that is one axis, and that area."""
    directions, places = (np.array(rows) for rows in zip(*((own.direction, own.place) for own in lines), strict=True))
    firsts: list[int] = []
    sums = np.zeros(len(lines))
    for j, area in enumerate(areas):
        along = np.linalg.norm(np.cross(directions[firsts], directions[j]), axis=1) < ALONG
        off = np.linalg.norm(np.cross(places[j] - places[firsts], directions[firsts]), axis=1)
        same = np.flatnonzero(along & (off < near))
        if not len(same):
            firsts.append(j)
        sums[firsts[int(same[0])] if len(same) else j] += area
    best = int(np.argmax(sums))
    return lines[best], float(sums[best])


@dataclass(frozen=True, kw_only=True, eq=False)
class Feature:
    """What is not turned, as it hangs together.

    Attributes
    ----------
    faces : tuple of int
    points : (n, 3) float64
        Along its edges.
    """

    faces: tuple[int, ...]
    points: FloatArray


class TurnedBody:
    """A turned body: its axis and what it has beside turned faces.

    Attributes
    ----------
    bosses : frozenset of int
        Faces of what stands on the turned body: an inner corner with one of them is the turned face's to part.
    """

    bosses: frozenset[int] = frozenset()

    def __init__(self, solid: Solid, flat: float, line: _Line, lines: Sequence[_Line | None]) -> None:
        self.solid, self.flat, self.line, self.lines = solid, flat, line, lines
        self.near = MEET * solid.size

    @classmethod
    def read(cls, solid: Solid, flat: float) -> Self | None:
        """The body; None where most of the cell is not about one axis."""
        holder = shapes_of(solid)
        lines = [_line_of(holder.faces[face.id]) for face in solid.faces]
        round_ones = [(face.area, own) for face, own in zip(solid.faces, lines, strict=True) if own is not None]
        if not round_ones:
            return None
        line, area = _most_about([own for _, own in round_ones], [own for own, _ in round_ones], MEET * solid.size)
        across = sum(f.area for f in solid.faces if f.kind == "plane" and line.is_along(f.normal))
        whole = sum(face.area for face in solid.faces)
        return cls(solid, flat, line, lines) if area + across > MOSTLY * whole else None

    def is_turned(self, face: Face) -> bool:
        """Whether a face is about the axis, or square to it."""
        own = self.lines[face.id]
        if own is None:
            return face.kind == "plane" and self.line.is_along(face.normal)
        return own.is_same(self.line, self.near)

    def direction(self, face: Face) -> FloatArray | None:
        """A plane's normal, or a round face's axis."""
        own = self.lines[face.id]
        return own.direction if own is not None else face.normal if face.kind == "plane" else None

    def features(self) -> list[Feature]:
        """What is not turned, as it hangs together by its vertices."""
        groups: list[tuple[set[int], set[int]]] = []
        for face in self.solid.faces:
            if self.is_turned(face):
                continue
            own, vertices = {face.id}, {v for e in face.edges for v in self.ends(e)}
            for group in [g for g in groups if g[1] & vertices]:
                groups.remove(group)
                own, vertices = own | group[0], vertices | group[1]
            groups.append((own, vertices))
        at = np.linspace(0.0, 1.0, 17)
        found = []
        for own, _ in groups:
            edges = sorted({e for f in own for e in self.solid.faces[f].edges})
            points = np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in edges])
            found.append(Feature(faces=tuple(sorted(own)), points=points))
        return found

    def ends(self, edge: int) -> tuple[int, int]:
        return self.solid.edges[edge].start, self.solid.edges[edge].end

    def way(self, feature: Feature) -> FloatArray | None:
        """The direction across the axis in which a feature goes; empty where it goes along the axis; None for none."""
        directions = [self.direction(self.solid.faces[f]) for f in feature.faces]
        if any(direction is None for direction in directions):
            return None
        kinds = [self.solid.faces[f].kind == "plane" for f in feature.faces]
        if all(fits(self.line.direction, d, plane) for d, plane in zip(directions, kinds, strict=True)):
            return np.empty(0)
        for way, _ in sorted(zip(directions, kinds, strict=True), key=lambda pair: pair[1]):
            if way is None or abs(float(way @ self.line.direction)) > ALONG:
                continue
            if all(fits(way, d, plane) for d, plane in zip(directions, kinds, strict=True)):
                return way
        return None

    def floors(self, features: Sequence[Feature], way: FloatArray) -> list[float]:
        """Where what goes along a direction has a floor across it that ends inside the material."""
        faces = [self.solid.faces[f] for feature in features for f in feature.faces]
        found = [
            float((face.center - self.line.place) @ way)
            for face in faces
            if face.kind == "plane"
            and abs(float(face.normal @ way)) > 1.0 - ALONG
            and any(self.solid.edges[e].dihedral > pi + self.flat for e in face.edges)
        ]
        return unlike(found, self.near)

    def levels(self) -> list[float]:
        """Where shoulders are: planes square to the axis with an inner corner."""
        found = [
            float((face.center - self.line.place) @ self.line.direction)
            for face in self.solid.faces
            if face.kind == "plane" and self.line.is_along(face.normal) and self.is_hollow(face)
        ]
        return unlike([*found, *(level for level, _ in self.roundings())], self.near)

    def is_hollow(self, face: Face) -> bool:
        """Whether a turned face meets another, or a boss, in an inner corner."""
        return any(
            self.solid.edges[e].dihedral > pi + self.flat
            and all(f in self.bosses or self.is_turned(self.solid.faces[f]) for f in self.solid.edges[e].faces)
            for e in face.edges
        )

    def radii(self) -> list[float]:
        """Radii of all cylinders about the axis."""
        holder = shapes_of(self.solid)
        return unlike(
            [
                BRepAdaptor_Surface(holder.faces[face.id]).Cylinder().Radius()
                for face in self.solid.faces
                if face.kind == "cylinder" and self.is_turned(face)
            ]
            + [cylinder.Radius() for _, cylinder in self.roundings()],
            self.near,
        )

    def radius(self) -> float:
        """How far the turned faces reach from the axis."""
        at = np.linspace(0.0, 1.0, 9)
        edges = {e for face in self.solid.faces if self.is_turned(face) for e in face.edges}
        points = np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in sorted(edges)]) - self.line.place
        return float(np.linalg.norm(np.cross(points, self.line.direction), axis=1).max())

    def rings(self) -> list[tuple[float, Any]]:
        """Radii and surfaces of the cylinders that end in an inner corner, or part a rounding."""
        holder = shapes_of(self.solid)
        found: list[tuple[float, Any]] = []
        for face in self.solid.faces:
            if face.kind == "cylinder" and self.is_turned(face) and self.is_hollow(face):
                cylinder = BRepAdaptor_Surface(holder.faces[face.id]).Cylinder()
                if all(abs(cylinder.Radius() - radius) > self.near for radius, _ in found):
                    found.append((cylinder.Radius(), cylinder))
        for _, cylinder in self.roundings():
            if all(abs(cylinder.Radius() - radius) > self.near for radius, _ in found):
                found.append((cylinder.Radius(), cylinder))
        return found

    def roundings(self) -> list[tuple[float, Any]]:
        """Where the arcs of roundings have their middles: how far along the axis, and the cylinder about it."""
        holder, axis = shapes_of(self.solid), self.line.direction
        found: list[tuple[float, Any]] = []
        for face in self.rounded_faces():
            torus = BRepAdaptor_Surface(holder.faces[face.id]).Torus()
            place = _array(torus.Location())
            frame = gp_Ax3(torus.Location(), gp_Dir(*map(float, axis)))
            found.append((float((place - self.line.place) @ axis), gp_Cylinder(frame, torus.MajorRadius())))
        return found

    def rounded_faces(self) -> list[Face]:
        """Tori that round outer corners of shoulders and cylinders of the body, and no more."""
        return [
            face
            for face in self.solid.faces
            if face.kind == "torus" and self.is_turned(face) and self._is_rounding(face)
        ]

    def _is_rounding(self, face: Face) -> bool:
        """Whether a torus rounds an outer corner of a plane square to the axis and a cylinder about it, and no more."""
        for edge in (self.solid.edges[e] for e in face.edges):
            other = self.solid.faces[edge.faces[edge.faces[0] == face.id]]
            is_known = other.kind in ("plane", "cylinder", "torus") and self.is_turned(other)
            if abs(edge.dihedral - pi) > TANGENT or not is_known:
                return False
        torus = BRepAdaptor_Surface(shapes_of(self.solid).faces[face.id]).Torus()
        uv = face.surface.edge_uv(face.edges[0], np.array([0.5]))
        out = face.surface.evaluate(uv)[0] - _array(torus.Location())
        along = (out @ self.line.direction) * self.line.direction
        aside = out - along
        arm = aside * (1.0 - torus.MajorRadius() / float(np.linalg.norm(aside))) + along
        return float(face.surface.normals(uv)[0] @ arm) > 0.0

    def parting_lines(self) -> list[FloatArray]:
        """Unit vectors from the axis to the lines along it at which its round faces are parted."""
        found: list[FloatArray] = []
        for edge in self.solid.edges:
            if not all(self.is_turned(self.solid.faces[f]) for f in edge.faces):
                continue
            first, last = self.solid.vertices[[edge.start, edge.end]] - self.line.place
            aside = first - (first @ self.line.direction) * self.line.direction
            if self.line.off(last + self.line.place - aside) < self.near < float(np.linalg.norm(aside)):
                way = aside / np.linalg.norm(aside)
                if all(float(way @ other) < 1.0 - ALONG for other in found):
                    found.append(way)
        return found

    def turned_tools(
        self, levels: Sequence[float], seams: Callable[[float], Sequence[FloatArray]] | None = None
    ) -> Iterator[Any]:
        """The planes of all levels, and the cylinders of all rings, by their radius parted at two or more directions.

        Without `seams` the cylinders are in halves.
        """
        axis, reach = self.line.direction, 1.5 * self.solid.size
        for level in levels:
            place = self.line.place + level * axis
            plane = gp_Pln(gp_Pnt(*map(float, place)), gp_Dir(*map(float, axis)))
            yield BRepBuilderAPI_MakeFace(plane, -reach, reach, -reach, reach).Face()
        for _, cylinder in self.rings():
            location = np.array([cylinder.Location().X(), cylinder.Location().Y(), cylinder.Location().Z()])
            middle = float((self.solid.vertices.mean(axis=0) - location) @ _array(cylinder.Axis().Direction()))
            u = [0.0, pi]
            if seams is not None:
                axes = np.array([_array(side.Direction()) for side in (cylinder.XAxis(), cylinder.YAxis())])
                u = sorted(float(np.arctan2(*(axes @ way)[::-1])) for way in seams(cylinder.Radius()))
            for first, last in pairwise([*u, u[0] + 2.0 * pi]):
                yield BRepBuilderAPI_MakeFace(cylinder, first, last, middle - reach, middle + reach).Face()

    def rectangle(
        self, frame: FloatArray, across: int, offset: float, other: tuple[float, float], length: tuple[float, float]
    ) -> Any:  # fmt: skip
        """A plane face square to one of the frame's first two directions."""
        x = frame[1 - across]
        normal = np.cross(x, frame[2])
        place = self.line.place + offset * frame[across]
        return rectangle_tool(place, normal, x, other, length)


def fits(way: FloatArray, direction: FloatArray | None, is_plane: bool) -> bool:
    """Whether a face with a direction is a wall along a way, or a plane across it."""
    assert direction is not None
    cosine = abs(float(way @ direction))
    return cosine > 1.0 - ALONG or (is_plane and cosine < ALONG)


def unlike(values: Sequence[float], near: float) -> list[float]:
    """Values that differ, in order."""
    found: list[float] = []
    for value in sorted(values):
        if not found or value - found[-1] > near:
            found.append(value)
    return found


def _line_of(shape: Any) -> _Line | None:
    """The axis of a round face; None for any other."""
    line = round_axis(shape)
    return None if line is None else _Line(place=line[0], direction=line[1])


def _array(thing: Any) -> FloatArray:
    return np.array([thing.X(), thing.Y(), thing.Z()])


__all__ = ["ALONG", "Feature", "TurnedBody", "fits", "unlike"]
