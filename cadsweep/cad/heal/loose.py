"""Loose faces of several solids told apart: IGES files, and others, often hold nothing but faces.

Place in the flow: after reading, where a model has faces and no solid. Sewn all at once, the faces of two solids that
touch become one shell through both.

Method: the faces of a solid stand together in a file. Along the file, edges are paired with those that lie on them;
wherever none is left alone, a closed shell is complete, and the next solid begins. A shell whose faces look inwards,
within a solid whose faces look outwards, is a void of that.

Not handled: files that mix the faces of their solids.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import scipy
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeSolid
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepTools import BRepTools_ReShape
from OCP.TopAbs import TopAbs_State
from OCP.TopoDS import TopoDS

from ...arrays import FloatArray, IntArray
from ..read.model import Model
from ..shapes import EDGE, FACE, SHELL, SOLID, VERTEX, bounds, compound, explore, subshapes, volume_and_center
from .solids import SEWING, sew
from .tracing import Traced
from .validate import signed_volume


def separate_solids(model: Model) -> Model:
    """Sew the faces of a model of loose faces to several solids, where they are those of several; else as it is.

    Raises
    ------
    CadError
        Faces that close a volume cannot be sewn.
    """
    if solids := subshapes(model.shape, SOLID):
        return _without_empty(model, solids)
    groups = _closed_groups(list(explore(model.shape, FACE)))
    if len(groups) < 2:
        return model
    bodies, voids, notes = list[Any](), list[Any](), list(model.notes)
    for faces in groups:
        traced = Traced(compound(faces))
        is_void = signed_volume(traced.shape) < 0
        notes.append(sew(traced))
        (voids if is_void else bodies).append(traced.shape)
    for void in voids:
        around = [j for j, body in enumerate(bodies) if _is_inside(void, body)]
        if around:  # the innermost
            j = min(around, key=lambda j: volume_and_center(bodies[j])[0])
            bodies[j] = _with_void(bodies[j], void)
            notes.append("a shell that looks inwards is taken for a void of the solid around it")
        else:
            bodies.append(void)
    return replace(model, shape=bodies[0] if len(bodies) == 1 else compound(bodies), notes=notes)


def _without_empty(model: Model, solids: list[Any]) -> Model:
    """The model without solids that have no faces, as some programs write them; as it is where no other is there."""
    empty = [solid for solid in solids if not subshapes(solid, FACE)]
    if not empty or len(empty) == len(solids):
        return model
    tool = BRepTools_ReShape()
    for solid in empty:
        tool.Remove(solid)
    said = (
        "a solid has no faces, and is left out"
        if len(empty) == 1
        else f"{len(empty)} solids have no faces, and are left out"
    )
    return replace(model, shape=tool.Apply(model.shape), notes=[*model.notes, said])


def _is_inside(inner: Any, outer: Any) -> bool:
    """Whether one solid lies in another: its box, and one of its vertices."""
    own, other = bounds(inner), bounds(outer)
    if (own[0] <= other[0]).any() or (own[1] >= other[1]).any():
        return False
    vertex = next(iter(explore(inner, VERTEX)), None)
    if vertex is None:
        return False
    place = BRep_Tool.Pnt_s(vertex)
    return bool(BRepClass3d_SolidClassifier(outer, place, SEWING * _size([inner])).State() == TopAbs_State.TopAbs_IN)


def _with_void(solid: Any, void: Any) -> Any:
    """A solid with the shell of another one, turned round, as a shell of its own."""
    hollow = BRepBuilderAPI_MakeSolid()
    for shell in subshapes(solid, SHELL):
        hollow.Add(TopoDS.Shell_s(shell))
    for shell in subshapes(void, SHELL):
        hollow.Add(TopoDS.Shell_s(shell.Reversed()))
    return hollow.Solid()


def _closed_groups(faces: list[Any]) -> list[list[Any]]:
    """Runs of faces each of which closes a volume; none where faces are left over."""
    uses = [[edge for edge in explore(face, EDGE) if not BRep_Tool.Degenerated_s(edge)] for face in faces]
    edges = [edge for own in uses for edge in own]
    if not edges or not all(uses) or any(BRep_Tool.Curve_s(edge, 0.0, 1.0) is None for edge in edges):
        return []
    points = _middles_and_ends(edges)
    if not np.isfinite(points).all():  # refused by name later
        return []
    places = _places(points, SEWING * _size(faces))
    groups: list[list[Any]] = []
    alone: set[int] = set()
    begin = first = 0
    for number, own in enumerate(uses):
        for place in places[first : first + len(own)].tolist():
            alone ^= {place}
        first += len(own)
        if not alone:
            groups.append(faces[begin : number + 1])
            begin = number + 1
    return [] if alone else groups


def _middles_and_ends(edges: list[Any]) -> FloatArray:
    """For each edge its middle and the mean of its ends (n, 6), the same whichever way it runs."""
    points = []
    for edge in edges:
        curve = BRepAdaptor_Curve(edge)
        first, last = curve.FirstParameter(), curve.LastParameter()
        places = [curve.Value(first + at * (last - first)) for at in (0.0, 0.5, 1.0)]
        a, middle, b = (np.array([p.X(), p.Y(), p.Z()]) for p in places)
        points.append(np.concatenate([middle, (a + b) / 2.0]))
    return np.array(points)


def _places(points: FloatArray, tolerance: float) -> IntArray:
    """Equal numbers (n,) for edges that lie on each other, by their middles and ends (n, 6)."""
    pairs = scipy.spatial.cKDTree(points).query_pairs(2.0 * tolerance, output_type="ndarray")
    links = scipy.sparse.coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1], dtype=np.int64)


def _size(faces: list[Any]) -> float:
    box = bounds(compound(faces))
    return float(abs(box[1] - box[0]).max())


__all__ = ["separate_solids"]
