"""The surface of an OpenCASCADE face, and its edges in the surface's parameters.

Place in the flow: :mod:`.solids` asks for every face of a solid. Curves in parameters are read when one is asked for,
all of a group of faces together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepTools import BRepTools
from OCP.TopAbs import TopAbs_Orientation

from ...arrays import FloatArray
from ...brep import GainedTip
from ..geometry.convert import distances_from, read_curves_2d
from ..geometry.curves import EdgeCurve
from ..geometry.edge_on_face import EdgeOnFace
from ..geometry.face_surface import FaceSurface
from ..geometry.parametric import Parametric, Reparametrised
from ..geometry.surfaces import Geometry
from ..shapes import surface_range

_INFINITE = 1e100
"""Bounds of a surface's parameters beyond which OpenCASCADE means that there are none."""


class _Border(NamedTuple):
    """An edge of a face, its curve in space, and the periods and the box of the face's parameters."""

    edge: Any
    face: Any
    curve: EdgeCurve
    periods: Sequence[float | None]
    box: FloatArray


class ParameterCurves:
    """Edges' curves in the parameters of some faces: where one is asked for, all are read, at hardly more cost."""

    def __init__(self) -> None:
        self._borders: list[_Border] = []

    def add(self, border: _Border) -> Callable[[], tuple[Parametric | None, FloatArray]]:
        """What reads the border's curve (None: not known) and its shift (2,) into the face's branch."""
        self._borders.append(border)
        return partial(self._at, len(self._borders) - 1)

    def _at(self, number: int) -> tuple[Parametric | None, FloatArray]:
        return self._read[number]

    @cached_property
    def _read(self) -> list[tuple[Parametric | None, FloatArray]]:
        found = [BRep_Tool.CurveOnSurface_s(border.edge, border.face, 0.0, 1.0) for border in self._borders]
        each = iter(read_curves_2d([curve for curve in found if curve is not None]))
        read = []
        for border, curve in zip(self._borders, found, strict=True):
            known = None if curve is None else _in_range(next(each), border.curve, border.edge, border.face)
            read.append((known, _into_branch(known, border.curve, border.periods, border.box)))
        return read


def read_face_surface(
    face: Any,
    edges: Sequence[tuple[Any, int]],
    curves: Sequence[EdgeCurve],
    *,
    geometry: Geometry,
    beside: ParameterCurves,
    tips: tuple[GainedTip, ...] = (),
) -> FaceSurface:
    """The surface of a face, with the curves of its edges in its parameters.

    Parameters
    ----------
    face : TopoDS_Face
    edges : sequence of (TopoDS_Edge, int)
        Its edges as its wires run through them, each with its id.
    curves : sequence of EdgeCurve
        Of all edges of the solid.
    geometry : Geometry
        Of the face's surface.
    beside : ParameterCurves
        What its edges' curves in the parameters are read together with.
    tips : tuple of GainedTip
        That the face got.
    """
    surface = BRep_Tool.Surface_s(face)
    u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
    limits = np.array(surface.Bounds()).reshape(2, 2).T.copy()
    limits[np.abs(limits) > _INFINITE] *= np.inf
    for j, period in enumerate(geometry.periods):
        if period is not None:
            limits[:, j] = (-np.inf, np.inf)
    box = np.array([[u0, v0], [u1, v1]])
    on_face = {
        number: EdgeOnFace(
            curve=curves[number],
            read=beside.add(_Border(edge, face, curves[number], geometry.periods, box)),
        )
        for edge, number in edges
    }
    outward = -1.0 if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1.0
    return FaceSurface(
        geometry=geometry,
        outward=outward,
        box=box,
        limits=limits,
        curves=on_face,
        second_opinion=distances_from(surface, box),
        tips=tips,
    )


def _in_range(known: Parametric, curve: EdgeCurve, edge: Any, face: Any) -> Parametric:
    """The parameter curve in the parameter of the space curve; dividing may leave them a period apart."""
    first, last = surface_range(edge, face)
    width = curve.last - curve.first
    if max(abs(first - curve.first), abs(last - curve.last)) <= 1e-9 * width:
        return known
    rate = (last - first) / width
    return Reparametrised(curve=known, offset=first - rate * curve.first, rate=rate)


def _into_branch(known: Any, curve: EdgeCurve, periods: Sequence[float | None], box: FloatArray) -> FloatArray:
    """Shift (2,) that brings an edge's parameter curve into the box of its face.

    OpenCASCADE leaves the curve of a divided face a period off where the edge crossed the seam.
    """
    shift = np.zeros(2)
    if known is not None and any(period is not None for period in periods):
        middle = known.derivatives(np.array([(curve.first + curve.last) / 2.0]))[0][0].tolist()
        for j, (low, high) in enumerate(box.T.tolist()):
            period = periods[j]
            if period is not None:
                shift[j] = -period * round((middle[j] - 0.5 * (low + high)) / period)
    return shift
