"""Edges and faces too small to be meant, merged into their neighbours.

Place in the flow: after normalising, before dividing. Booleans of bodies that nearly fit and lofts
through splines leave edges and strips some thousandths of a per cent long or wide, which would force
elements of that size.

Method: ``ShapeFix_FixSmallFace`` and ``ShapeFix_Wireframe`` of OpenCASCADE. Their result is taken only where
it is one valid, closed solid of the same volume; else the shape stays as it is. OpenCASCADE knows strips between two
edges: a narrow ring, as a chamfer leaves around a hole that it just misses, is parted into these at its corners first.

A short edge without a narrow face beside it stays where all faces run along or across one direction: there it is the
height of a step, or where two outlines pass each other closely, and without it faces at different heights would share
a corner. Such parts are meshed as columns, whose outlines are laid together in the mesh alone.

A narrow slit stays, too: without its floor and ends its sides would lie on each other, and the solid would be torn.

Not handled: rings without corners, as between two circles.
"""

from __future__ import annotations

import logging
from typing import Any

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_Copy,
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Dir, gp_Pnt
from OCP.GProp import GProp_GProps
from OCP.ShapeBuild import ShapeBuild_ReShape
from OCP.ShapeFix import ShapeFix_FixSmallFace, ShapeFix_Wireframe
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp

from ...errors import CadError
from ..shapes import EDGE, FACE, SOLID, VERTEX, WIRE, compound, in_turn, index_map, subshapes, typed
from ..trial import survives
from .tracing import Traced
from .validate import check_closed, faults

_FORWARD = TopAbs_Orientation.TopAbs_FORWARD
logger = logging.getLogger(__name__)

TOLERANCE = 2e-4
"""Width of a face or length of an edge, as a share of the part's size, below which it is a sliver."""

_THINNEST = 0.02
"""The same as a share of the part's mean thickness, so that a thin sheet is not taken for a sliver."""


_PARALLEL = 1e-9
"""Angle up to which directions are the same, radians."""


def merge_slivers(traced: Traced, size: float) -> list[str]:
    """Merge sliver faces and edges in place; `size` is the part's. Returns a note where something was merged."""
    if not any(_slivers(traced.shape, TOLERANCE * size)):
        return []
    volume, area = _volume(traced.shape), _area(traced.shape)
    tolerance = min(TOLERANCE * size, _THINNEST * 2.0 * volume / area)
    short, narrow = _slivers(traced.shape, tolerance)
    if not narrow and (not short or _is_upright(traced.shape)):
        return []
    # What fails has changed tolerances in place by then: it is tried on a copy.
    copy = BRepBuilderAPI_Copy(traced.shape).Shape()
    try:
        done = survives(lambda: _merged(copy, tolerance), "merging slivers")
        if not done or not _is_as_good(_merged(copy, tolerance)[0], volume, tolerance):
            logger.info("slivers below %.3g could not be merged and stay", tolerance)
            return []
        shape, context = _merged(traced.shape, tolerance)
    except Exception as error:  # OpenCASCADE raises any of its own here; the part can do without this step.
        logger.info("OpenCASCADE failed at merging slivers (%s), and they stay", error)
        return []
    counts = len(subshapes(traced.shape, FACE)), len(subshapes(traced.shape, EDGE))
    traced.replace(subshapes(shape, SOLID)[0], context.Apply)
    n_faces = counts[0] - len(subshapes(traced.shape, FACE))
    n_edges = counts[1] - len(subshapes(traced.shape, EDGE))
    if n_edges == 0:
        return []
    return [f"slivers merged: {n_faces} faces and {n_edges} edges fewer (below {tolerance:.3g} working units)"]


def _merged(shape: Any, tolerance: float) -> tuple[Any, ShapeBuild_ReShape]:
    """The shape without its slivers, and the record of what became of its parts."""
    context = ShapeBuild_ReShape()
    for face in _slivers(shape, tolerance)[1]:
        strips = _strips(face, tolerance)
        if strips:
            context.Replace(face.Oriented(_FORWARD), compound(strips))
    shape = context.Apply(shape)
    if _slivers(shape, tolerance)[1]:
        faces = ShapeFix_FixSmallFace()
        faces.Init(shape)
        faces.SetPrecision(tolerance)
        faces.SetContext(context)
        faces.Perform()
        shape = faces.Shape()
    if _slivers(shape, tolerance)[0]:
        wires = ShapeFix_Wireframe(shape)
        wires.SetContext(context)
        wires.SetPrecision(tolerance)
        wires.SetMaxTolerance(tolerance)
        wires.ModeDropSmallEdges = True
        wires.FixSmallEdges()
        shape = wires.Shape()
    return shape, context


