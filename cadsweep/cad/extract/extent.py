"""The tight box about a shape.

Place in the flow: ``solids`` and ``prism`` take a part's size from it.

Method: a face of a plane, cylinder, cone or extrusion reaches nowhere beyond its edges, and OpenCASCADE's box of a line
or an arc is exact and quick. A ring or a sphere is outermost on its edges, or where its formula turns. For any other
face or edge OpenCASCADE searches for the outermost places, 20 ms a face. Only those are asked for whose loose boxes
stick out of what is found so far.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.gp import gp_Pnt2d
from OCP.TopAbs import TopAbs_State

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

_Pair = tuple[float, float]


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
    return _widened(found, curved, loose, _of_curved)


def _around_edges(shape: Any) -> FloatArray:
    """The tight box about the edges of a shape; about none of them one that is empty."""
    simple: list[Any] = []
    others: list[Any] = []
    for edge in subshapes(shape, EDGE):
        (simple if BRepAdaptor_Curve(edge).GetType() in _SIMPLE else others).append(edge)
    found = _optimal(compound(simple)) if simple else np.array([np.full(3, np.inf), np.full(3, -np.inf)])
    return _widened(found, others, [bounds(edge) for edge in others], _optimal)


def _widened(
    found: FloatArray, shapes: Sequence[Any], loose: Sequence[FloatArray], tight: Callable[[Any], FloatArray]
) -> FloatArray:
    """A box (2, 3) with some shapes in it, of which loose boxes are known; the tight one costs more."""
    boxes = np.array(loose).reshape(-1, 2, 3)
    while True:
        beyond = np.maximum(found[0] - boxes[:, 0], boxes[:, 1] - found[1]).max(axis=1, initial=0.0)
        if not beyond.any():
            return found
        farthest = int(beyond.argmax())
        boxes[farthest] = own = tight(shapes[farthest])
        found = np.array([np.minimum(found[0], own[0]), np.maximum(found[1], own[1])])


def _optimal(shape: Any) -> FloatArray:
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    return np.array(box.Get()).reshape(2, 3)


def _of_curved(face: Any) -> FloatArray:
    """The tight box about a face; a ring or a sphere is outermost on its edges, or where it turns by its formula."""
    surface = BRepAdaptor_Surface(face)
    if surface.GetType() not in (_S.GeomAbs_Torus, _S.GeomAbs_Sphere):
        return _optimal(face)
    columns, *ring = _read_ring(surface)
    found = _around_edges(face)
    inside = BRepTopAdaptor_FClass2d(face, 0.0)
    for axis, column in enumerate(columns):
        for u, v, value in _places_of_turn(column, *ring):
            if inside.Perform(gp_Pnt2d(u, v)) != TopAbs_State.TopAbs_OUT:
                found[:, axis] = min(found[0, axis], value), max(found[1, axis], value)
    return found


def _loose(face: Any, surface: Any) -> FloatArray:
    """A box about a face: of a ring or a sphere that of the box of its parameters, of others that of its poles."""
    if surface.GetType() not in (_S.GeomAbs_Torus, _S.GeomAbs_Sphere):
        return bounds(face)
    columns, *ring = _read_ring(surface)
    return np.array([_reach(column, *ring) for column in columns]).T


def _read_ring(surface: Any) -> tuple[FloatArray, _Pair, _Pair, _Pair]:
    """Origin and axes (3, 4) of the frame of a ring, coordinate by coordinate, its radii, and its ranges of u and v."""
    if surface.GetType() == _S.GeomAbs_Torus:
        ring = surface.Torus()
        radii = ring.MajorRadius(), ring.MinorRadius()
    else:
        ring = surface.Sphere()
        radii = 0.0, ring.Radius()
    position = ring.Position()
    frame = np.array(
        [
            (p.X(), p.Y(), p.Z())
            for p in (position.Location(), position.XDirection(), position.YDirection(), position.Direction())
        ]
    )
    u = surface.FirstUParameter(), surface.LastUParameter()
    v = surface.FirstVParameter(), surface.LastVParameter()
    return frame.T, radii, u, v


def _places_of_turn(
    column: FloatArray, radii: _Pair, u_range: _Pair, v_range: _Pair
) -> Iterator[tuple[float, float, float]]:
    """Parameters inside of their box where a coordinate of a ring turns, and its values there, as in :func:`_reach`."""
    origin, x, y, z = column.tolist()
    major, minor = radii
    for u in _turning(np.arctan2(y, x), u_range)[2:]:
        radial = x * np.cos(u) + y * np.sin(u)
        for v in _turning(np.arctan2(z, radial), v_range)[2:]:
            yield u, v, float(origin + (major + minor * np.cos(v)) * radial + minor * np.sin(v) * z)


def _reach(column: FloatArray, radii: _Pair, u_range: _Pair, v_range: _Pair) -> _Pair:
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


def _turning(angle: float, ends: _Pair) -> list[float]:
    """Ends of a range, and what lies in it of an angle and those any number of half turns off, where a wave turns."""
    first = np.ceil((ends[0] - angle) / np.pi)
    return [*ends, *(angle + np.pi * np.arange(first, (ends[1] - angle) // np.pi + 1.0)).tolist()]


__all__ = ["tight_bounds"]
