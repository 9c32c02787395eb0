"""Planes along what stands on a turned body or goes into it, at any angle about its axis: ribs, holes, slots.

Place in the flow: a candidate of :mod:`.cutters` for a turned body that :mod:`.strips` cannot part: with ribs, or with
features at angles that are not square to each other.

Method: as strips do, but from the bore outwards only, so that those of any number of angles keep clear of each other::

        ___|w|___            The sides of a rib are the sides of its spoke: what stands on the body is swept across,
       /   | |   \\           from one side to the other, whatever its outline.
      /   _| |_   \\         The sides of holes and slots stand beside them, where angles and gaps are best.
     |   /     \\___|        All shoulders' planes and all rings' cylinders go through everything; those that a rib
     |   \\_____/---|        stands on, too.
      \\           /         Between spokes the body's section is swept about the axis or along it.
       \\_________/

Where there is no bore, or a narrow one, a cylinder about the axis is parted from the body first, and stands for it.

Not handled: more spokes than there is room for; ribs on cones; what is slanted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.gp import gp_Ax3, gp_Cylinder, gp_Dir, gp_Pnt

from ...arrays import FloatArray
from ...brep import Solid
from ..shapes import shapes_of
from .central import Cutter
from .strip_widths import BEST_CORNER, BEST_GAP, BEST_SINE, LEAST, N_WIDTHS
from .turned import ALONG, Feature, TurnedBody, fits

INSIDE = 0.9
"""Share of the bore's radius within which the sides of neighbouring spokes may meet."""
CORE = 0.6
"""Radius of a core, as a share of how far everything else stays away from the axis."""


@dataclass(kw_only=True, eq=False)
class _Spoke:
    """What goes outwards at one angle.

    Attributes
    ----------
    frame : (3, 3) float64
        Outwards, aside, along the axis.
    features : list of Feature
        Points in the frame.
    is_boss : bool
        A rib: its own sides are the spoke's.
    low, high : float
        Offsets of the sides.
    end : float
        Radius of the ring that the sides end on; infinite where they go through all of the body.
    """

    frame: FloatArray
    features: list[Feature]
    is_boss: bool
    low: float = 0.0
    high: float = 0.0
    end: float = np.inf

    @property
    def reach(self) -> tuple[float, float]:
        """How far the features reach to both sides."""
        aside = np.concatenate([feature.points[:, 1] for feature in self.features])
        return float(aside.min()), float(aside.max())


