"""A bore that ends in a wider one, and the box around it.

Place in the flow: :mod:`.ports` finds the bores and makes cutters of the boxes.

Method: a box is as wide as there is room for between the port's wall and what is beside it; it takes in thin material,
goes on beyond its mouth to the open, and is cut only on sides where it does not end in a face of the part.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

from ...arrays import FloatArray
from ...brep import Solid
from ..shapes import FACE, subshapes
from .axes import Axis
from .central import rectangle_tool
from .inside import IsInside

SQUARE = 1e-6
"""Cosine of the angle of two axes up to which they are square to each other."""
WIDEST = 0.85
"""Distance of a box's side from the axis of the bore, in its radii, at most: beyond, the corners become sharp."""
LEAST, USUAL = 1.15, 1.6
"""Distance of a box's side from the axis of the port, in its radii, at least and where there is room."""
THIN = 0.6
"""Material beside a box, in radii of the port, up to which the box takes it in."""
NEAR = 1e-5
"""Distance, as a share of the cell's size, up to which two places are one."""
OUTSIDE = 0.01
"""How far a box reaches into the open, as a share of the cell's size: a tool that ends at a face would mark it."""
MOST_STEPS = 12
"""Quarters of the port's radius that a box goes on beyond its mouth, at most."""
SIDES = ((0, 1), (1, -1), (1, 1), (2, -1), (2, 1))
"""Sides of a box that may have to be cut, direction and sign: all but the one in the bore."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Port:
    """A bore on one side of the one it opens into.

    Attributes
    ----------
    origin : (3,) float64
        On the axis of the bore, next to that of the port.
    frame : (3, 3) float64
        Rows: out along the port, across, along the bore.
    off : float
        Of the port's axis, along the second.
    radius : float
        Of the widest piece of the port.
    bore : Axis
    start, end : float
        The port's reach along the first: its end in the wall of the bore, and its mouth.
    faces, bosses : frozenset of int
        Of the port, and of what is round about it from outside, on its side.
    wider : tuple of Axis
        Its pieces that end at a shoulder before the wall of the bore.
    """

    solid: Solid
    origin: FloatArray
    frame: FloatArray
    off: float
    radius: float
    bore: Axis
    start: float
    end: float
    faces: frozenset[int]
    bosses: frozenset[int]
    wider: tuple[Axis, ...] = ()

    @property
    def near(self) -> float:
        return NEAR * self.solid.size

    def box(self, is_inside: IsInside) -> PortBox | None:
        """The box around it; None where there is no room."""
        spans = list(self.others())
        around = [span for span in spans if self.is_around(span)]
        if around:
            # What stands around the mouth stands on the box, which ends below.
            radius = max(float(np.abs(span[:, 1:] - [self.off, 0.0]).max()) for span in around)
            return replace(self, radius=radius, end=min(span[0, 0] for span in around)).box(is_inside)
        usual = min(USUAL * self.radius, WIDEST * self.bore.radius - abs(self.off))
        if usual < LEAST * self.radius:
            return None
        low = np.array([self.start, self.off - usual, -np.inf])
        high = np.array([self.end, self.off + usual, np.inf])
        for axis in (2, 1):
            for sign, side in ((-1, low), (1, high)):
                gap, is_flat = self.gap(spans, low, high, axis, sign)
                room = gap if is_flat else 0.5 * gap
                if axis == 1:
                    own = usual - self.radius
                    room = room if room < own + (THIN * self.radius if is_flat else 0.0) else own
                if not 1e-2 * self.radius < room < np.inf:
                    return None
                side[axis] = (self.off if axis == 1 else 0.0) + sign * (self.radius + room)
        if max(-low[1], high[1]) > WIDEST * self.bore.radius + THIN * self.radius:
            return None
        if not self.has_wall(low[1], high[1], is_inside):
            return None
        box = PortBox(port=self, low=low, high=high)
        closed = frozenset(side for side in SIDES if box.is_closed(*side, is_inside))
        return replace(box, closed=closed, mouth=0.0 if (0, 1) in closed else box.to_the_open(is_inside))

    def has_wall(self, left: float, right: float, is_inside: IsInside) -> bool:
        """Whether the bore's wall is there at both sides of a box: that of a pocket's end may end before."""
        for side in (left, right):
            arm = np.array([np.sqrt(self.bore.radius**2 - side**2), side, 0.0])
            step = 1e-2 * self.radius * arm / self.bore.radius
            beyond, before = (self.origin + place @ self.frame for place in (arm + step, arm - step))
            if not is_inside(beyond) or is_inside(before):
                return False
        return True

    def others(self) -> Iterator[FloatArray]:
        """Reach (2, 3) along the frame of every face but those of the port, beside its mouth, and of the bore's wall.

        A round boss about the port is one, however many faces it has.
        """
        at = np.linspace(0.0, 1.0, 17)
        done = {f for own in self.faces for e in self.solid.faces[own].edges for f in self.solid.edges[e].faces}
        done |= self.bore.faces
        groups = [self.bosses - done, *({face.id} for face in self.solid.faces if face.id not in self.bosses | done)]
        for group in groups:
            edges = sorted({e for f in group for e in self.solid.faces[f].edges})
            if edges:
                points = np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in edges]) - self.origin
                along = points @ self.frame.T
                yield np.array([along.min(axis=0), along.max(axis=0)])

    def is_around(self, span: FloatArray) -> bool:
        """Whether a face goes around the port, beside its mouth: a boss, not what this stands on."""
        low, high = span
        is_beside = self.start + self.radius < low[0] < min(self.end, high[0]) - self.near
        away = np.abs(span[:, 1:] - [self.off, 0.0])
        is_wide = bool((low[1:] < [self.off, 0.0]).all() and (high[1:] > [self.off, 0.0]).all())
        return is_beside and is_wide and bool((away > self.radius - self.near).all())

    def along(self, faces: Collection[int]) -> FloatArray:
        """Where points of some faces' edges (n,) lie along it, from the origin."""
        at = np.linspace(0.0, 1.0, 17)
        edges = sorted({e for f in faces for e in self.solid.faces[f].edges})
        points = np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in edges])
        places: FloatArray = (points - self.origin) @ self.frame[0]
        return places

    def reach(self, direction: FloatArray) -> tuple[float, float]:
        """How far its faces reach along a direction; nothing where it goes along that itself."""
        if abs(float(self.frame[0] @ direction)) > 1.0 - SQUARE:
            return 0.0, 0.0
        at = np.linspace(0.0, 1.0, 17)
        edges = {e for f in self.faces for e in self.solid.faces[f].edges}
        along = np.concatenate([self.solid.edges[e].curve.evaluate(at) for e in sorted(edges)]) @ direction
        return float(along.min()), float(along.max())

    def gap(
        self, spans: Sequence[FloatArray], low: FloatArray, high: FloatArray, axis: int, sign: int
    ) -> tuple[float, bool]:  # fmt: skip
        """How far it is from the port to the next face in a direction, and whether that lies across it; -inf for none.

        A face that lies beside a box as far as known, in the other two directions, is not in the way.
        """
        start = (self.off if axis == 1 else 0.0) + sign * self.radius
        others = [a for a in range(3) if a != axis]
        best, best_flat = np.inf, False
        for span in spans:
            if not ((span[0] < high - self.near) & (span[1] > low + self.near))[others].all():
                continue
            first, last = sorted(sign * (span[:, axis] - start))
            if last < -self.near - self.radius:
                continue
            if first < -self.near:
                return -np.inf, False
            is_flat = last - first < self.near
            if first < best - self.near or (first < best + self.near and is_flat):
                best, best_flat = float(first), is_flat
        return best, best_flat


