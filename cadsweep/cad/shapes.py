"""Small helpers over OpenCASCADE's shapes: sub-shapes in order, casts, tolerances, writing.

Place in the flow: used by every module of ``cad`` that meets a ``TopoDS_Shape``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp, BRepGProp_Domain, BRepGProp_Face, BRepGProp_Vinert
from OCP.BRepTools import BRepTools_WireExplorer
from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_SurfaceType
from OCP.GeomAdaptor import GeomAdaptor_Surface
from OCP.gp import gp_Pnt
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS, TopoDS_Compound, TopoDS_Iterator
from OCP.TopTools import TopTools_IndexedMapOfShape

from ..arrays import BoolArray, FloatArray
from ..brep import Solid
from ..errors import CadError

SOLID = TopAbs_ShapeEnum.TopAbs_SOLID
SHELL = TopAbs_ShapeEnum.TopAbs_SHELL
FACE = TopAbs_ShapeEnum.TopAbs_FACE
WIRE = TopAbs_ShapeEnum.TopAbs_WIRE
EDGE = TopAbs_ShapeEnum.TopAbs_EDGE
VERTEX = TopAbs_ShapeEnum.TopAbs_VERTEX

_CASTS = {
    SOLID: TopoDS.Solid_s,
    SHELL: TopoDS.Shell_s,
    FACE: TopoDS.Face_s,
    WIRE: TopoDS.Wire_s,
    EDGE: TopoDS.Edge_s,
    VERTEX: TopoDS.Vertex_s,
}


_PLAIN = (GeomAbs_SurfaceType.GeomAbs_Plane, GeomAbs_SurfaceType.GeomAbs_Cylinder)
_PLAIN_CURVES = (GeomAbs_CurveType.GeomAbs_Line, GeomAbs_CurveType.GeomAbs_Circle)


def typed(shape: Any, kind: Any) -> Any:
    """The shape as its own class; ``Moved`` and the like return a plain ``TopoDS_Shape``."""
    return _CASTS[kind](shape)


def index_map(shape: Any, kind: Any) -> Any:
    """An OpenCASCADE map of the distinct sub-shapes of `kind`, numbered from 1; edges without degenerate ones."""
    found = _every(shape, kind)
    if kind != EDGE:
        return found
    edges = mapped(found, EDGE)
    kept = [edge for edge in edges if not BRep_Tool.Degenerated_s(edge)]
    if len(kept) == len(edges):
        return found
    of_kept = TopTools_IndexedMapOfShape()
    for edge in kept:
        of_kept.Add(edge)
    return of_kept


def _every(shape: Any, kind: Any) -> Any:
    found = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(shape, kind, found)
    return found


def mapped(found: Any, kind: Any) -> list[Any]:
    """The shapes of a map from :func:`index_map`, in its order."""
    cast = _CASTS[kind]
    return [cast(found.FindKey(j)) for j in range(1, found.Extent() + 1)]


def subshapes(shape: Any, kind: Any) -> list[Any]:
    """The distinct sub-shapes of `kind`, in OpenCASCADE's order; edges without degenerate ones."""
    found = mapped(_every(shape, kind), kind)
    return [edge for edge in found if not BRep_Tool.Degenerated_s(edge)] if kind == EDGE else found


def explore(shape: Any, kind: Any) -> Iterator[Any]:
    """Every use of a sub-shape of `kind`, with the orientation it has in `shape`."""
    cast = _CASTS[kind]
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield cast(explorer.Current())
        explorer.Next()


def in_turn(wire: Any, face: Any) -> Iterator[Any]:
    """The edges of a face's wire, one after the other, each turned as it is there; not all where it does not close."""
    walk = BRepTools_WireExplorer(typed(wire, WIRE), typed(face, FACE))
    while walk.More():
        yield walk.Current()
        walk.Next()


def children(shape: Any) -> Iterator[Any]:
    """The direct sub-shapes."""
    iterator = TopoDS_Iterator(shape)
    while iterator.More():
        yield iterator.Value()
        iterator.Next()


def is_plain(shape: Any) -> bool:
    """Whether all faces of a shape are on planes and cylinders; of edges alone, whether they are lines and circles."""
    if shape.ShapeType() == EDGE:
        return BRepAdaptor_Curve(shape).GetType() in _PLAIN_CURVES
    return all(GeomAdaptor_Surface(BRep_Tool.Surface_s(face)).GetType() in _PLAIN for face in explore(shape, FACE))


