"""The tight box about a shape.

Place in the flow: ``solids`` and ``prism`` take a part's size from it.

Method: a face of a plane, cylinder, cone or extrusion reaches nowhere beyond its edges, and OpenCASCADE's box of a line
or an arc is exact and quick. For any other face or edge it searches for the outermost places, 20 ms a torus, 10 ms an
edge where two cylinders meet; only those are asked for that whose loose boxes stick out of what is found so far.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType

from ...arrays import FloatArray
from ..shapes import EDGE, FACE, bounds, compound, subshapes

_S = GeomAbs_SurfaceType
_BOUNDED_BY_EDGES = (
    _S.GeomAbs_Plane,
    _S.GeomAbs_Cylinder,
    _S.GeomAbs_Cone,
    _S.GeomAbs_SurfaceOfExtrusion,
)
_SIMPLE = (GeomAbs_CurveType.GeomAbs_Line, GeomAbs_CurveType.GeomAbs_Circle, GeomAbs_CurveType.GeomAbs_Ellipse)


def tight_bounds(shape: Any) -> FloatArray:
    """Least and greatest coordinates (2, 3) of a shape of faces, or of edges alone; poles and tolerances left out."""
    ruled, curved, loose = [], [], []
    faces = subshapes(shape, FACE)
    for face in faces:
        surface = BRepAdaptor_Surface(face)
        if surface.GetType() in _BOUNDED_BY_EDGES:
            ruled.append(face)
        else:
            curved.append(face)
            loose.append(_loose(face, surface))
    found = _around_edges(compound(ruled) if faces else shape)
    return _widened(found, curved, loose)


def _around_edges(shape: Any) -> FloatArray:
    """The tight box about the edges of a shape; about none of them one that is empty."""
    simple: list[Any] = []
    others: list[Any] = []
    for edge in subshapes(shape, EDGE):
        (simple if BRepAdaptor_Curve(edge).GetType() in _SIMPLE else others).append(edge)
    found = _optimal(compound(simple)) if simple else np.array([np.full(3, np.inf), np.full(3, -np.inf)])
    return _widened(found, others, [bounds(edge) for edge in others])


def _widened(found: FloatArray, shapes: Sequence[Any], loose: Sequence[FloatArray]) -> FloatArray:
    """A box (2, 3) with some shapes in it, of which loose boxes are known."""
    boxes = np.array(loose).reshape(-1, 2, 3)
    while True:
        beyond = np.maximum(found[0] - boxes[:, 0], boxes[:, 1] - found[1]).max(axis=1, initial=0.0)
        if not beyond.any():
            return found
        farthest = int(beyond.argmax())
        boxes[farthest] = own = _optimal(shapes[farthest])
        found = np.array([np.minimum(found[0], own[0]), np.maximum(found[1], own[1])])


def _optimal(shape: Any) -> FloatArray:
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    return np.array(box.Get()).reshape(2, 3)


def _loose(face: Any, surface: Any) -> FloatArray:
    """A box about a face: of a ring or a sphere that of the box of its parameters, of others that of its poles."""
    kind = surface.GetType()
    if kind == _S.GeomAbs_Torus:
        ring = surface.Torus()
        major, minor = ring.MajorRadius(), ring.MinorRadius()
    elif kind == _S.GeomAbs_Sphere:
        ring = surface.Sphere()
        major, minor = 0.0, ring.Radius()
    else:
        return bounds(face)
    position = ring.Position()
    frame = np.array(
        [
            (p.X(), p.Y(), p.Z())
            for p in (position.Location(), position.XDirection(), position.YDirection(), position.Direction())
        ]
    )
    u = surface.FirstUParameter(), surface.LastUParameter()
    v = surface.FirstVParameter(), surface.LastVParameter()
    return np.array([_reach(column, (major, minor), u, v) for column in frame.T]).T


def _reach(
    column: FloatArray, radii: tuple[float, float], u_range: tuple[float, float], v_range: tuple[float, float]
) -> tuple[float, float]:
    """Least and greatest of one coordinate of a ring, of origin and axes (4,) of its frame, over a box of u and v.

    That is ``origin + (major + minor cos v) (x cos u + y sin u) + minor sin v z``.
    """
    origin, x, y, z = column.tolist()
    major, minor = radii
    values = []
    for u in _turning(np.arctan2(y, x), u_range):
        radial = x * np.cos(u) + y * np.sin(u)
        v = np.array(_turning(np.arctan2(z, radial), v_range))
        values.append(origin + (major + minor * np.cos(v)) * radial + minor * np.sin(v) * z)
    found = np.concatenate(values)
    return float(found.min()), float(found.max())


def _turning(angle: float, ends: tuple[float, float]) -> list[float]:
    """Ends of a range, and what lies in it of an angle and those any number of half turns off, where a wave turns."""
    first = np.ceil((ends[0] - angle) / np.pi)
    return [*ends, *(angle + np.pi * np.arange(first, (ends[1] - angle) // np.pi + 1.0)).tolist()]


__all__ = ["tight_bounds"]
