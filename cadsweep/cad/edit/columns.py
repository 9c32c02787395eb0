"""A stack cut into its columns: the outlines of its caps carried through the material as walls.

Place in the flow: for who wants the columns as solids, and for the search for cuts where a stack touches other solids.
To mesh a stack by itself needs none of it: there the columns are cells of a plane arrangement and levels.

Method: each edge between two cells of the arrangement is extruded along the direction where both have material, and
nowhere else, so that no cutter lies on a wall of the part.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.gp import gp_Trsf, gp_Vec

from ...arrays import FloatArray
from ...stack import Stack, name_direction
from ..extract.prism import plane_shapes
from ..shapes import FACE, compound, subshapes
from .central import Cutter


def walls_between_columns(stack: Stack, walls: Sequence[tuple[int, float, float]]) -> Cutter:
    """What parts the columns of a stack.

    Parameters
    ----------
    stack : Stack
    walls : sequence of (int, float, float)
        Edges of its arrangement over which columns touch, and from which height along the direction to which.
    """
    prism = stack.arrangement.prism
    edges = plane_shapes(prism).edges
    base = float((prism.vertices @ stack.direction).min())
    # Walls from one height to another at once: those that meet share the line where they do.
    heights: dict[tuple[float, float], list[Any]] = {}
    for e, low, high in walls:
        heights.setdefault((float(f"{low - base:.9g}"), float(f"{high - low:.9g}")), []).append(edges[e])
    return Cutter(
        reason=f"the outlines of the caps across ({name_direction(stack.direction)}), carried through: "
        f"{stack.n_columns} columns",
        tools=tuple(face for (at, high), own in heights.items() for face in _walls(own, stack.direction, at, high)),
        weight=0.0,
        leads=True,
        kind="columns",
        family="columns",
    )


def _walls(edges: Sequence[Any], direction: FloatArray, rise: float, height: float) -> list[Any]:
    """Edges of the plane extruded, from a height over it."""
    up = gp_Trsf()
    up.SetTranslation(gp_Vec(*(rise * direction)))
    moved = BRepBuilderAPI_Transform(compound(edges), up, True).Shape()
    return subshapes(BRepPrimAPI_MakePrism(moved, gp_Vec(*(height * direction))).Shape(), FACE)


__all__ = ["walls_between_columns"]