def listed(shapes: Any) -> list[Any]:
    """The shapes of one of OpenCASCADE's lists; running to its end in Python costs half a millisecond."""
    each = iter(shapes)
    return [next(each) for _ in range(shapes.Extent())]


def compound(shapes: Sequence[Any]) -> Any:
    """A compound of `shapes`, in that order."""
    builder = BRep_Builder()
    out = TopoDS_Compound()
    builder.MakeCompound(out)
    for shape in shapes:
        builder.Add(out, shape)
    return out


def space_range(edge: Any) -> tuple[float, float]:
    """First and last parameter of the edge's curve in space.

    ``BRep_Tool.Range`` gives those of whatever representation comes first, maybe a parameter curve of another range.
    """
    curve = BRepAdaptor_Curve(edge)
    return curve.FirstParameter(), curve.LastParameter()


def surface_range(edge: Any, face: Any) -> tuple[float, float]:
    """First and last parameter of the edge's curve in the parameters of the face, as ``CurveOnSurface`` returns it.

    ``BRep_Tool.Range`` does not know the curve that is made for a plane on demand; it runs as the one in space does.
    """
    curve = BRepAdaptor_Curve2d(edge, face)
    return curve.FirstParameter(), curve.LastParameter()


def bounds(shape: Any) -> FloatArray:
    """Least and greatest coordinates (2, 3) of a loose box about the shape, which encloses poles of splines."""
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    if box.IsVoid():
        raise CadError("The shape is empty: it has no vertex, edge or face.")
    return np.array(box.Get()).reshape(2, 3)


def near_boxes(first: FloatArray, second: FloatArray, reach: float) -> BoolArray:
    """Which boxes (n, 2, d) come nearer than `reach` to which others (m, 2, d), (n, m)."""
    near = np.ones((len(first), len(second)), dtype=np.bool_)
    for axis in range(first.shape[2]):
        near &= first[:, None, 0, axis] <= second[None, :, 1, axis] + reach
        near &= second[None, :, 0, axis] <= first[:, None, 1, axis] + reach
    return near


FINE = 1e-6
"""Share up to which OpenCASCADE refines its integral over a face, for :func:`fine_volume`."""


Mass = tuple[float, FloatArray]
"""Volume or area, and centroid (3,)."""


def volume_and_center(shape: Any) -> Mass:
    """Volume and centroid (3,) of a solid, by OpenCASCADE."""
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    center = properties.CentreOfMass()
    return abs(float(properties.Mass())), np.array([center.X(), center.Y(), center.Z()])


def area_and_center(face: Any) -> Mass:
    """Area of a face, and its centroid (3,)."""
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    center = properties.CentreOfMass()
    return float(properties.Mass()), np.array([center.X(), center.Y(), center.Z()])


def fine_volume(shape: Any) -> float:
    """Volume of a solid to a share of :data:`FINE` of each face's, some 0.1 s where faces are curved."""
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties, FINE, False, False)
    return abs(float(properties.Mass()))


def volume_from_origin(shape: Any) -> float:
    """Volume between the faces of a solid and the origin: of pieces the same in all as of the whole, open or not."""
    origin, found = gp_Pnt(), 0.0
    for face in subshapes(shape, FACE):
        surface = BRepGProp_Face(face)
        found += BRepGProp_Vinert(surface, BRepGProp_Domain(face), origin).Mass()
    return abs(float(found))


@dataclass(frozen=True, kw_only=True, eq=False)
class SolidShape:
    """The OpenCASCADE side of a ``brep.Solid``; it is the solid's ``kernel``.

    Attributes
    ----------
    shape : TopoDS_Solid
    faces, edges, vertices : list
        In the order of their ids.
    """

    shape: Any
    faces: list[Any]
    edges: list[Any]
    vertices: list[Any]

    @cached_property
    def mass(self) -> Mass:
        """Volume and centroid, by OpenCASCADE."""
        return volume_and_center(self.shape)

    @cached_property
    def from_origin(self) -> float:
        """As by :func:`volume_from_origin`, which many cuts of one solid are compared with."""
        return volume_from_origin(self.shape)


def shapes_of(solid: Solid) -> SolidShape:
    """OpenCASCADE's side of a solid that ``cad`` has read or made."""
    holder = solid.kernel
    assert isinstance(holder, SolidShape), "it comes from OpenCASCADE"
    return holder
