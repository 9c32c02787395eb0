"""Whose names the faces, edges and solids of the healed shape carry.

Place in the flow: after dividing, before extraction. Names hang on sub-shapes of the model as it was
read (``model.Named``); ``Traced`` knows what those became. A name on a face or edge that is not in
the model any more (a CadQuery tag, set before a later cut) is matched by place: it goes to the faces
that lie on the tagged one and look the same way, to the edges that lie on the tagged one, or to the
one that it lies on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepTools import BRepTools
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec
from OCP.TopAbs import TopAbs_Orientation, TopAbs_State

from ..read.model import Named
from ..shapes import EDGE, FACE, index_map, mapped, typed
from .unique import Declared, declare

_SAME_SIDE = 0.99
"""Least cosine between the normals of a tagged face and of a face that takes over its name."""


def declare_names(named: Sequence[Named], original: Any, kind: Any) -> tuple[Declared, list[str]]:
    """Decide the names of the faces (or edges) of the model as read.

    Parameters
    ----------
    named : sequence of Named
        Only those of `kind` are looked at.
    original : TopoDS_Shape
        The model as read.
    kind : TopAbs_ShapeEnum
        FACE or EDGE.

    Returns
    -------
    Declared
        Names by index into ``Traced.faces`` (or ``.edges``).
    list of str
        Notes on names that match nothing.
    """
    found = index_map(original, kind)
    shapes = mapped(found, kind)
    groups = []
    lost = []
    for labelled, name in named:
        if labelled.ShapeType() != kind:
            continue
        shape = typed(labelled, kind)
        number = found.FindIndex(shape)
        numbers = [number - 1] if number else by_place(shape, shapes, kind)
        if not numbers:
            lost.append(name)
        groups.append((name, numbers))
    what = "face" if kind == FACE else "edge"
    kept = {name for name, numbers in groups if numbers}
    notes = [f"name '{name}' is on no {what} of the finished shape" for name in dict.fromkeys(lost) if name not in kept]
    return declare(groups, what=what), notes


def by_place(shape: Any, candidates: Sequence[Any], kind: Any) -> list[int]:
    """Which faces (or edges) lie on one of an earlier state of the model, or else on which of them it lies."""
    if kind == EDGE:
        on_it = [j for j, edge in enumerate(candidates) if _covers(shape, edge)]
        return on_it or [j for j, edge in enumerate(candidates) if _covers(edge, shape)]
    tagged = inner_point(shape)
    if tagged is None:
        return []
    lie_on_it, it_lies_on = [], []
    for j, face in enumerate(candidates):
        point = inner_point(face)
        if point is None:
            continue
        tolerance = 10 * max(BRep_Tool.Tolerance_s(face), BRep_Tool.Tolerance_s(shape))
        if _lies_on(point, shape, tolerance):
            lie_on_it.append(j)
        elif _lies_on(tagged, face, tolerance):
            it_lies_on.append(j)
    return lie_on_it or it_lies_on


def _covers(edge: Any, other: Any) -> bool:
    """Whether inner points of another edge lie on an edge; two that only cross share one point."""
    curve = BRepAdaptor_Curve(other)
    first, last = curve.FirstParameter(), curve.LastParameter()
    tolerance = 10 * max(BRep_Tool.Tolerance_s(edge), BRep_Tool.Tolerance_s(other))
    for at in (0.2, 0.5, 0.7):
        vertex = BRepBuilderAPI_MakeVertex(curve.Value(first + at * (last - first))).Vertex()
        distance = BRepExtrema_DistShapeShape(vertex, edge)
        if not distance.IsDone() or distance.Value() > tolerance:
            return False
    return True


def _lies_on(point: tuple[Any, Any], face: Any, tolerance: float) -> bool:
    place, normal = point
    distance = BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(place).Vertex(), face)
    if not distance.IsDone() or distance.Value() > tolerance:
        return False
    other = _nearest_normal(face, place)
    return other is not None and normal.Dot(other) > _SAME_SIDE


def _nearest_normal(face: Any, place: Any) -> Any:
    from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf

    projection = GeomAPI_ProjectPointOnSurf(place, BRep_Tool.Surface_s(face))
    if projection.NbPoints() == 0:
        return None
    u, v = projection.LowerDistanceParameters()
    return _normal(face, u, v)[1]


def inner_point(face: Any) -> tuple[Any, Any] | None:
    """A point inside a face and the outward normal there; None where a search on a grid finds none."""
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    inside = BRepTopAdaptor_FClass2d(face, 1e-9)
    # Odd divisions first meet the middle, then points that symmetric holes do not cover.
    for n in (2, 3, 5, 7, 16, 31, 64):
        for i in range(1, n):
            for j in range(1, n):
                u, v = u0 + (u1 - u0) * i / n, v0 + (v1 - v0) * j / n
                if inside.Perform(gp_Pnt2d(u, v)) == TopAbs_State.TopAbs_IN:
                    place, normal = _normal(face, u, v)
                    if normal is not None:
                        return place, normal
    return None


def _normal(face: Any, u: float, v: float) -> tuple[Any, Any]:
    place, by_u, by_v = gp_Pnt(), gp_Vec(), gp_Vec()
    BRepAdaptor_Surface(face).D1(u, v, place, by_u, by_v)
    normal = by_u.Crossed(by_v)
    if normal.Magnitude() <= 1e-12 * by_u.Magnitude() * by_v.Magnitude() or normal.Magnitude() == 0.0:
        return place, None
    normal.Normalize()
    if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
        normal.Reverse()
    return place, normal
