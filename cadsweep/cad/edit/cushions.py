"""A box of eleven cells under a circle, so that outside of it every face is a plain rectangle.

Place in the flow: candidates of :mod:`.cutters`. The circle at the floor of a hole, or under a boss, divides whatever
is swept through it, and with it every cell beyond, where other features ask for other divisions. In the box it ends::

      ____ boss ____
     |              |            a core of four corners under the middle of the disc, a shell of five cells from it to
    -+--+--------+--+-           a bowl that hangs on the circle, and five from the bowl to the sides of the box: each
     |   \\\\ core //  |            has the corners of a hexahedron, whichever way it is swept. Twelve edges of the box,
     |    \\\\____//   |            no more, are what the cells around it see; it may be as shallow as a quarter of the
     |____/______\\__|            circle's radius, where a cone has no room.

Each cutter carries two sides of the box on through the cell, one pair or the other: between these it has one and the
same section, and can be swept from one to the other.

Not handled: circles that are not whole, holes that go on below the circle, and where the box would not lie well inside.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
from OCP.BRepFill import BRepFill
from OCP.GC import GC_MakeArcOfCircle
from OCP.gp import gp_Pnt

from ...arrays import FloatArray
from ...brep import Solid
from .central import Cutter, plane_tool
from .circles import IsInside, Rim, find_rims, inside_of

WIDTHS = (1.5, 1.35, 1.2)
"""Distances of the box's sides from the axis, in radii of the circle, that are tried."""
NARROWEST, WIDEST = 1.15, 1.8
"""Between these, in radii, a side goes where the cell has a corner already."""
APART = 0.15
"""Distance of a side from the next corner of the cell, in radii, from which nothing thin is left between them."""
DEPTHS = (1.2, 0.8, 0.5, 0.33, 0.22)
"""Depths of the box, in radii of the circle, that are tried."""
CLEAR = 1.1
"""Width and depth, in those of the box, up to which there must be material."""
BOWL, CORE = 0.8, 0.6
"""Distance of the bowl's farthest lower corner from the axis, in radii; the core's size in that of the bowl's floor."""
CORE_DEPTH, BOWL_DEPTH = 0.25, 0.5
"""Depths of the core and of the bowl, in that of the box."""
SQUARE = 1e-6
"""Cosine of two directions that are square to each other."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Box:
    """Corners (4, 3) by level, in one order around the axis."""

    rim: FloatArray
    top: FloatArray
    bottom: FloatArray
    bowl: FloatArray
    core: FloatArray
    core_bottom: FloatArray
    middles: FloatArray

    def tools(self) -> list[Any]:
        """The faces between its eleven cells, and around them."""
        out = [_polygon(corners) for corners in (self.top, self.bottom, self.bowl, self.core_bottom)]
        for i in range(4):
            j = (i + 1) % 4
            spoke = (self.core[i], self.top[i], self.bottom[i], self.bowl[i], self.core_bottom[i])
            out.append(_polygon(spoke))
            for upper, lower in (
                (self.top, self.bottom),
                (self.bowl, self.bottom),
                (self.core, self.core_bottom),
                (self.core_bottom, self.bowl),
            ):
                out.append(_polygon((upper[i], upper[j], lower[j], lower[i])))
            arc = GC_MakeArcOfCircle(_point(self.rim[i]), _point(self.middles[i]), _point(self.rim[j])).Value()
            line = BRepBuilderAPI_MakeEdge(_point(self.bowl[i]), _point(self.bowl[j])).Edge()
            out.append(BRepFill.Face_s(BRepBuilderAPI_MakeEdge(arc).Edge(), line))
        return out


def under_rims(solid: Solid, flat: float) -> Iterator[Cutter]:
    """Boxes under the circles at which a solid is re-entrant, or that are imprinted on its faces.

    Parameters
    ----------
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    rims = find_rims(solid, flat)
    if not rims:
        return
    is_inside = inside_of(solid)
    for rim in rims:
        across = _directions(solid, rim)
        found = next(
            (
                (widths, depth * rim.radius)
                for widths in (_widths(solid, rim, across, most) for most in WIDTHS)
                for depth in DEPTHS
                if _fits(rim, across, widths, depth * rim.radius, is_inside)
            ),
            None,
        )
        if found is None:
            continue
        widths, depth = found
        tools = [*_box(rim, across, widths, depth).tools(), plane_tool(solid, rim.normal, rim.center)]
        for direction, ends in zip(across, widths, strict=True):
            planes = [plane_tool(solid, direction, rim.center + end * direction) for end in ends]
            yield Cutter(
                kind="cushion",
                reason=f"a box of cells under the circle on {rim.face.label()}",
                tools=(*tools, *planes),
                weight=rim.length,
                leads=True,
            )


