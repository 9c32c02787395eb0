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

Where ends of the body are chamfered, what is beside the strips is parted along the lines of the chamfers as well.

What goes across in two directions square to each other gets two strips. They cross in bricks, each of which is a slice
of either.

Where a strip is no narrower than the bore, as a hole across is wider, the bore lies inside of it: three planes through
all of the body part every crossing, as they do in a block, and a wider end of the bore closes in a cone to its wall
instead of a ring that would run on through them.

Not handled: features that are slanted to the axis or to each other, or as wide as the body; shoulders that run through
a feature; bosses across the axis; a keyway over a hole across; holes of the bore's own radius.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.gp import gp_Ax3, gp_Cylinder, gp_Dir, gp_Pnt

from ...arrays import FloatArray
from ...brep import Solid
from .axes import find_axes
from .central import Cutter, plane_tool
from .countersinks import LEAST_SLOPE, SHARE, bored_rims, countersink
from .strip_widths import Section, surrounds
from .turned import ALONG, Feature, TurnedBody, unlike


def along_features(solid: Solid, flat: float) -> list[Cutter]:
    """Strips along what goes across the axis of a turned body, its rings and levels; none where nothing does.

    Parameters
    ----------
    solid : Solid
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    body = _Stripped.read(solid, flat)
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


class _Stripped(TurnedBody):
    """A turned body, and its strips.

    Attributes
    ----------
    coned : sequence of float
        Radii of what is wider than the bore that goes on from it: cones end there, no rings.
    """

    coned: Sequence[float] = ()

    def tools(self) -> list[Any]:
        """All faces that part the body; none where there is nothing across, or no room."""
        features = self.features()
        ways = [self.way(feature) for feature in features]
        if any(way is None for way in ways):
            return []
        own = [way for way in ways if way is not None and len(way)]
        radii = self.radii()
        if not own or not radii:  # a strip is measured against the cylinders that its sides leave through
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
            radii=radii,
            bores=self.bores(radii),
            corners=[corner for feature in beside if surrounds(feature) for corner in self.corners(feature, frame)],
        )
        levels = self.levels()
        widths = section.widths() if all(self.has_room(f, levels) for own in across for f in own) else None
        if widths is None:
            return []
        held = section.held(widths)
        inside = self.inside(frame, section, held, levels) if held else []
        if inside is None:
            return []
        innermost = min((radius for radius, _ in self.rings()), default=np.inf)
        is_beyond = any(abs(floor) > innermost for own in section.floors for floor in own)
        seams = partial(_corners, frame, widths) if held or is_beyond else None
        chamfers = self.chamfers(frame, widths)
        return [*self.planes(frame, widths, section), *self.turned_tools(levels, seams), *chamfers, *inside]

    def bores(self, radii: Sequence[float]) -> list[float]:
        """Those of the radii about the body's axis that bores have, and nothing on its outside."""
        own = [
            axis
            for axis in find_axes(self.solid)
            if self.line.is_along(axis.direction) and self.line.off(axis.place) < self.near
        ]
        inner, outer = ([axis.radius for axis in own if axis.is_bore is side] for side in (True, False))
        return [radius for radius in radii if self.is_one_of(radius, inner) and not self.is_one_of(radius, outer)]

    def is_one_of(self, radius: float, others: Sequence[float]) -> bool:
        """Whether a radius is one of others."""
        return any(abs(radius - other) <= self.near for other in others)

    def rings(self) -> list[tuple[float, Any]]:
        """Those of the body, without the ones that end in cones."""
        return [ring for ring in super().rings() if not self.is_one_of(ring[0], self.coned)]

    def inside(
        self, frame: FloatArray, section: Section, held: Sequence[float], levels: Sequence[float]
    ) -> list[Any] | None:
        """Planes through everything where something crosses bores in strips, and their cones; None without room."""
        heights = section.heights(max(held), self.near)
        if heights is None:
            return None
        tools = [plane_tool(self.solid, normal, self.line.place) for normal in frame[:2]]
        tools += [plane_tool(self.solid, frame[2], self.line.place + at * frame[2]) for at in heights]
        stops = [*levels, *heights, *(end for own in section.across for f in own for end in f.points[:, 2])]
        for rim, bore, _, depth in bored_rims(self.solid, self.flat):
            if self.line.off(rim.center) > self.near or not self.is_one_of(rim.radius, held):
                continue
            level, down = float((rim.center - self.line.place) @ frame[2]), -float(rim.normal @ frame[2])
            room = SHARE * min((ahead for at in stops if (ahead := down * (at - level)) > self.near), default=np.inf)
            if room < LEAST_SLOPE * (rim.radius - bore.radius):
                return None
            self.coned = (*self.coned, rim.radius)
            tools.append(countersink(self.solid, rim, bore, frame[0], min(depth, room))[0])
        return tools

    def chamfers(self, frame: FloatArray, widths: Sequence[float]) -> list[Any]:
        """Cylinders beside the strips through the lines at which chamfers meet ends of the body, if there are several.

        What is swept along the axis has such a line on both of its caps then, and neither is the other's.
        """
        lines = [
            edge.midpoint - self.line.place
            for edge in self.solid.edges
            if {self.solid.faces[f].kind for f in edge.faces} == {"cone", "plane"}
            and all(self.is_turned(self.solid.faces[f]) for f in edge.faces)
            and edge.dihedral < pi - self.flat
        ]
        if len(unlike([float(line @ frame[2]) for line in lines], self.near)) < 2:
            return []
        low, high = (reach * self.solid.size for reach in (-1.5, 1.5))
        middle = float((self.solid.vertices.mean(axis=0) - self.line.place) @ frame[2])
        place = gp_Pnt(*map(float, self.line.place + middle * frame[2]))
        axes = gp_Ax3(place, gp_Dir(*map(float, frame[2])), gp_Dir(*map(float, frame[0])))
        found = []
        for radius in unlike([float(np.linalg.norm(frame[:2] @ line)) for line in lines], self.near):
            if radius <= np.linalg.norm(widths):
                continue
            start, end = np.arcsin(widths[0] / radius), np.arccos(widths[1] / radius)
            arcs = [(start, end), (pi - end, pi - start)] if widths[1] else [(start, pi - start)]
            found += [
                BRepBuilderAPI_MakeFace(gp_Cylinder(axes, radius), turn + a, turn + b, low, high).Face()
                for turn in (0.0, pi)
                for a, b in arcs
            ]
        return found

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

    def planes(self, frame: FloatArray, widths: Sequence[float], section: Section) -> Iterator[Any]:
        """The sides of strips through all of the body, and floors through their strip."""
        for way, width in enumerate(widths):
            if width > 0.0:
                for side in (-width, width):
                    yield self.strip(frame, 1 - way, side)
                for floor in section.floors[way]:
                    yield self.strip(frame, way, floor, np.inf if section.goes_through(way, floor, widths) else width)

    def strip(self, frame: FloatArray, across: int, offset: float, width: float = np.inf) -> Any:
        """A plane face along the axis, through all of the body or as far as a strip is wide."""
        reach = 1.5 * self.solid.size
        along = float((self.solid.vertices.mean(axis=0) - self.line.place) @ frame[2])
        half = min(width, reach)
        return self.rectangle(frame, across, offset, (-half, half), (along - reach, along + reach))


def _corners(frame: FloatArray, widths: Sequence[float], radius: float) -> list[FloatArray]:
    """Unit vectors to where the sides of a strip leave a ring, or the planes in it one that it holds.

    A seam elsewhere would end on a floor beyond it.
    """
    way = 0 if widths[0] else 1
    aside = widths[way] / radius
    if aside > 1.0:
        return [frame[0], -frame[0]]
    out = float(np.sqrt(1.0 - aside**2))
    return [np.asarray(a * frame[way] + b * frame[1 - way]) for a in (-out, out) for b in (-aside, aside)]


__all__ = ["along_features"]
