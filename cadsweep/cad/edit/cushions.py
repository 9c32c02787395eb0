"""A box of eleven cells under a circle or another outline, so that outside of it every face is a plain rectangle.

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

Any outline that runs around its middle without a notch has such cells, too: a corner of it goes to each corner of the
box, and what is between two of them is one side of the bowl, of as many faces as it has edges.

A floor that is rounded, or a boss, ends half way up its rounding (:mod:`.half_way`): what is below it has one half of
that among its sides, and the bowl hangs down upright, between the rounding and what is around it.

Not handled: circles that are not whole, outlines with notches, holes that go on below, and where the box would not lie
well inside.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import pi
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
from OCP.BRepFill import BRepFill
from OCP.GC import GC_MakeArcOfCircle
from OCP.gp import gp_Pnt

from ...arrays import FloatArray
from ...brep import Solid
from .central import Cutter, plane_tool
from .circles import Rim, find_rims
from .half_way import half_way
from .inside import IsInside, inside_of

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
BOWL_OF_SUNK, UPRIGHT = 1.4, 0.35
"""The bowl's nearest corner, where its circle lies half way up the rounding of a floor: it hangs on it upright, or
would not clear it; and how far that is from another outline to the corner of the box."""
CORE_DEPTH, BOWL_DEPTH = 0.33, 0.5
"""Depths of the core and of the bowl, in that of the box."""
SQUARE = 1e-6
"""Cosine of two directions that are square to each other."""


SNAP = 0.44
"""Radians between the directions of a corner of the box and of a corner of an outline, up to which they are joined."""
PLANE = 1e-9
"""Distance of a corner from the plane of three others, as a share of their distances, up to which a face is plane."""
CORNER, WIDE = 0.2, 2.0
"""Radians by which an outline turns at a corner, at least, and along an arc that is divided twice."""
Chain = list[tuple[Any, float]]
"""Pieces of an outline from one corner to the next, each with the share of the way at which it ends."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Box:
    """Corners (4, 3) by level, in one order around the axis, and the four pieces of the outline between them.

    `disc` is the outline's own level: that of the top, or above it, where the plane around a boss is the part's own.
    """

    rim: FloatArray
    top: FloatArray
    bottom: FloatArray
    bowl: FloatArray
    core: FloatArray
    core_bottom: FloatArray
    disc: FloatArray
    chains: Sequence[Chain]

    def tools(self) -> list[Any]:
        """The faces between its eleven cells, and around them."""
        out = [_polygon(corners) for corners in (self.disc, self.bottom, self.bowl, self.core_bottom)]
        for i in range(4):
            j = (i + 1) % 4
            out.append(_quad(self.core[i], self.rim[i], self.bowl[i], self.core_bottom[i]))
            out.append(_quad(self.rim[i], self.top[i], self.bottom[i], self.bowl[i]))
            for upper, lower in (
                (self.top, self.bottom),
                (self.bowl, self.bottom),
                (self.core, self.core_bottom),
                (self.core_bottom, self.bowl),
            ):
                out.append(_quad(upper[i], upper[j], lower[j], lower[i]))
            begin = self.bowl[i]
            for piece, share in self.chains[i]:
                end = self.bowl[i] + share * (self.bowl[j] - self.bowl[i])
                out.append(BRepFill.Face_s(piece, BRepBuilderAPI_MakeEdge(_point(begin), _point(end)).Edge()))
                begin = end
        return out