def along_spokes(solid: Solid, flat: float) -> list[Cutter]:
    """Spokes of a turned body, its rings and levels; none where nothing goes outwards, or there is no room.

    Parameters
    ----------
    solid : Solid
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    body = _Spoked.read(solid, flat)
    tools = [] if body is None else body.tools()
    if not tools:
        return []
    reason = "spokes along what goes outwards on a turned body, its rings and levels"
    return [Cutter(kind="boxes", reason=reason, tools=tuple(tools), weight=solid.size, leads=True)]


class _Spoked(TurnedBody):
    """A turned body with a bore or a core, and its spokes.

    Attributes
    ----------
    core : float
        Radius of the cylinder that spokes end on; 0 where they end in the bore.
    """

    core = 0.0

    def tools(self) -> list[Any]:
        """All faces that part the body; none where nothing goes outwards, or there is no room."""
        spokes: list[_Spoke] = []
        beside: list[Feature] = []
        for feature in self.features():
            spoke = self.spoke(feature)
            if spoke is not None:
                _add(spokes, spoke)
            elif self.goes_along(feature):
                beside.append(feature)
            else:
                return []
        if not spokes or not self.is_on_rings(spokes):
            return []
        levels = self.levels()
        places = [Feature(faces=f.faces, points=f.points - self.line.place) for f in beside]
        if not all(self.has_room(spoke, levels) for spoke in spokes):
            return []
        bore = self.bore()
        if bore < self.near or not self.find_sides(spokes, places, bore):
            self.core = self.find_core(spokes, bore)
            if not self.core or not self.find_sides(spokes, places, self.core):
                return []
        sides = (tool for spoke in spokes for tool in self.sides(spoke))
        return [*sides, *self.turned_tools(levels, partial(self.seams, spokes))]

    def bore(self) -> float:
        """Distance of the material from the axis."""
        reach = 2.0 * self.solid.size
        middle = self.solid.vertices.mean(axis=0) - self.line.place
        center = self.line.place + (middle @ self.line.direction) * self.line.direction
        low, high = (gp_Pnt(*map(float, center + side * reach * self.line.direction)) for side in (-1.0, 1.0))
        between = BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeEdge(low, high).Edge(), shapes_of(self.solid).shape)
        return float(between.Value()) if between.IsDone() else 0.0

    def find_core(self, spokes: Sequence[_Spoke], bore: float) -> float:
        """Radius of a cylinder inside of everything but the bore, with room for all spokes; 0 where there is none."""
        inner = [float(np.hypot(*own.points[:, :2].T).min()) for spoke in spokes for own in spoke.features]
        most = min(inner + [radius for radius in self.radii() if radius > bore + self.near])
        return CORE * most if bore < 0.5 * CORE * most else 0.0

    def rings(self) -> list[tuple[float, Any]]:
        """Those of the body, and the core's."""
        core = gp_Cylinder(
            gp_Ax3(gp_Pnt(*map(float, self.line.place)), gp_Dir(*map(float, self.line.direction))), self.core or 1.0
        )
        return super().rings() + [(self.core, core)] * (self.core > 0.0)

    def goes_along(self, feature: Feature) -> bool:
        """Whether a feature goes along the axis."""
        way = self.way(feature)
        return way is not None and not len(way)

    def spoke(self, feature: Feature) -> _Spoke | None:
        """A feature as a spoke of its own; None where it does not go outwards on one side of the axis."""
        axis = self.line.direction
        faces = [self.solid.faces[f] for f in feature.faces]
        directions = [self.direction(face) for face in faces]
        if any(direction is None for direction in directions):
            return None
        known = [(d, face.kind == "plane") for d, face in zip(directions, faces, strict=True) if d is not None]
        for direction, _ in sorted(known, key=lambda pair: pair[1]):
            if abs(float(direction @ axis)) > ALONG:
                continue
            for way in (direction, np.cross(axis, direction)):
                outward = way * (1.0 if float((feature.points.mean(axis=0) - self.line.place) @ way) > 0.0 else -1.0)
                frame = np.array([outward, np.cross(axis, outward), axis])
                points = (feature.points - self.line.place) @ frame.T
                if points[:, 0].min() < self.near or points[:, 1].min() > 0.0 or points[:, 1].max() < 0.0:
                    continue
                is_boss = self.is_boss(feature, frame)
                if all(fits(frame[1 if is_boss else 0], d, plane) for d, plane in known):
                    own = Feature(faces=feature.faces, points=points)
                    return _Spoke(frame=frame, features=[own], is_boss=is_boss)
        return None

    def is_boss(self, feature: Feature, frame: FloatArray) -> bool:
        """Whether a feature has its material between two sides that look away from each other."""
        sides = [
            float((face.center - self.line.place) @ frame[1]) * float(face.normal @ frame[1])
            for face in (self.solid.faces[f] for f in feature.faces)
            if face.kind == "plane" and abs(float(face.normal @ frame[1])) > 1.0 - ALONG
        ]
        return len(sides) > 1 and min(sides) > 0.0

    def is_on_rings(self, spokes: Sequence[_Spoke]) -> bool:
        """Whether all ribs stand on cylinders and planes; from here on these are parted under them."""
        self.bosses = frozenset(f for spoke in spokes if spoke.is_boss for own in spoke.features for f in own.faces)
        under = [face for face in self.solid.faces if self.is_turned(face) and self.is_hollow(face)]
        edges = {e for f in self.bosses for e in self.solid.faces[f].edges}
        return all(face.kind in ("plane", "cylinder") for face in under if edges & set(face.edges))

    def has_room(self, spoke: _Spoke, levels: Sequence[float]) -> bool:
        """Whether no shoulder runs through what is cut into the body there; a rib may be parted by one."""
        if spoke.is_boss:
            return True
        return not any(
            own.points[:, 2].min() + self.near < level < own.points[:, 2].max() - self.near
            for own in spoke.features
            for level in levels
        )

    def find_sides(self, spokes: Sequence[_Spoke], beside: Sequence[Feature], bore: float) -> bool:
        """Set the offsets of all sides; False where a spoke has no room.

        Sides of neighbours meet inside of the bore: of all, at the angle that the nearest two have between them.
        """
        angles = sorted(self.angle(spoke, spokes[0]) for spoke in spokes)
        gaps = [second - first for first, second in pairwise([*angles, angles[0] + 2.0 * pi])]
        most = INSIDE * bore * np.sin(min(min(gaps) / 2.0, pi / 2.0))
        radii = np.array([bore, *(radius for radius in self.radii() if radius > bore)])
        rings = [radius for radius, _ in self.rings()]
        for spoke in spokes:
            low, high = spoke.reach
            half = max(-low, high)
            out = max(float(np.hypot(*own.points[:, :2].T).max()) for own in spoke.features)
            spoke.end = min((radius for radius in rings if radius > out - self.near), default=np.inf)
            near = [own.points @ spoke.frame.T for own in beside]
            ahead = [p[:, 1] for p in near if p[:, 0].max() > 0.0 and np.hypot(*p[:, :2].T).min() < spoke.end]
            tried = (
                [(low, high)] if spoke.is_boss else [(-w, w) for w in np.linspace(1.05 * half, most, N_WIDTHS).tolist()]
            )
            scores = [_score(sides, half, radii, ahead, is_boss=spoke.is_boss) for sides in tried]
            best = int(np.argmax(scores))
            if max(-tried[best][0], tried[best][1]) > most or scores[best] < LEAST:
                return False
            spoke.low, spoke.high = tried[best]
        return True

    @staticmethod
    def angle(spoke: _Spoke, first: _Spoke) -> float:
        """Angle of a spoke from the first one."""
        x, y = first.frame[:2] @ spoke.frame[0]
        return float(np.arctan2(y, x) % (2.0 * pi - ALONG))

    def seams(self, spokes: Sequence[_Spoke], radius: float) -> list[FloatArray]:
        """Where a ring's cylinder is parted: where the body is, between spokes, and at both sides of a spoke.

        A line that other rings do not have would be a corner of the grids on this one alone.
        """
        found = []
        for way in self.parting_lines():
            for spoke in spokes:
                out, aside = radius * (spoke.frame[:2] @ way)
                if out > 0.0 and spoke.low - self.near < aside < spoke.high + self.near:
                    break
            else:
                found.append(way)
        widest = max(spokes, key=lambda spoke: spoke.end)
        for aside in (widest.low, widest.high):
            out = float(np.sqrt(radius**2 - aside**2))
            found.append(np.asarray(np.array([out, aside]) @ widest.frame[:2] / radius))
        return found

    def sides(self, spoke: _Spoke) -> Iterator[Any]:
        """Both sides of a spoke, and the floors in it."""
        reach = 1.5 * self.solid.size
        along = float((self.solid.vertices.mean(axis=0) - self.line.place) @ self.line.direction)
        length = (along - reach, along + reach)
        for offset in (spoke.low, spoke.high):
            start = float(np.sqrt(max(self.core**2 - offset**2, 0.0)))
            end = reach if np.isinf(spoke.end) else float(np.sqrt(spoke.end**2 - offset**2))
            yield self.rectangle(spoke.frame, 1, offset, (start, end), length)
        if not spoke.is_boss:
            for floor in self.floors(spoke.features, spoke.frame[0]):
                yield self.rectangle(spoke.frame, 0, floor, (spoke.low, spoke.high), length)


def _add(spokes: list[_Spoke], spoke: _Spoke) -> None:
    """Put a spoke to the others; features at one angle, neither of them a rib, are one."""
    for known in spokes:
        if float(known.frame[0] @ spoke.frame[0]) > 1.0 - ALONG and not known.is_boss and not spoke.is_boss:
            known.features += spoke.features
            return
    spokes.append(spoke)


def _score(
    sides: tuple[float, float], half: float, radii: FloatArray, beside: Sequence[FloatArray], *, is_boss: bool
) -> float:
    """How good two sides are, 1 at best: the worst of their angles and gaps, as shares of what is good enough."""
    found = [1.0]
    if not is_boss:
        found.append((sides[1] - half) / (BEST_GAP * half))
    for side in sides:
        if (radii <= abs(side)).any():
            return 0.0
        found += (np.sqrt(1.0 - (side / radii) ** 2) / BEST_SINE).tolist()
        found += [max(own.min() - side, side - own.max()) / (BEST_CORNER * half) for own in beside]
    return float(min(found))


__all__ = ["along_spokes"]
