"""Planes along what goes across the axis of a turned body, its rings and levels: all at once, so that all agree.

Place in the flow: a candidate of :mod:`.cutters` for a part that is turned but for what goes across its axis: holes,
keyways, slots.

Method: seen along the axis, two planes beside such a feature leave a strip that is swept along the feature, and pieces
beside it that are swept along the axis::

         ___ w ___            The strip's sides are walls of both, with grids on them.
       /|    |    |\\          Every shoulder's plane goes through all of the body, and every ring's cylinder: they
      / |  f |    | \\         part a strip into slices that are swept one after the other, and what is beside it
     (  |----|----|  )        into columns.
      \\ |    |    | /         The floor `f` of a keyway goes through its strip only: beyond, it leaves sharp edges.
       \\|____|____|/

What goes across in two directions square to each other gets two strips. They cross in bricks, each of which is a slice
of either.

Not handled: features that are slanted to the axis or to each other, or as wide as the body; shoulders that run through
a feature; bosses across the axis.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt

from ...arrays import FloatArray
from ...brep import Face, Solid
from ..shapes import shapes_of
from .axial import round_axis
from .central import Cutter
from .strip_widths import Feature, Section

ALONG = 1e-6
"""Sine of the angle of two directions up to which they are one, or square to each other."""
MEET = 1e-4
"""Distance of two axes, as a share of the cell's size, up to which they are one: what CAD programs round to."""
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