def under_rims(solid: Solid, flat: float) -> Iterator[Cutter]:
    """Boxes under the circles at which a solid is re-entrant, or that are imprinted on its faces.

    Parameters
    ----------
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    rims = [half_way(solid, rim, flat) for rim in find_rims(solid, flat)]
    if not rims:
        return
    is_inside = inside_of(solid)
    for rim in rims:
        if rim is None:
            continue
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
        tools = [*_box(rim, across, widths, rim.sunk + depth).tools(), plane_tool(solid, rim.normal, rim.center)]
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
        Below what is around the circle.
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
    if rim.edges:
        on_rim, chains = _along(rim, across)
        bowl = BOWL * (on_rim - rim.center)
    else:
        out = corners / reach[:, None]
        on_rim, chains = rim.center + rim.radius * out, _arcs(rim, out)
        # Floors of box, bowl and core are of one shape, so that the faces between their sides are planes.
        bowl = BOWL * rim.radius / reach.max() * corners
    core, core_bottom = CORE * bowl, 0.9 * CORE * bowl
    if rim.sunk and rim.edges:
        bowl = on_rim - rim.center + UPRIGHT * (corners - (on_rim - rim.center))
    elif rim.inner != rim.outer:
        bowl = (BOWL_OF_SUNK * reach.max() / reach.min() if rim.sunk else 1.0) / BOWL * bowl
    bottom = rim.outer - depth
    lower = min(rim.inner, rim.outer)

    def level(places: FloatArray, height: float) -> FloatArray:
        found: FloatArray = rim.center + places + height * rim.normal
        return found

    return _Box(
        rim=on_rim,
        top=level(corners, rim.outer),
        bottom=level(corners, bottom),
        bowl=level(bowl, lower + BOWL_DEPTH * (bottom - lower)),
        core=level(core, rim.inner),
        core_bottom=level(core_bottom, rim.inner + CORE_DEPTH * (bottom - rim.inner)),
        disc=level(corners, 0.0),
        chains=chains,
    )


def _arcs(rim: Rim, out: FloatArray) -> list[Chain]:
    """The four arcs of a circle between directions (4, 3)."""
    middles = out + np.roll(out, -1, axis=0)
    middles /= np.linalg.norm(middles, axis=1)[:, None]
    ends = [_point(rim.center + rim.radius * way) for way in out]
    tops = [_point(rim.center + rim.radius * way) for way in middles]
    arcs = [GC_MakeArcOfCircle(ends[i], tops[i], ends[(i + 1) % 4]).Value() for i in range(4)]
    return [[(BRepBuilderAPI_MakeEdge(arc).Edge(), 1.0)] for arc in arcs]


def _along(rim: Rim, across: FloatArray) -> tuple[FloatArray, list[Chain]]:
    """Points (4, 3) of an outline towards the corners of a box, and its pieces between them.

    What is long is seen as square. A corner of the outline, or the middle of a rounded one, is taken where one lies in
    about the direction of the box's, so that no short edge is left.
    """
    extents = np.maximum(rim.reach(across), rim.reach(-across))
    at = np.linspace(0.0, 1.0, 65)

    def angles(points: FloatArray) -> FloatArray:
        x, y = ((points - rim.center) @ across.T / extents).T
        found: FloatArray = np.arctan2(y, x)
        return found

    def turned(angle: FloatArray) -> FloatArray:
        return np.angle(np.exp(1j * angle))

    marks = list(_marks(rim))
    seen = angles(np.array([_on(rim, k, share) for k, share in marks]))
    places: list[tuple[int, float]] = []
    for way in (0.25 * pi, 0.75 * pi, -0.75 * pi, -0.25 * pi):
        off = np.abs(turned(seen - way))
        j = int(off.argmin())
        if off[j] < SNAP and marks[j] not in places:
            places.append(marks[j])
            continue
        for k, (edge, forward) in enumerate(rim.edges):
            span = turned(angles(edge.curve.evaluate(at if forward else at[::-1])) - way)
            if span[0] <= 0.0 < span[-1] and span[-1] - span[0] < pi:
                places.append((k, float(np.interp(0.0, span, at))))
                break
        else:
            raise AssertionError("an outline without a notch is met by every ray from its middle")
    return np.array([_on(rim, *place) for place in places]), [
        _pieces(rim, places[i], places[(i + 1) % 4]) for i in range(4)
    ]


def _marks(rim: Rim) -> Iterator[tuple[int, float]]:
    """Where an outline is best divided, as number of the edge and share of it: at corners, and on its arcs."""
    ends = [np.diff(edge.curve.evaluate(np.array([0.0, 1e-3, 1.0 - 1e-3, 1.0])), axis=0)[::2] for edge, _ in rim.edges]
    tangents = [
        (first, last) if forward else (-last, -first)
        for (first, last), (_, forward) in zip(ends, rim.edges, strict=True)
    ]
    for k, (begin, end) in enumerate(tangents):
        if _turn(tangents[k - 1][1], begin) > CORNER:
            yield k, 0.0
        turn = _turn(begin, end)
        if turn > CORNER:
            yield from [(k, 0.25), (k, 0.75)] if turn > WIDE else [(k, 0.5)]


def _turn(one: FloatArray, other: FloatArray) -> float:
    cosine = float(one @ other) / float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def _on(rim: Rim, k: int, share: float) -> FloatArray:
    edge, forward = rim.edges[k]
    point: FloatArray = edge.curve.evaluate(np.array([share if forward else 1.0 - share]))[0]
    return point


def _pieces(rim: Rim, begin: tuple[int, float], end: tuple[int, float]) -> Chain:
    """Edges along an outline from one place to another."""
    cuts = [begin]
    k = begin[0]
    while True:
        last = k == end[0] and (end[1] > cuts[-1][1] or len(cuts) > 1)
        stop = end[1] if last else 1.0
        if stop > cuts[-1][1] + 1e-9 or not last:
            cuts.append((k, stop))
        if last:
            break
        k = (k + 1) % len(rim.edges)
        cuts.append((k, 0.0))
        if (k, 0.0) == end:
            break
    pieces: list[tuple[Any, float]] = []
    for (i, low), (j, high) in pairwise(cuts):
        if i == j and high > low:
            a, middle, b = (_on(rim, i, share) for share in (low, 0.5 * (low + high), high))
            if rim.edges[i][0].kind == "line":
                made = BRepBuilderAPI_MakeEdge(_point(a), _point(b)).Edge()
            else:
                arc = GC_MakeArcOfCircle(_point(a), _point(middle), _point(b)).Value()
                made = BRepBuilderAPI_MakeEdge(arc).Edge()
            pieces.append((made, (high - low) * rim.edges[i][0].length))
    ends = np.cumsum([length for _, length in pieces])
    return [(made, float(e / ends[-1])) for (made, _), e in zip(pieces, ends, strict=True)]


def _quad(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> Any:
    """A face between four corners: plane where they are, else ruled from `ab` to `dc`."""
    normal = np.cross(c - a, b - d)
    if abs(float((b - a) @ normal)) <= PLANE * float(np.linalg.norm(normal)) * float(np.linalg.norm(c - a)):
        return _polygon((a, b, c, d))
    lines = (BRepBuilderAPI_MakeEdge(_point(p), _point(q)).Edge() for p, q in ((a, b), (d, c)))
    return BRepFill.Face_s(*lines)


def _fits(rim: Rim, across: FloatArray, widths: FloatArray, depth: float, is_inside: IsInside) -> bool:
    """Whether there is material in the box, and a little around it."""
    floor = rim.center + min(rim.inner, rim.outer) * rim.normal
    first, second = (np.linspace(CLEAR * low, CLEAR * high, 5) for low, high in widths)
    for below in CLEAR * depth * np.array([0.02, 0.5, 1.0]):
        for a, b in product(first, second):
            if not is_inside(floor + a * across[0] + b * across[1] - below * rim.normal):
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
