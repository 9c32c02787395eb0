"""Planes through the middle of round faces: what has no re-entrant edge and still no sweep is parted there.

Place in the flow: candidates of :mod:`.cutters`. A ball becomes eight cells by three planes through its centre, a cone
four by two planes through its axis; each has corners of three edges, and a block of hexahedra at every one of them.
The seams and poles of the faces, where their parameters end, lie on these planes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere
from OCP.gp import gp_Ax3, gp_Dir, gp_Pln, gp_Pnt

from ...arrays import FloatArray
from ...brep import Face, Solid
from ..shapes import shapes_of

SAME = 1e-6
"""Distance, as a share of the cell's size, up to which two places are one."""

AXIS_PRICE = 2.0
"""Price of planes through the axis of a hole: a cell in the way may become four of them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Cutter:
    """Faces that part a cell.

    Attributes
    ----------
    reason : str
        What a note says of it.
    tools : tuple of TopoDS_Face
    weight : float
        Length of the edges in the way that it goes through.
    price : float
        What it costs beside others that do as much.
    leads : bool
        It keeps features apart: its pieces are gone on with, even though more cells are in the way at first.
    everywhere : bool
        It parts all other cells that are in the way with this one.
    kind, family : str
        As :class:`~cadsweep.brep.Cut` has them.
    """

    reason: str
    tools: tuple[Any, ...]
    weight: float
    price: float = 0.0
    leads: bool = False
    everywhere: bool = False
    kind: str = "planes"
    family: str = ""


def plane_tool(solid: Solid, normal: FloatArray, place: FloatArray) -> Any:
    """A plane face through a place, larger than the solid."""
    center, reach = solid.vertices.mean(axis=0), 1.5 * solid.size
    foot = center - (normal @ (center - place)) * normal
    plane = gp_Pln(gp_Pnt(*map(float, foot)), gp_Dir(*map(float, normal)))
    return BRepBuilderAPI_MakeFace(plane, -reach, reach, -reach, reach).Face()


def rectangle_tool(
    place: FloatArray, normal: FloatArray, x: FloatArray, along: tuple[float, float], across: tuple[float, float]
) -> Any:  # fmt: skip
    """A plane face from one end to the other along `x`, and along what is square to it and the normal."""
    plane = gp_Pln(gp_Ax3(gp_Pnt(*map(float, place)), gp_Dir(*map(float, normal)), gp_Dir(*map(float, x))))
    return BRepBuilderAPI_MakeFace(plane, *along, *across).Face()


def through_centers(solid: Solid) -> list[Cutter]:
    """Three planes through the centre of every sphere, two through the axis of every cone that ends in its point."""
    return list(_cutters(solid, pointed=True))


def through_axes(solid: Solid) -> list[Cutter]:
    """Two planes through the axis of every other cone and of every cylinder."""
    return list(_cutters(solid, pointed=False))


def _cutters(solid: Solid, *, pointed: bool) -> Iterator[Cutter]:
    holder = shapes_of(solid)
    planes = [face for face in solid.faces if face.kind == "plane"]
    taken: list[FloatArray] = []
    for face in sorted(solid.faces, key=lambda face: -face.area):
        frame = _frame(holder.faces[face.id], solid.size, pointed=pointed)
        if frame is None:
            continue
        place, normals = frame
        # Cylinders of one axis are cut by the same planes.
        key = np.concatenate([place - (normals[-1] @ place) * normals[-1] if not pointed else place, normals[-1]])
        if any(np.abs(key - other).max() < SAME * max(1.0, solid.size) for other in taken):
            continue
        taken.append(key)
        chosen = normals if len(normals) == 3 and pointed and face.kind == "sphere" else normals[:2]
        normals = [n for n in chosen if not _is_face(planes, n, place, solid.size)]
        if normals:
            yield Cutter(
                reason=f"planes through the {'centre' if len(chosen) == 3 else 'axis'} of {face.label()}",
                tools=tuple(plane_tool(solid, normal, place) for normal in normals),
                weight=float(np.sqrt(face.area)),
                price=0.0 if pointed else AXIS_PRICE,
                everywhere=True,
            )


def _frame(shape: Any, size: float, *, pointed: bool) -> tuple[FloatArray, Sequence[FloatArray]] | None:
    """A point on a face's axis and its three directions, the axis last; None where it is none that is asked for."""
    adaptor = BRepAdaptor_Surface(shape)
    kind = adaptor.GetType()
    if kind == GeomAbs_Plane:
        return None
    position: gp_Ax3
    if kind == GeomAbs_Sphere and pointed:
        position = adaptor.Sphere().Position()
    elif kind == GeomAbs_Cone:
        cone = adaptor.Cone()
        apex = -cone.RefRadius() / np.sin(cone.SemiAngle())
        ends = np.array([adaptor.FirstVParameter(), adaptor.LastVParameter()])
        if bool(np.abs(ends - apex).min() < SAME * size) != pointed:
            return None
        position = cone.Position()
    elif kind == GeomAbs_Cylinder and not pointed:
        position = adaptor.Cylinder().Position()
    else:
        return None
    place, across, along, axis = (
        np.array([thing.X(), thing.Y(), thing.Z()])
        for thing in (position.Location(), position.YDirection(), position.XDirection(), position.Direction())
    )
    return place, [across, along, axis]


def _is_face(planes: Sequence[Face], normal: FloatArray, place: FloatArray, size: float) -> bool:
    """Whether a plane is that of a face."""
    return any(
        abs(abs(float(face.normal @ normal)) - 1.0) < SAME and abs(float(normal @ (face.center - place))) < SAME * size
        for face in planes
    )