def cushion(rim: Rim, across: FloatArray, widths: FloatArray, depth: float) -> list[Any]:
    """The faces between the eleven cells under a circle, and around them.

    Parameters
    ----------
    rim : Rim
    across : (2, 3) float64
        Unit directions across its axis, square to each other.
    widths : (2, 2) float64
        Where the sides of the box are along each, from the axis, the lower one first.
    depth : float
    """
    return _box(rim, across, widths, depth).tools()


def _widths(solid: Solid, rim: Rim, across: FloatArray, most: float) -> FloatArray:
    """Where the sides of the box are, (2, 2): along each direction the lower and the upper one, from the axis.

    A side goes where the cell has a corner, or stays clear of all, so that nothing thin is left between them.
    """
    out = np.empty((2, 2))
    for k, direction in enumerate(across):
        corners = (solid.vertices - rim.center) @ direction / rim.radius
        for end, sign in enumerate((-1.0, 1.0)):
            there = sign * corners
            clear = [w for w in WIDTHS if w <= most and np.abs(there - w).min() > APART]
            inside = there[(there > NARROWEST) & (there < min(WIDEST, 1.2 * most))]
            width = clear[0] if clear else float(inside.min()) if len(inside) else most
            out[k, end] = sign * width * rim.radius
    return out


def _directions(solid: Solid, rim: Rim) -> FloatArray:
    """Two directions (2, 3) across the axis, square to each other: of holes that go that way, else of plane faces."""
    lengths = dict[tuple[float, ...], float]()
    for face in solid.faces:
        if face.kind == "plane" and abs(float(face.normal @ rim.normal)) < SQUARE:
            # What is swept has its holes in the caps: a face with holes says where the cell is swept.
            key = tuple(np.abs(face.normal).round(6))
            lengths[key] = lengths.get(key, 0.0) + face.area * (10.0 if len(face.loops) > 1 else 1.0)
    best = max(lengths, key=lambda key: lengths[key], default=None)
    if best is None:
        first = np.linalg.svd(rim.normal[None])[2][1]
    else:
        first = next(f.normal for f in solid.faces if tuple(np.abs(f.normal).round(6)) == best)
    first = first - (first @ rim.normal) * rim.normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(rim.normal, first)])


def _box(rim: Rim, across: FloatArray, widths: FloatArray, depth: float) -> _Box:
    (left, right), (low, high) = widths
    corners = np.array([(right, high), (left, high), (left, low), (right, low)]) @ across
    reach = np.linalg.norm(corners, axis=1)
    out = corners / reach[:, None]
    middles = out + np.roll(out, -1, axis=0)
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    # Floors of box, bowl and core are of one shape, so that the faces between their sides are planes.
    bowl = BOWL * rim.radius / reach.max()

    def level(places: FloatArray, below: float) -> FloatArray:
        found: FloatArray = rim.center + places - below * rim.normal
        return found

    return _Box(
        rim=level(rim.radius * out, 0.0),
        top=level(corners, 0.0),
        bottom=level(corners, depth),
        bowl=level(bowl * corners, BOWL_DEPTH * depth),
        core=level(CORE * bowl * corners, 0.0),
        core_bottom=level(0.9 * CORE * bowl * corners, CORE_DEPTH * depth),
        middles=level(rim.radius * middles, 0.0),
    )


def _fits(rim: Rim, across: FloatArray, widths: FloatArray, depth: float, is_inside: IsInside) -> bool:
    """Whether there is material in the box, and a little around it."""
    first, second = (np.linspace(CLEAR * low, CLEAR * high, 5) for low, high in widths)
    for below in CLEAR * depth * np.array([0.02, 0.5, 1.0]):
        for a, b in product(first, second):
            if not is_inside(rim.center + a * across[0] + b * across[1] - below * rim.normal):
                return False
    return True


def _polygon(corners: Sequence[FloatArray] | FloatArray) -> Any:
    wire = BRepBuilderAPI_MakePolygon()
    for corner in corners:
        wire.Add(_point(corner))
    wire.Close()
    return BRepBuilderAPI_MakeFace(wire.Wire(), True).Face()


def _point(place: FloatArray) -> Any:
    return gp_Pnt(*map(float, place))


__all__ = ["cushion", "under_rims"]
