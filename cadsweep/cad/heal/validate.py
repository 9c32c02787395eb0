"""What a model must be before it is divided and read: finite, closed, manifold, with a volume.

Place in the flow: around healing. Every refusal names the place.

Not checked here: faces that pass through each other away from their edges; OpenCASCADE finds those
only by intersecting all pairs of faces, and the check of the finished mesh sees their effect.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer, BRepCheck_Status
from OCP.BRepGProp import BRepGProp
from OCP.BRepTools import BRepTools
from OCP.GProp import GProp_GProps
from OCP.TopExp import TopExp
from OCP.TopTools import TopTools_IndexedDataMapOfShapeListOfShape

from ...errors import CadError
from ..shapes import EDGE, FACE, SHELL, SOLID, VERTEX, WIRE, bounds, space_range, subshapes
from .crowded import is_valid_apart

_FLAT = 1e-10
"""Volume over surface and size, at or below which a solid is flat: sums of a flat one leave some 1e-16."""
MOST = 1e15
"""Greatest coordinate that is believed; OpenCASCADE takes 1e100 for infinite."""

_HARMLESS = {
    "NoError",
    "InvalidPointOnCurve",
    "InvalidPointOnCurveOnCurve",
    "InvalidPointOnCurveOnSurface",
    "InvalidCurveOnSurface",
    "InvalidCurveOnCurve",
    "InvalidSameRangeFlag",
    "InvalidSameParameterFlag",
    "InvalidDegeneratedFlag",
    "InvalidToleranceValue",
    "No3DCurve",
    "Invalid3DCurve",
    "CheckFail",
}
"""Findings about tolerances and flags; the geometry read from such a shape is checked by its use."""


def check_finite(shape: Any) -> None:
    """Refuse coordinates that are NaN, infinite or beyond :data:`MOST`.

    Raises
    ------
    CadError
        Names the vertex, edge or face.
    """
    for what, kind, points in (
        ("vertex", VERTEX, _vertex_points),
        ("edge", EDGE, _edge_points),
        ("face", FACE, _face_points),
    ):
        for number, sub in enumerate(subshapes(shape, kind)):
            values = np.array([[p.X(), p.Y(), p.Z()] for p in points(sub)]).reshape(-1, 3)
            if not np.all(np.abs(values) <= MOST):
                raise CadError(
                    f"{what} {number} has a coordinate that is not a finite number below {MOST:g}. "
                    "Look for NaN or infinite lengths in what made the model."
                )


def _vertex_points(vertex: Any) -> Iterator[Any]:
    yield BRep_Tool.Pnt_s(vertex)


def _edge_points(edge: Any) -> Iterator[Any]:
    curve = BRep_Tool.Curve_s(edge, 0.0, 1.0)
    if curve is not None:
        first, last = space_range(edge)
        for share in (0.0, 0.37, 1.0):
            yield curve.Value(first + share * (last - first))


def _face_points(face: Any) -> Iterator[Any]:
    surface = BRep_Tool.Surface_s(face)
    if surface is not None:
        u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
        yield surface.Value((u0 + u1) / 2, (v0 + v1) / 2)


def is_closed(solid: Any) -> bool:
    """Whether the faces of a solid meet two by two along every edge."""
    try:
        check_closed(solid)
    except CadError:
        return False
    return True


def check_closed(solid: Any) -> None:
    """Refuse a solid whose faces do not meet two by two along every edge.

    Raises
    ------
    CadError
        Says how many edges are free or shared by more than two faces, and where the first is.
    """
    uses = TopTools_IndexedDataMapOfShapeListOfShape()
    TopExp.MapShapesAndAncestors_s(solid, EDGE, FACE, uses)
    free, crowded = [], []
    edges = subshapes(solid, EDGE)
    for edge in edges:
        n = uses.FindFromKey(edge).Extent() if uses.Contains(edge) else 0
        if n == 1:
            free.append(edge)
        elif n > 2:
            crowded.append((edge, n))
    if free:
        raise CadError(
            f"the solid is open: only one face ends at {len(free)} of its {len(edges)} edges, the first at "
            f"{place(free[0])}. A face is missing, or faces do not meet; close the gap in the CAD program."
        )
    if crowded:
        raise CadError(
            f"the solid is not manifold: more than two faces meet at {len(crowded)} of its {len(edges)} edges, the "
            f"first at {place(crowded[0][0])}, where {crowded[0][1]} do. Bodies that touch along an edge must be "
            "merged or separated."
        )


def place(edge: Any) -> str:
    """Where the middle of an edge is, for messages."""
    curve = BRep_Tool.Curve_s(edge, 0.0, 1.0)
    if curve is None:
        return "an unknown place"
    first, last = space_range(edge)
    p = curve.Value((first + last) / 2)
    return f"({p.X():.4g}, {p.Y():.4g}, {p.Z():.4g})"


def faults(shape: Any) -> list[str]:
    """What OpenCASCADE's own check finds wrong with the shape and its parts, harmless findings left out."""
    if is_valid_apart(shape):
        return []
    analyzer = BRepCheck_Analyzer(shape)
    if analyzer.IsValid():
        return []
    found = []
    for what, kind in (("solid", SOLID), ("shell", SHELL), ("face", FACE), ("wire", WIRE), ("edge", EDGE)):
        for number, sub in enumerate(subshapes(shape, kind)):
            if analyzer.IsValid(sub):
                continue  # its statuses say so one by one, which takes long in Python
            for status in _statuses(analyzer, sub, kind):
                if status not in _HARMLESS:
                    where = f" at {place(subshapes(sub, EDGE)[0])}" if subshapes(sub, EDGE) else ""
                    found.append(f"{what} {number}{where}: {_in_words(status)}")
    return list(dict.fromkeys(found))


def _statuses(analyzer: Any, sub: Any, kind: Any) -> Iterator[str]:
    result = analyzer.Result(sub)
    if result is None:
        return
    for status in result.Status():
        yield _status_name(status)
    if kind in (EDGE, WIRE):
        result.InitContextIterator()
        while result.MoreShapeInContext():
            for status in result.StatusOnShape():
                yield _status_name(status)
            result.NextShapeInContext()


def _status_name(status: Any) -> str:
    return BRepCheck_Status(status).name.removeprefix("BRepCheck_")


def _in_words(status: str) -> str:
    return "".join(f" {c.lower()}" if c.isupper() else c for c in status).strip()


def signed_volume(solid: Any) -> float:
    """Volume of the solid, negative where it is inside out.

    Raises
    ------
    CadError
        The solid is flat: its mean thickness is nothing against its size.
    """
    properties, surface = GProp_GProps(), GProp_GProps()
    BRepGProp.VolumeProperties_s(solid, properties)
    BRepGProp.SurfaceProperties_s(solid, surface)
    volume, box = float(properties.Mass()), bounds(solid)
    if not abs(volume) > _FLAT * float(np.linalg.norm(box[1] - box[0])) * float(surface.Mass()):
        raise CadError(f"the solid has no volume ({volume:.4g}): it is flat or folded. Look for a height of zero.")
    return volume
