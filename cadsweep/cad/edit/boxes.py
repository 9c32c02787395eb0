"""A box around every feature, and planes through the rest of a block: outside of the boxes all cells are bricks.

Place in the flow: a candidate of :mod:`.cutters` for a part with features that go different ways.

Method: a feature is what hangs together of edges in the way and of faces that one direction suits (:mod:`.axial`). Its
box grows until it meets a face or another box (:mod:`.box_layout`), and reaches along the feature's own way until the
part ends; what is blind has its rims carried on to there. Where another feature is in the way, the box ends under a
blind hole or a boss in a box of cells that keeps the circle inside (:mod:`.cushions`)::

        |   |            |
    ----+---+---+--------+----      plane through the rest: it goes through no box but along, where it makes slices of
        |   :   |        |          the box that are swept one after the other
        | f :   |        |
    ----+---:---+--------+----
        | cushion        |

All planes go through all of the rest, so that it agrees everywhere without a search.

Not handled: features that cross, faces that none of three directions suits, blind slots and pockets above other
features, and turned parts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopTools import TopTools_ListOfShape

from ...arrays import FloatArray
from ...brep import Solid
from ..shapes import FACE, shapes_of, subshapes
from ..trial import attempted
from .axial import EVERY
from .box_layout import Block, Floor, Levels, Site, apart, carried, read_block, with_walls
from .central import Cutter
from .circles import Rim
from .cushions import WIDEST, cushion
from .inside import IsInside, inside_of

LEAST_WIDTH = 1.08
"""Distance of a cushion's side from the axis, in radii of its circle, at least."""
LEAST_BOXES = 2
"""Boxes from which on this is worth it."""
MOST_BRICKS = 900
"""Boxes of the grid beyond which the search by single planes is cheaper."""
OUTSIDE, BEYOND = 0.1, 1e-3
"""How far planes reach beyond the part, and boxes beyond a face inside its extent, as shares of the part's size."""


def around_features(solid: Solid, flat: float) -> list[Cutter]:
    """Boxes around all features of a block, with all planes of the rest; none where one direction suits all.

    Parameters
    ----------
    solid : Solid
    flat : float
        Radians from pi up to which two faces at an edge are one surface.
    """
    found = read_block(solid, flat)
    if found is None:
        return []
    block, clusters = found
    plain = [cluster for cluster in clusters if cluster.ways == EVERY]
    sites = apart([block.site(cluster) for cluster in clusters if cluster.ways != EVERY], block.tight)
    if any(site.way < 0 for site in sites):
        return []
    fixed = [block.site(cluster) for cluster in plain]
    levels = Levels(block, [step for cluster in plain for step in block.steps(cluster)])
    grown = carried(block, sites, fixed)
    boxed = None if grown is None or len(grown) < LEAST_BOXES else with_walls(block, grown, fixed, levels)
    if boxed is None or np.prod([len(own) + 1 for own in levels.inner()]) > MOST_BRICKS:
        return []
    inside = [_inside(block, site) for site in boxed]

    def barred(axis: int, level: float) -> list[Site]:
        return [site for site in boxed if site.bars(axis, level, block.tight)]

    tools = [*planes_of(block, levels.inner(), barred), *(tool for own in inside for tool in own or ())]
    if not tools or any(own is None for own in inside):
        return []
    reason = f"boxes around {len(boxed)} features and planes through the rest"
    return [Cutter(kind="boxes", reason=reason, tools=tuple(tools), weight=solid.size, leads=True)]


def planes_of(
    block: Block, levels: Sequence[Sequence[float]], barred: Callable[[int, float], Sequence[Site]]
) -> Iterator[Any]:  # fmt: skip
    """Planes at levels along each normal, without what lies in boxes that they must not go through.

    Parameters
    ----------
    block : Block
    levels : three sequences of float
    barred : callable
        The boxes in the way of a plane, by normal and level.
    """
    margin = OUTSIDE * block.solid.size
    is_inside = inside_of(block.solid)
    for axis, own in enumerate(levels):
        i, j = (a for a in range(3) if a != axis)
        for level in own:
            outer = [_reach(block, site, is_inside) for site in barred(axis, level)]
            holes = [_rectangle(block, axis, level, (low[i], high[i]), (low[j], high[j])) for low, high in outer]
            whole = _rectangle(
                block,
                axis,
                level,
                (block.low[i] - margin, block.high[i] + margin),
                (block.low[j] - margin, block.high[j] + margin),
            )
            yield from _without(whole, holes)


