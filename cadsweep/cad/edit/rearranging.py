"""An arrangement made again of lines that were laid together.

Place in the flow: after ``stacks`` has found outlines that nearly coincide; as :mod:`.arrangement`, without a fuse: the
lines are known to meet in their ends alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeVertex
from OCP.GC import GC_MakeSegment
from OCP.Geom import Geom_Plane
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt
from OCP.TColgp import TColgp_HArray1OfPnt

from ...arrays import FloatArray
from ...brep import Solid
from ...errors import CadError
from ...stack import Arrangement, Outline
from ..extract.prism import plane_shapes
from ..shapes import EDGE, compound, index_map
from .plane_cells import Line, cells_between

_SAME = 1e-7
"""Distance, in sizes of the part, up to which a vertex is where it was."""
_CLOSE = 1e-9
"""The same between the points that a spline goes through."""


def rearrange(  # noqa: PLR0917
    solid: Solid,
    direction: FloatArray,
    sides: Mapping[int, int],
    arrangement: Arrangement,
    vertices: FloatArray,
    outlines: Sequence[Outline],
) -> Arrangement:
    """Make the cells between outlines that were laid together.

    Parameters
    ----------
    solid, direction, sides
        As for :func:`cadsweep.cad.arrange`.
    arrangement : Arrangement
        The exact one, whose edges are taken where they stay.
    vertices : (n, 3) float64
        On its plane; the first ones are its own, moved or not.
    outlines : sequence of Outline
        Their points on the plane, too.

    Raises
    ------
    CadError
        They cross each other, or their cells are not those of the part.
    """
    holder = plane_shapes(arrangement.prism)
    heights = solid.vertices @ direction
    low, high = float(heights.min()), float(heights.max())
    plane = Geom_Plane(gp_Pln(gp_Pnt(*(low * direction)), gp_Dir(*direction)))
    same = _SAME * solid.size
    corners: dict[int, Any] = {}

    def corner(v: int) -> Any:
        if v not in corners:
            old = v < len(arrangement.prism.vertices)
            if old and float(np.abs(arrangement.prism.vertices[v] - vertices[v]).max()) <= same:
                corners[v] = holder.vertices[v]
            else:
                corners[v] = BRepBuilderAPI_MakeVertex(gp_Pnt(*vertices[v])).Vertex()
        return corners[v]

    pieces = []
    for outline in outlines:
        if outline.points is None:
            shape = holder.edges[outline.base]
        else:
            shape = _edge(outline.points, corner(outline.start), corner(outline.end), solid.size)
        pieces.append(Line(shape, list(outline.over)))
    made = cells_between(solid, direction, sides, pieces, plane, (high - low) * direction)
    number = _numbers(made, pieces)
    return replace(made, claims={number[j]: outline.claims for j, outline in enumerate(outlines) if j in number})


def _numbers(made: Arrangement, pieces: Sequence[Line]) -> dict[int, int]:
    """Edge of the arrangement that every piece became; those that bound no material are not in it."""
    shapes = plane_shapes(made.prism).edges
    ids, number = list(shapes), index_map(compound(list(shapes.values())), EDGE)
    at = [number.FindIndex(piece.shape) - 1 for piece in pieces]
    return {j: ids[k] for j, k in enumerate(at) if k >= 0}


def _edge(points: FloatArray, start: Any, end: Any, size: float) -> Any:
    """An edge through points, between two vertices."""
    first, last = gp_Pnt(*points[0]), gp_Pnt(*points[-1])
    if len(points) == 2:
        maker = BRepBuilderAPI_MakeEdge(GC_MakeSegment(first, last).Value(), start, end)
    else:
        row = TColgp_HArray1OfPnt(1, len(points))
        for j, point in enumerate(points, start=1):
            row.SetValue(j, gp_Pnt(*point))
        interpolation = GeomAPI_Interpolate(row, False, _CLOSE * size)
        interpolation.Perform()
        if not interpolation.IsDone():
            raise CadError("OpenCASCADE could not lead a line of the plane through its points")
        maker = BRepBuilderAPI_MakeEdge(interpolation.Curve(), start, end)
    if not maker.IsDone():
        raise CadError("OpenCASCADE could not make a line of the plane between its ends")
    return maker.Edge()


__all__ = ["rearrange"]