@dataclass(frozen=True, kw_only=True, eq=False)
class PortBox:
    """What a port is swept through.

    Attributes
    ----------
    low, high : (3,) float64
        Its sides along the port's frame, from its origin.
    closed : frozenset of (int, int)
        Sides, direction and sign, with material beyond.
    mouth : float
        How far the sides go on at the mouth until they are in the open: it may lie in the wall of another bore.
    """

    port: Port
    low: FloatArray
    high: FloatArray
    closed: frozenset[tuple[int, int]] = frozenset()
    mouth: float = 0.0

    def place(self, along: FloatArray) -> FloatArray:
        point: FloatArray = self.port.origin + along @ self.port.frame
        return point

    def is_beside(self, other: PortBox, sign: int) -> bool:
        """Whether another box of the same bore goes on at an end of this one."""
        low, high = other.low, other.high
        if float(self.port.frame[0] @ other.port.frame[0]) < 1.0 - SQUARE or other.port.bore is not self.port.bore:
            return False
        shift = float((other.port.origin - self.port.origin) @ self.port.frame[2])
        return abs((self.high[2] - low[2] if sign > 0 else high[2] - self.low[2]) - sign * shift) < self.port.near

    def is_closed(self, axis: int, sign: int, is_inside: IsInside) -> bool:
        """Whether there is material beyond a side."""
        beyond = (self.high if sign > 0 else self.low)[axis] + sign * 1e-3 * self.port.radius
        i, j = (a for a in range(3) if a != axis)
        along = np.empty(3)
        along[axis] = beyond
        for a in (0.02, 0.25, 0.5, 0.75, 0.98):
            for b in (0.02, 0.25, 0.5, 0.75, 0.98):
                along[i] = self.low[i] + a * (self.high[i] - self.low[i])
                along[j] = self.low[j] + b * (self.high[j] - self.low[j])
                if is_inside(self.place(along)):
                    return True
        return False

    def to_the_open(self, is_inside: IsInside) -> float:
        """How far it is at the mouth from the port's own end until all sides have left the material."""
        step = 0.25 * self.port.radius
        corners = [(q, z) for q in (self.low[1], self.high[1]) for z in np.linspace(self.low[2], self.high[2], 5)[1:-1]]
        for k in range(MOST_STEPS):
            points = (np.array([self.high[0] + (k + 0.01) * step, q, z]) for q, z in corners)
            if not any(is_inside(self.place(point)) for point in points):
                return k * step
        return MOST_STEPS * step

    def ends(self) -> Iterator[tuple[tuple[int, int], FloatArray]]:
        """Its sides across the bore that have material beyond, and a point of each."""
        for axis, sign in sorted(self.closed):
            if axis == 2:
                yield (axis, sign), self.place(np.array([0.0, 0.0, (self.high if sign > 0 else self.low)[2]]))

    def tools(self, done: Collection[tuple[PortBox, tuple[int, int]]]) -> Iterator[Any]:
        """The sides that have material beyond but those that are done, up to the bore's wall and into the open."""
        bore = self.port.bore
        out = OUTSIDE * self.port.solid.size
        low, high = self.low.copy(), self.high.copy()
        low[0] = 0.5 * np.sqrt(bore.radius**2 - max(-low[1], high[1], 0.0) ** 2)
        for axis, sign in SIDES:
            if (axis, sign) not in self.closed:
                (low if sign < 0 else high)[axis] += sign * (out if axis else out + self.mouth)
        hollow = self._hollow()
        for axis, sign in sorted(self.closed - {side for box, side in done if box is self}):
            i, j = (a for a in range(3) if a != axis)
            level = (high if sign > 0 else low)[axis]
            along = np.zeros(3)
            along[axis] = level
            frame = self.port.frame
            normal = np.cross(frame[i], frame[j])
            whole = rectangle_tool(self.place(along), normal, frame[i], (low[i], high[i]), (low[j], high[j]))
            yield from subshapes(BRepAlgoAPI_Cut(whole, hollow).Shape(), FACE) if axis else [whole]
        for own in self.port.wider:
            yield from self._carried(own, float(low[0]))

    def _carried(self, own: Axis, start: float) -> Iterator[Any]:
        """A wider piece of the port carried on from its shoulder to the wall of the bore."""
        shoulder = self.port.along(own.faces & self.port.faces).min()
        places = (self.port.origin + t * self.port.frame[0] - own.place for t in (start, shoulder))
        ends = sorted(float(place @ own.direction) for place in places)
        for turn in (0.0, pi):
            yield BRepBuilderAPI_MakeFace(own.cylinder, turn, turn + pi, *ends).Face()

    def _hollow(self) -> Any:
        """The bore without what it is in, longer than the part: a tool that lies on the bore's floor would mark it."""
        bore, reach = self.port.bore, 2.0 * self.port.solid.size
        start = self.port.origin - reach * bore.direction
        axis, across = (gp_Dir(*map(float, way)) for way in (bore.direction, self.port.frame[0]))
        frame = gp_Ax2(gp_Pnt(*map(float, start)), axis, across)
        return BRepPrimAPI_MakeCylinder(frame, bore.radius, 2.0 * reach).Shape()
