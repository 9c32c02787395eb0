"""A planar solid cut along polygons: all of them in one general fuse, checked as any cut is.

Place in the flow: the search on planar complexes (:mod:`cadsweep.decomposition`) gives the faces of its cuts;
here they become faces of the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt

from ...arrays import FloatArray
from ...brep import Part
from .cutting import cut_cell


def cut_along(part: Part, polygons: Sequence[tuple[FloatArray, Sequence[FloatArray]]]) -> Part | None:
    """Cut the one solid of a part along plane polygons.

    Parameters
    ----------
    part : Part
    polygons : sequence of (normal, loops)
        Unit normal (3,), and the corners (n, 3) of every loop, the outer one first.

    Returns
    -------
    Part or None
        None where OpenCASCADE does not make sound pieces of it.
    """
    return cut_cell(part, 0, [_face(normal, loops) for normal, loops in polygons])


def _face(normal: FloatArray, loops: Sequence[FloatArray]) -> Any:
    outer, *holes = [_wire(loop) for loop in loops]
    plane = gp_Pln(gp_Pnt(*loops[0][0]), gp_Dir(*normal))
    maker = BRepBuilderAPI_MakeFace(plane, outer, True)
    for hole in holes:
        maker.Add(hole)
    return maker.Face()


def _wire(corners: FloatArray) -> Any:
    polygon = BRepBuilderAPI_MakePolygon()
    for corner in corners:
        polygon.Add(gp_Pnt(*map(float, corner)))
    polygon.Close()
    return polygon.Wire()