def _reach(block: Block, site: Site, is_inside: IsInside) -> tuple[FloatArray, FloatArray]:
    """A box, a little beyond its sides on the outside of the part: a plane that ends there would mark the face."""
    low, high = site.low.copy(), site.high.copy()
    small = BEYOND * block.solid.size
    for axis in range(3):
        i, j = (a for a in range(3) if a != axis)
        for sign, side, end in ((-1, low, block.low), (1, high, block.high)):
            if abs(side[axis] - end[axis]) < block.tight:
                side[axis] += 2.0 * sign * OUTSIDE * block.solid.size
                continue
            place = np.empty(3)
            place[axis] = side[axis] + 0.5 * sign * small
            shares = product((0.02, 0.25, 0.5, 0.75, 0.98), repeat=2)
            inside = False
            for a, b in shares:
                place[i] = site.low[i] + a * (site.high[i] - site.low[i])
                place[j] = site.low[j] + b * (site.high[j] - site.low[j])
                inside = inside or is_inside(place @ block.normals)
            if not inside:
                side[axis] += sign * small
    return low, high


def _without(whole: Any, holes: Sequence[Any]) -> list[Any]:
    """What is left of a plane face."""
    if not holes:
        return [whole]
    arguments, tools = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(whole)
    for hole in holes:
        tools.Append(hole)
    cut = BRepAlgoAPI_Cut()
    cut.SetArguments(arguments)
    cut.SetTools(tools)
    done = attempted(cut.Build, "dividing a plane around features", on=holes)
    return subshapes(cut.Shape(), FACE) if done else []


def _rectangle(block: Block, axis: int, level: float, first: Sequence[float], second: Sequence[float]) -> Any:
    i, j = (a for a in range(3) if a != axis)
    wire = BRepBuilderAPI_MakePolygon()
    for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
        place = np.zeros(3)
        place[axis], place[i], place[j] = level, first[a], second[b]
        wire.Add(gp_Pnt(*map(float, place @ block.normals)))
    wire.Close()
    return BRepBuilderAPI_MakeFace(wire.Wire(), True).Face()


def fit_cushion(
    block: Block, rim: Rim, way: int, sides: tuple[FloatArray, FloatArray], depth: float, *, widest: float
) -> list[Any] | None:
    """Cells of a depth under an outline, out to the low and high sides of a box; None where these do not fit it."""
    across = [a for a in range(3) if a != way]
    center = block.normals @ rim.center
    widths = np.array([[side[a] - center[a] for side in sides] for a in across])
    out = np.array([sign * block.normals[a] for a in across for sign in (-1.0, 1.0)])
    shares = np.abs(widths) / rim.reach(out).reshape(2, 2)
    if shares.min() < LEAST_WIDTH or shares.max() > widest:
        return None
    directions = block.normals[across]
    if float(np.cross(directions[0], directions[1]) @ rim.normal) < 0.0:
        directions, widths = directions[::-1], widths[::-1]
    return cushion(rim, directions, widths, depth)


def carry_on(block: Block, floor: Floor, way: int, end: float) -> list[Any]:
    """An edge of a floor carried on to a level; none where it lies there."""
    if abs(end - floor.level) <= block.tight:
        return []
    edge = shapes_of(block.solid).edges[floor.edge]
    made = BRepPrimAPI_MakePrism(edge, gp_Vec(*map(float, (end - floor.level) * block.normals[way])), True)
    return subshapes(made.Shape(), FACE)


def _inside(block: Block, site: Site) -> list[Any] | None:
    """What divides a box: its cushion, and rims carried on to its end."""
    if site.cushion is not None:
        rim, depth = site.cushion
        return fit_cushion(block, rim, site.way, (site.low, site.high), depth, widest=WIDEST + 0.5)
    ends = [(site.low if floor.down < 0 else site.high)[site.way] for floor in site.floors]
    return [
        tool
        for floor, end in zip(site.floors, ends, strict=True)
        for tool in carry_on(block, floor, site.way, float(end))
    ]


__all__ = ["MOST_BRICKS", "around_features", "carry_on", "fit_cushion", "planes_of"]