def along_features(solid: Solid, flat: float) -> list[Cutter]:
    """Strips along what goes across the axis of a turned body, its rings and levels; none where nothing does.

    Parameters
    ----------
    solid : Solid
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    body = _Body.read(solid, flat)
    if body is None:
        return []
    tools = body.tools()
    if not tools:
        return []
    return [
        Cutter(
            kind="boxes",
            reason="strips along what goes across the axis of a turned body, its rings and levels",
            tools=tuple(tools),
            weight=solid.size,
            leads=True,
        )
    ]


class _Body:
    """A turned body: its axis, its frame and what goes across."""

    def __init__(self, solid: Solid, flat: float, line: _Line, lines: Sequence[_Line | None]) -> None:
        self.solid, self.flat, self.line, self.lines = solid, flat, line, lines
        self.near = MEET * solid.size

    @classmethod
    def read(cls, solid: Solid, flat: float) -> _Body | None:
        """The body; None where most of the cell is not about one axis."""
        holder = shapes_of(solid)
        lines = [_line_of(holder.faces[face.id]) for face in solid.faces]
        sums: list[tuple[_Line, float]] = []
        for face, own in zip(solid.faces, lines, strict=True):
            if own is None:
                continue
            for j, (known, area) in enumerate(sums):
                if known.is_same(own, MEET * solid.size):
                    sums[j] = (known, area + face.area)
                    break
            else:
                sums.append((own, face.area))
        if not sums:
            return None
        line, area = max(sums, key=lambda pair: pair[1])
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

    def tools(self) -> list[Any]:
        """All faces that part the body; none where there is nothing across, or no room."""
        features = self.features()
        ways = [self.way(feature) for feature in features]
        if any(way is None for way in ways):
            return []
        own = [way for way in ways if way is not None and len(way)]
        if not own:
            return []
        axis = self.line.direction
        x = own[0]
        frame = np.array([x, np.cross(axis, x), axis])
        # By direction: what goes along the first of the frame, what along the second.
        across: tuple[list[Feature], list[Feature]] = ([], [])
        beside: list[Feature] = []
        for feature, way in zip(features, ways, strict=True):
            turned = Feature(faces=feature.faces, points=(feature.points - self.line.place) @ frame.T)
            assert way is not None
            if not len(way):
                beside.append(turned)
                continue
            cosines = np.abs(np.asarray(frame[:2] @ way))
            if cosines.max() < 1.0 - ALONG:
                return []
            across[int(np.argmax(cosines))].append(turned)
        section = Section(
            across=across,
            beside=beside,
            floors=(self.floors(across[0], frame[0]), self.floors(across[1], frame[1])),
            radii=self.radii(),
            corners=[corner for feature in beside if feature.surrounds() for corner in self.corners(feature, frame)],
        )
        levels = self.levels()
        widths = section.widths() if all(self.has_room(f, levels) for own in across for f in own) else None
        if widths is None:
            return []
        return [*self.planes(frame, widths, section), *self.turned_tools(levels)]

    def corners(self, feature: Feature, frame: FloatArray) -> FloatArray:
        """The vertices (n, 3) of a feature, in the frame of the section."""
        own = {v for f in feature.faces for e in self.solid.faces[f].edges for v in self.ends(e)}
        corners: FloatArray = (self.solid.vertices[sorted(own)] - self.line.place) @ frame.T
        return corners

    def has_room(self, feature: Feature, levels: Sequence[float]) -> bool:
        """Whether no shoulder runs through a feature, and it is no boss: a strip would not part that from the body."""
        along = feature.points[:, 2]
        if any(along.min() + self.near < level < along.max() - self.near for level in levels):
            return False
        return float(np.hypot(*feature.points[:, :2].T).max()) < self.radius() + self.near

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
        if all(_fits(self.line.direction, d, plane) for d, plane in zip(directions, kinds, strict=True)):
            return np.empty(0)
        for way, _ in sorted(zip(directions, kinds, strict=True), key=lambda pair: pair[1]):
            if way is None or abs(float(way @ self.line.direction)) > ALONG:
                continue
            if all(_fits(way, d, plane) for d, plane in zip(directions, kinds, strict=True)):
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
        return _unlike(found, self.near)

    def levels(self) -> list[float]:
        """Where shoulders are: planes square to the axis with an inner corner."""
        found = [
            float((face.center - self.line.place) @ self.line.direction)
            for face in self.solid.faces
            if face.kind == "plane" and self.line.is_along(face.normal) and self.is_hollow(face)
        ]
        return _unlike(found, self.near)

    def is_hollow(self, face: Face) -> bool:
        """Whether a turned face meets another in an inner corner."""
        return any(
            self.solid.edges[e].dihedral > pi + self.flat
            and all(self.is_turned(self.solid.faces[f]) for f in self.solid.edges[e].faces)
            for e in face.edges
        )

    def radii(self) -> list[float]:
        """Radii of all cylinders about the axis."""
        holder = shapes_of(self.solid)
        return _unlike(
            [
                BRepAdaptor_Surface(holder.faces[face.id]).Cylinder().Radius()
                for face in self.solid.faces
                if face.kind == "cylinder" and self.is_turned(face)
            ],
            self.near,
        )

    def radius(self) -> float:
        """How far the turned faces reach from the axis."""
        at = np.linspace(0.0, 1.0, 9)
        edges = {e for face in self.solid.faces if self.is_turned(face) for e in face.edges}
        points = np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in sorted(edges)]) - self.line.place
        return float(np.linalg.norm(np.cross(points, self.line.direction), axis=1).max())

    def turned_tools(self, levels: Sequence[float]) -> Iterator[Any]:
        """The planes of all levels, and the cylinders of rings that end on one."""
        axis, reach = self.line.direction, 1.5 * self.solid.size
        for level in levels:
            place = self.line.place + level * axis
            yield BRepBuilderAPI_MakeFace(gp_Pln(_point(place), _direction(axis)), -reach, reach, -reach, reach).Face()
        holder = shapes_of(self.solid)
        taken: list[float] = []
        for face in self.solid.faces:
            if face.kind != "cylinder" or not self.is_turned(face) or not self.is_hollow(face):
                continue
            cylinder = BRepAdaptor_Surface(holder.faces[face.id]).Cylinder()
            if any(abs(cylinder.Radius() - radius) < self.near for radius in taken):
                continue
            taken.append(cylinder.Radius())
            location = np.array([cylinder.Location().X(), cylinder.Location().Y(), cylinder.Location().Z()])
            middle = float((self.solid.vertices.mean(axis=0) - location) @ _array(cylinder.Axis().Direction()))
            for u in (0.0, pi):
                yield BRepBuilderAPI_MakeFace(cylinder, u, u + pi, middle - reach, middle + reach).Face()

    def planes(self, frame: FloatArray, widths: Sequence[float], section: Section) -> Iterator[Any]:
        """The sides of strips through all of the body, and floors through their strip."""
        reach = 1.5 * self.solid.size
        along = float((self.solid.vertices.mean(axis=0) - self.line.place) @ frame[2])
        whole, length = (-reach, reach), (along - reach, along + reach)
        for way, width in enumerate(widths):
            if width > 0.0:
                for side in (-width, width):
                    yield self.rectangle(frame, 1 - way, side, whole, length)
                for floor in section.floors[way]:
                    yield self.rectangle(frame, way, floor, (-width, width), length)

    def rectangle(
        self, frame: FloatArray, across: int, offset: float, other: tuple[float, float], length: tuple[float, float]
    ) -> Any:  # fmt: skip
        """A plane face square to one of the frame's first two directions."""
        x = frame[1 - across]
        normal = np.cross(x, frame[2])
        place = self.line.place + offset * frame[across]
        plane = gp_Pln(gp_Ax3(_point(place), _direction(normal), _direction(x)))
        return BRepBuilderAPI_MakeFace(plane, *other, *length).Face()


def _fits(way: FloatArray, direction: FloatArray | None, is_plane: bool) -> bool:
    """Whether a face with a direction is a wall along a way, or a plane across it."""
    assert direction is not None
    cosine = abs(float(way @ direction))
    return cosine > 1.0 - ALONG or (is_plane and cosine < ALONG)


def _unlike(values: Sequence[float], near: float) -> list[float]:
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


def _point(place: FloatArray) -> gp_Pnt:
    return gp_Pnt(*map(float, place))


def _direction(direction: FloatArray) -> gp_Dir:
    return gp_Dir(*map(float, direction))


__all__ = ["along_features"]