def _strips(face: Any, tolerance: float) -> list[Any]:
    """A plane ring parted at its corners into strips between an edge outside and one inside; empty where it is none."""
    face = typed(face.Oriented(_FORWARD), FACE)
    wires = subshapes(face, WIRE)
    if len(wires) != 2 or BRepAdaptor_Surface(face).GetType() != GeomAbs_SurfaceType.GeomAbs_Plane:
        return []
    outer, inner = (list(in_turn(wire, face)) for wire in wires)
    left = [(TopExp.LastVertex_s(edge, True), edge) for edge in inner]
    spokes: list[Any] = []
    beside: list[Any] = []
    for edge in outer:
        corner = TopExp.FirstVertex_s(edge, True)
        place = BRep_Tool.Pnt_s(corner)
        near = [j for j, (v, _) in enumerate(left) if BRep_Tool.Pnt_s(v).Distance(place) < tolerance]
        if len(near) != 1:
            return []
        vertex, other = left.pop(near[0])
        spokes.append(BRepBuilderAPI_MakeEdge(corner, vertex).Edge())
        beside.append(other)
    if left or len(outer) < 2:
        return []
    surface = BRep_Tool.Surface_s(face)
    strips = []
    for k, edge in enumerate(outer):
        wire = BRepBuilderAPI_MakeWire(edge, spokes[(k + 1) % len(outer)], beside[k], spokes[k]).Wire()
        strips.append(BRepBuilderAPI_MakeFace(surface, wire, True).Face())
    return strips


def _slivers(shape: Any, tolerance: float) -> tuple[list[Any], list[Any]]:
    """Short edges and narrow faces."""
    short = [edge for edge in subshapes(shape, EDGE) if _is_short(edge, tolerance)]
    narrow = []
    for face in subshapes(shape, FACE):
        edges = subshapes(face, EDGE)
        # A narrow face has short ends, is pinched between two or three edges, or is a ring.
        if (
            len(edges) <= 3
            or len(subshapes(face, WIRE)) > 1
            or any(edge.IsSame(other) for edge in edges for other in short)
        ):
            perimeter = sum(_length(edge) for edge in edges)
            if _area(face) < 0.5 * tolerance * perimeter:
                narrow.append(face)
    return short, narrow


def _is_upright(shape: Any) -> bool:
    """Whether all faces are planes and cylinders along one direction, or planes across it."""
    normals: list[gp_Dir] = []
    axes: list[gp_Dir] = []
    for face in subshapes(shape, FACE):
        surface = BRepAdaptor_Surface(face)
        if surface.GetType() == GeomAbs_SurfaceType.GeomAbs_Plane:
            found, own = normals, surface.Plane().Axis().Direction()
        elif surface.GetType() == GeomAbs_SurfaceType.GeomAbs_Cylinder:
            found, own = axes, surface.Cylinder().Axis().Direction()
        else:
            return False
        if not any(own.IsParallel(other, _PARALLEL) for other in found):
            found.append(own)
    return any(
        all(axis.IsParallel(up, _PARALLEL) for axis in axes)
        and all(n.IsParallel(up, _PARALLEL) or n.IsNormal(up, _PARALLEL) for n in normals)
        for up in [*axes[:1], *normals]
    )


def _is_as_good(shape: Any, volume: float, tolerance: float) -> bool:
    solids = subshapes(shape, SOLID)
    if len(solids) != 1 or faults(solids[0]):
        return False
    try:
        check_closed(solids[0])
    except CadError:
        return False
    return abs(_volume(solids[0]) - volume) < 1e-3 * volume and not _is_torn(solids[0], tolerance)


def _is_torn(solid: Any, tolerance: float) -> bool:
    """Whether two edges between the same vertices lie on each other, as the rims of a slit that was closed do."""
    vertices = index_map(solid, VERTEX)
    middles: dict[frozenset[int], list[gp_Pnt]] = {}
    for edge in subshapes(solid, EDGE):
        if BRep_Tool.Degenerated_s(edge):
            continue
        curve = BRepAdaptor_Curve(edge)
        middle = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
        ends = frozenset(vertices.FindIndex(vertex) for vertex in subshapes(edge, VERTEX))
        known = middles.setdefault(ends, [])
        if any(middle.Distance(other) < tolerance for other in known):
            return True
        known.append(middle)
    return False


def _is_short(edge: Any, tolerance: float) -> bool:
    """Whether an edge is shorter than a tolerance; most are told by their ends, which lie farther apart."""
    curve = BRepAdaptor_Curve(edge)
    chord = curve.Value(curve.FirstParameter()).Distance(curve.Value(curve.LastParameter()))
    return chord < 2.0 * tolerance and _length(edge) < tolerance


def _length(edge: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.LinearProperties_s(edge, properties)
    return float(properties.Mass())


def _area(shape: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties)
    return float(properties.Mass())


def _volume(shape: Any) -> float:
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return abs(float(properties.Mass()))
