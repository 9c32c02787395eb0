"""The outlines of faces carried along a direction on one plane, where they divide it into cells.

Place in the flow: called by the pipeline for a part that is to be meshed as columns of material.

Method: edges are projected on the plane exactly (lines, circles, splines; what OpenCASCADE projects by
approximation is as good as its tolerance), OpenCASCADE's general fuse divides those that may touch others, and cells
are made between all of them. Which faces lie over a cell follows from its neighbour by the edge between them: who
crosses it enters some faces and leaves others. The cells are extruded to a prism, so that whatever meshes the source
cap of a sweep can mesh them.

Not handled: shadows that touch themselves at a point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import scipy
from OCP.BOPAlgo import BOPAlgo_Builder
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.ElCLib import ElCLib
from OCP.GC import GC_MakeSegment
from OCP.Geom import Geom_Circle, Geom_Plane, Geom_TrimmedCurve
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.GeomProjLib import GeomProjLib
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_Orientation

from ...arrays import BoolArray, FloatArray
from ...brep import Edge, Solid
from ...errors import CadError
from ...stack import Arrangement
from ..geometry.curves import EdgeCurve
from ..geometry.plane_curves import PlaneCurves
from ..shapes import EDGE, SolidShape, index_map, listed, typed
from ..trial import attempted
from .lines_apart import Corners, lines_apart
from .plane_cells import Line, cells_between
from .plane_loops import plane_frame

_FORWARD, _REVERSED = TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED
_FUZZY = 1e-7
"""Distance, in sizes of the part, up to which projected edges and their ends count as the same."""
_STRANGE = 4.0
"""Times that distance, up to which edges may be divided by each other."""


def arrange(solid: Solid, direction: FloatArray, sides: Mapping[int, int], lines: Sequence[int]) -> Arrangement:
    """Carry edges along a direction on one plane and find the cells between them.

    Parameters
    ----------
    solid : Solid
    direction : (3,) float64
        Unit vector.
    sides : mapping of int to int
        Faces that a line along `direction` crosses once, and whether it leaves the solid there (1) or enters it (-1).
    lines : sequence of int
        Edges to project, none of them along `direction`: all edges of these faces, at least.

    Raises
    ------
    CadError
        OpenCASCADE fails, or what it makes is no division of the plane by these edges.
    """
    holder = solid.kernel
    if not isinstance(holder, SolidShape):
        raise CadError("the solid has no shape of OpenCASCADE's")
    heights = solid.vertices @ direction
    low, high = float(heights.min()), float(heights.max())
    fuzzy = max(_FUZZY * solid.size, 2.0 * solid.tolerance)
    plane = Geom_Plane(gp_Pln(gp_Pnt(*(low * direction)), gp_Dir(*direction)))
    projected = _projected(solid, holder, direction, plane, lines, fuzzy)
    curves = PlaneCurves([solid.edges[line.over[0][0]].curve for line in projected], *plane_frame(plane))
    ends = curves.points(np.arange(len(projected)), np.tile([0.0, 1.0], (len(projected), 1)))
    corners = Corners(ends @ curves.axes + curves.origin, fuzzy)
    over = [[e for e, _ in line.over] for line in projected]
    apart = lines_apart(solid, sides, over, curves, corners, _STRANGE * fuzzy)
    pieces = _divided(projected, apart, corners, fuzzy)
    return cells_between(solid, direction, sides, pieces, plane, (high - low) * direction)


def _projected(  # noqa: PLR0917
    solid: Solid, holder: SolidShape, direction: FloatArray, plane: Any, lines: Sequence[int], fuzzy: float
) -> list[Line]:
    """The edges on the plane, those that fall on each other once."""
    ends = np.empty((len(lines), 3, 3))
    for places, e in zip(ends, lines, strict=True):
        edge = solid.edges[e]
        places[:] = solid.vertices[edge.start], _half_way(edge), solid.vertices[edge.end]
    ends -= (ends @ direction)[..., None] * direction
    near = scipy.spatial.cKDTree(ends[:, 1]).query_ball_point(ends[:, 1], 2.0 * fuzzy)
    found: list[Line] = []
    number: dict[int, int] = {}
    for j, others in enumerate(near):
        match = None
        for k in sorted(others):
            if k in number:
                gaps = [float(np.abs(ends[k] - places).max()) for places in (ends[j], ends[j, ::-1])]
                if min(gaps) <= fuzzy:
                    match = number[k], gaps[0] <= gaps[1]
                    break
        if match is None:
            number[j] = len(found)
            found.append(Line(_project(holder.edges[lines[j]], direction, plane), [(lines[j], True)]))
        else:
            found[match[0]].over.append((lines[j], match[1]))
    return found


def _half_way(edge: Edge) -> FloatArray:
    """Where an edge has the middle one of its parameters, which stay as they are on the plane; lengths do not."""
    curve = edge.curve
    if not isinstance(curve, EdgeCurve) or curve.constant_speed:
        return edge.midpoint
    return curve.geometry.derivatives(np.array([(curve.first + curve.last) / 2.0]))[0][0]


def _row(point: Any) -> FloatArray:
    return np.array([point.X(), point.Y(), point.Z()])


def _project(edge: Any, direction: FloatArray, plane: Any) -> Any:
    """One edge on the plane, run the same way."""
    adaptor = BRepAdaptor_Curve(edge)
    first, last = adaptor.FirstParameter(), adaptor.LastParameter()
    origin = _row(plane.Location())

    def drop(point: Any) -> Any:
        x = _row(point)
        return gp_Pnt(*(x - ((x - origin) @ direction) * direction))

    kind = adaptor.GetType()
    if kind == GeomAbs_CurveType.GeomAbs_Line:
        segment = GC_MakeSegment(drop(adaptor.Value(first)), drop(adaptor.Value(last))).Value()
        return BRepBuilderAPI_MakeEdge(segment).Edge()
    if kind == GeomAbs_CurveType.GeomAbs_Circle:
        circle = adaptor.Circle()
        if abs(abs(_row(circle.Axis().Direction()) @ direction) - 1.0) < 1e-14:
            center = circle.Location()
            move = gp_Trsf()
            move.SetTranslation(center, drop(center))
            return BRepBuilderAPI_MakeEdge(Geom_Circle(circle.Transformed(move)), first, last).Edge()
    if kind == GeomAbs_CurveType.GeomAbs_BSplineCurve:
        spline = adaptor.BSpline().Copy()
        for j in range(1, spline.NbPoles() + 1):
            spline.SetPole(j, drop(spline.Pole(j)))
        return BRepBuilderAPI_MakeEdge(spline, first, last).Edge()
    curve = BRep_Tool.Curve_s(edge, 0.0, 1.0)
    image = GeomProjLib.ProjectOnPlane_s(Geom_TrimmedCurve(curve, first, last), plane, gp_Dir(*direction), True)
    return BRepBuilderAPI_MakeEdge(image).Edge()


def _divided(projected: Sequence[Line], apart: BoolArray, corners: Corners, fuzzy: float) -> list[Line]:
    """The pieces into which the projected edges divide each other, in their order."""
    alone = {j: [Line(corners.join(j, projected[j].shape), projected[j].over)] for j in np.flatnonzero(apart).tolist()}
    rest = np.flatnonzero(~apart).tolist()
    fused = _fused([projected[j] for j in rest], fuzzy) if rest else []
    found = alone | dict(zip(rest, fused, strict=True))
    return [piece for j in range(len(projected)) for piece in found[j]]


def _fused(projected: Sequence[Line], fuzzy: float) -> list[list[Line]]:
    """The pieces into which projected edges divide each other, with the first edge that has them."""
    builder = BOPAlgo_Builder()
    for line in projected:
        builder.AddArgument(line.shape)
    builder.SetNonDestructive(True)
    builder.SetFuzzyValue(fuzzy)
    shapes = [line.shape for line in projected]
    if not attempted(builder.Perform, "dividing outlines by each other", on=shapes) or builder.HasErrors():
        raise CadError("OpenCASCADE could not divide the outlines of the caps by each other")
    pieces: list[list[Line]] = []
    number = index_map(builder.Shape(), EDGE)
    at: dict[int, Line] = {}
    for line in projected:
        pieces.append([])
        images = listed(builder.Modified(line.shape)) or ([] if builder.IsDeleted(line.shape) else [line.shape])
        for image in images:
            key = number.FindIndex(image)
            if key not in at:
                at[key] = Line(typed(number.FindKey(key), EDGE), [])
                pieces[-1].append(at[key])
            same = image.IsSame(line.shape) or _runs_along(at[key].shape, line.shape)
            at[key].over.extend((e, own == same) for e, own in line.over)
    return pieces


def _runs_along(piece: Any, whole: Any) -> bool:
    """Whether the curve of a piece runs the same way as that of the edge it is a piece of."""
    short, long = BRepAdaptor_Curve(piece), BRepAdaptor_Curve(whole)
    middle, tangent = gp_Pnt(), gp_Vec()
    short.D1((short.FirstParameter() + short.LastParameter()) / 2.0, middle, tangent)
    at, along = gp_Pnt(), gp_Vec()
    kind = long.GetType()
    if kind == GeomAbs_CurveType.GeomAbs_Line:
        return bool(tangent.Dot(gp_Vec(long.Line().Direction())) > 0.0)
    if kind == GeomAbs_CurveType.GeomAbs_Circle:
        nearest = ElCLib.Parameter_s(long.Circle(), middle)
    else:
        # The place on the whole edge: curves are shared or lie on each other, so the nearest of many samples will do.
        places = np.linspace(long.FirstParameter(), long.LastParameter(), 65)
        nearest = min(places.tolist(), key=lambda t: long.Value(t).SquareDistance(middle))
    long.D1(nearest, at, along)
    return bool(tangent.Dot(along) > 0.0)


__all__ = ["arrange"]
