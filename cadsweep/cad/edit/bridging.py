"""Tips of faces bridged: where two edges of a face meet at an angle of nearly nothing, it ends in a short edge.

Place in the flow: called by the pipeline for every solid, before it is meshed.

A chamfer that runs out, a cylinder tangent to a plane, a circle that touches the edge of its face: what lies between
is a face whose angle tends to zero, and so do those of quads in it. Where its edges are a given length apart, a short
edge ab joins them; what lies beyond goes to the neighbour across the flatter of the two::

    V _______________________          V _____b_________________
      ``--..__     face                       |     face
              ``--..__           ->           a`--..__
         neighbour    ``                 neighbour    ``

The mesh is off the model there by that length at most, and says so.

Method: OpenCASCADE's splitter divides the face along the short edge; the neighbour then gets a loop around the tip, and
its new edges a tolerance of their distance to its surface.

Not handled: faces that are narrow all along, tips on the seam of a closed face, parts of several solids.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from math import cos, pi
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_MakeEdge
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.BRepTools import BRepTools_WireExplorer
from OCP.GCE2d import GCE2d_MakeSegment
from OCP.gp import gp_Pnt, gp_Pnt2d
from OCP.Precision import Precision
from OCP.ShapeFix import ShapeFix_Edge, ShapeFix_Wire
from OCP.TopoDS import TopoDS_Wire
from scipy.optimize import brentq

from ...arrays import FloatArray
from ...brep import Face, Part, Solid, Surface
from ...errors import CadError
from ..extract.shared import PartGeometry
from ..geometry.face_surface import FaceSurface
from ..heal.validate import faults
from ..shapes import (
    EDGE,
    FACE,
    SOLID,
    VERTEX,
    WIRE,
    SolidShape,
    children,
    compound,
    index_map,
    shapes_of,
    subshapes,
    typed,
)
from .corners import SHARP
from .notes import TIPS_NOTE
from .splitting import extracted, in_order, split

log = logging.getLogger(__name__)

_FLATTEST = cos(pi / 3)
"""Least cosine between the normals of a tip's face and of the neighbour that gets it: its quads bend by this angle."""
_ONE_PLANE = 1.0 - 1e-9
"""Cosine above which both are in one plane: what only divides one is merged or not followed, and does better so."""
_WIDEST = 2.0
"""How far the neighbour of a tip may be off its new edges, over the length: less, as it is no steeper than that."""
_MOST = 0.45
"""Greatest share of either edge that may be bridged: the face goes on, and another tip may be at its other end."""
_MOST_APART = 16
"""Tips up to which each is tried by itself where all at once cannot be had; one takes tenths of a second."""
_SAMPLES = 65
"""Places along each edge at which its distance to the other is looked at."""


@dataclass(frozen=True, eq=False)
class Tip:
    """A corner of a face that is bridged.

    Attributes
    ----------
    face, neighbour : int
        Its face, and the one that gets it.
    corner : int
        Its vertex.
    ends : (int, float), (int, float)
        The edges that meet at the corner, each with the place on it where the short edge ends, in fractions of length.
    """

    face: int
    neighbour: int
    corner: int
    ends: tuple[tuple[int, float], tuple[int, float]]


def bridge_tips(part: Part, length: float) -> Part:
    """Bridge the tips of a part of one solid.

    Parameters
    ----------
    part : Part
    length : float
        How far the edges of a tip are apart where it is bridged, model units.

    Returns
    -------
    Part
        The same solid, its faces under the ids that they had; the part itself where it has no tips, or OpenCASCADE
        can bridge none.
    """
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        return part
    (solid,) = part.solids
    tips = find_tips(solid, length / part.scale)
    if not tips:
        return part
    bridged = _bridged_if_sound(solid, tips, length / part.scale)
    if bridged is None and len(tips) <= _MOST_APART:
        tips = [tip for tip in tips if _bridged_if_sound(solid, [tip], length / part.scale) is not None]
        bridged = _bridged_if_sound(solid, tips, length / part.scale) if tips else None
    if bridged is None:
        return part
    faces = ", ".join(solid.faces[f].label() for f in dict.fromkeys(tip.face for tip in tips[:2]))
    note = (
        f"{TIPS_NOTE}: {len(tips)} sharp corners end in edges of {length:.3g}, by which the mesh may be off the CAD "
        f"there, as on {faces}"
    )
    return replace(part, solids=(bridged,), notes=(*part.notes, note))


def _bridged_if_sound(solid: Solid, tips: Sequence[Tip], length: float) -> Solid | None:
    """The solid with its tips bridged; None where OpenCASCADE cannot do that."""
    try:
        return _bridged(solid, tips, length)
    except (CadError, ValueError, RuntimeError) as error:
        log.info("%d tips cannot be bridged: %s", len(tips), error)
        return None


def find_tips(solid: Solid, length: float) -> list[Tip]:
    """Corners of faces whose edges meet at next to no angle and are `length` apart, working units, before they end."""
    found = []
    for face in solid.faces:
        for loop in face.loops:
            for j, angle in enumerate(loop.angles):
                if angle < SHARP and len(loop.edges) > 1:
                    tip = _tip(solid, face, loop.directed[j - 1], loop.directed[j], length)
                    if tip is not None:
                        found.append(tip)
    return found


def _tip(solid: Solid, face: Face, before: tuple[int, bool], after: tuple[int, bool], length: float) -> Tip | None:
    """The corner of a face between two directed edges, where it can be bridged."""
    if before[0] == after[0]:
        return None
    legs = (before[0], not before[1]), after

    def along(away: FloatArray) -> list[FloatArray]:
        shares = [away / solid.edges[edge].length for edge, _ in legs]
        return [share if forward else 1.0 - share for share, (_, forward) in zip(shares, legs, strict=True)]

    def apart(away: FloatArray) -> FloatArray:
        first, second = (solid.edges[e].curve.evaluate(f) for (e, _), f in zip(legs, along(away), strict=True))
        return np.linalg.norm(first - second, axis=1)

    away = np.linspace(0.0, _MOST, _SAMPLES) * min(solid.edges[edge].length for edge, _ in legs)
    wide = np.flatnonzero(apart(away) >= length)
    if not len(wide):
        return None
    at = brentq(lambda x: apart(np.array([x]))[0] - length, away[wide[0] - 1], away[wide[0]])
    ends = [(edge, float(f[0])) for (edge, _), f in zip(legs, along(np.array([at])), strict=True)]
    middle = np.mean([solid.edges[edge].curve.evaluate(np.array([f])) for edge, f in ends], axis=0)
    own = face.surface.normals(face.surface.project(middle))[0]
    beside = {other for edge, _ in legs for other in solid.edges[edge].faces} - {face.id}
    surfaces = {other: solid.faces[other].surface for other in beside}
    flat = {other: float(own @ of.normals(of.project(middle))[0]) for other, of in surfaces.items()}
    neighbour = max(flat, key=lambda other: flat[other], default=-1)
    if neighbour < 0 or not _FLATTEST <= flat[neighbour] <= _ONE_PLANE:
        return None
    return Tip(face.id, neighbour, solid.first_vertex(after), (ends[0], ends[1]))


def _bridged(solid: Solid, tips: Sequence[Tip], length: float) -> Solid:
    """The solid with its tips divided off and given to their neighbours.

    Raises
    ------
    CadError
        OpenCASCADE divides more or less than that, or the solid is not sound.
    """
    holder = _copied(shapes_of(solid))
    _, faces, traced = split(holder, [_short_edge(solid, holder, tip) for tip in tips])
    for tip in tips:
        off = [piece for piece in faces[tip.face] if _touches(piece, solid.vertices[tip.corner])]
        if len(off) != 1 or len(faces[tip.face]) == 1:
            raise CadError(f"the tip of {solid.faces[tip.face].label()} cannot be divided off")
        faces[tip.face].remove(off[0])
        beside = [j for j, piece in enumerate(faces[tip.neighbour]) if _shared(piece, off[0])]
        if len(beside) != 1:
            raise CadError(f"the tip of {solid.faces[tip.face].label()} has no one neighbour")
        grown = _grown(faces[tip.neighbour][beside[0]], off[0], solid.faces[tip.neighbour].surface)
        faces[tip.neighbour][beside[0]] = grown
    if any(len(pieces) != 1 for pieces in faces):
        raise CadError("faces were divided elsewhere, too")
    shape = in_order(faces)
    damage = faults(shape)
    if damage:
        raise CadError(damage[0])
    traced.faces = faces
    read = extracted(solid, shape, traced, shared=PartGeometry(shape, closed=_WIDEST * length))
    # What the tips' neighbours are off their new edges says nothing of the model: all that was measured on it stays.
    widest = max((edge.gap for edge in solid.edges), default=0.0)
    return replace(
        read,
        faces=tuple(_with_tips(solid, face, [tip for tip in tips if tip.neighbour == face.id]) for face in read.faces),
        edges=tuple(replace(edge, gap=min(edge.gap, widest)) for edge in read.edges),
        tolerance=solid.tolerance,
        volume=solid.volume,
    )


@dataclass(frozen=True, eq=False)
class _TippedSurface(FaceSurface):
    """A surface, and those of tips that its face got: places within a radius of a corner may lie on either.

    Attributes
    ----------
    tips : tuple of (Surface, (3,) float64, float)
        Surface, corner and radius of each.
    """

    tips: tuple[tuple[Surface, FloatArray, float], ...] = ()

    def distance(self, points: FloatArray, *, close: float = np.inf) -> FloatArray:
        """Distances (m,) of `points` (m, 3) from the nearest of the surfaces."""
        found = super().distance(points, close=close)
        for surface, corner, radius in self.tips:
            near = np.flatnonzero(np.linalg.norm(points - corner, axis=1) <= radius)
            if len(near):
                found[near] = np.minimum(found[near], surface.distance(points[near], close=close))
        return found


def _with_tips(solid: Solid, face: Face, tips: Sequence[Tip]) -> Face:
    """A face whose surface knows of the tips that it got."""
    if not tips or not isinstance(face.surface, FaceSurface):
        return face
    own = {field.name: getattr(face.surface, field.name) for field in fields(FaceSurface)}
    beside = []
    for tip in tips:
        corner = solid.vertices[tip.corner]
        ends = np.concatenate([solid.edges[e].curve.evaluate(np.array([f])) for e, f in tip.ends])
        radius = 1.01 * float(np.linalg.norm(ends - corner, axis=1).max())
        beside.append((solid.faces[tip.face].surface, corner, radius))
    return replace(face, surface=_TippedSurface(**own, tips=tuple(beside)), bridged=True)


def _copied(holder: SolidShape) -> SolidShape:
    """The same shapes once more: what is mended on some of them stays theirs."""
    copy = BRepBuilderAPI_Copy(holder.shape)

    def own(shapes: Sequence[Any], kind: Any) -> list[Any]:
        return [typed(copy.ModifiedShape(shape), kind) for shape in shapes]

    return SolidShape(
        shape=typed(copy.Shape(), SOLID),
        faces=own(holder.faces, FACE),
        edges=own(holder.edges, EDGE),
        vertices=own(holder.vertices, VERTEX),
    )


def _short_edge(solid: Solid, holder: SolidShape, tip: Tip) -> Any:
    """An edge across the face of a tip, straight in its parameters."""
    ends = np.concatenate([solid.edges[e].curve.evaluate(np.array([f])) for e, f in tip.ends])
    first, last = (gp_Pnt2d(*uv) for uv in solid.faces[tip.face].surface.project(ends).tolist())
    surface = BRep_Tool.Surface_s(holder.faces[tip.face])
    edge = BRepBuilderAPI_MakeEdge(GCE2d_MakeSegment(first, last).Value(), surface).Edge()
    BRepLib.BuildCurves3d_s(edge)
    return edge


def _touches(piece: Any, corner: FloatArray) -> bool:
    """Whether a face has a vertex at a place."""
    places = [(BRep_Tool.Pnt_s(vertex), BRep_Tool.Tolerance_s(vertex)) for vertex in subshapes(piece, VERTEX)]
    return any(place.Distance(gp_Pnt(*corner.tolist())) <= tolerance for place, tolerance in places)


def _shared(piece: Any, other: Any) -> list[Any]:
    """The edges that two faces share."""
    known = index_map(other, EDGE)
    return [edge for edge in subshapes(piece, EDGE) if known.Contains(edge)]


def _grown(receiver: Any, off: Any, surface: Surface) -> Any:
    """A face together with the tip of a neighbour: its loop goes around that.

    Raises
    ------
    CadError
        They share no single chain of edges.
    """
    shared = index_map(compound(_shared(receiver, off)), EDGE)
    builder, face = BRep_Builder(), typed(receiver.EmptyCopied(), FACE)
    (rim,) = children(off)
    around = _from_shared(_in_turn(rim, off), shared)
    for old in children(receiver):
        edges = _in_turn(old, receiver)
        if not any(shared.Contains(edge) for edge in edges):
            builder.Add(face, old)
            continue
        for edge in around:
            _lay(edge, face, surface)
        wire = TopoDS_Wire()
        builder.MakeWire(wire)
        for edge in [*_from_shared(edges, shared), *around]:
            builder.Add(wire, edge)
        wire.Closed(True)
        builder.Add(face, wire)
        if not BRepCheck_Analyzer(face).IsValid():  # a new edge may lie a period off the others
            ShapeFix_Wire(wire, face, Precision.Confusion_s()).FixShifted()
    return face


def _from_shared(edges: Sequence[Any], shared: Any) -> list[Any]:
    """The edges of a loop that are not shared, from the one after those that are.

    Raises
    ------
    CadError
        They are no single chain.
    """
    inside = [shared.Contains(edge) for edge in edges]
    firsts = [j for j in range(len(edges)) if inside[j - 1] and not inside[j]]
    if len(firsts) != 1:
        raise CadError("a tip and its neighbour share no single chain of edges")
    turned = [*edges[firsts[0] :], *edges[: firsts[0]]]
    return [edge for edge in turned if not shared.Contains(edge)]


def _in_turn(wire: Any, face: Any) -> list[Any]:
    """The edges of a wire, one after the other, turned as they are in its face."""
    explorer, edges = BRepTools_WireExplorer(typed(wire, WIRE), face), []
    while explorer.More():
        edges.append(explorer.Current())
        explorer.Next()
    return edges


def _lay(edge: Any, face: Any, surface: Surface) -> None:
    """Give an edge a place on a surface that it is off by some distance, which becomes its tolerance."""
    curve = BRepAdaptor_Curve(edge)
    places = [curve.Value(t) for t in np.linspace(curve.FirstParameter(), curve.LastParameter(), _SAMPLES)]
    off = float(np.max(surface.distance(np.array([place.Coord() for place in places]))))
    builder = BRep_Builder()
    builder.UpdateEdge(edge, max(1.1 * off, BRep_Tool.Tolerance_s(edge)))
    for vertex in subshapes(edge, VERTEX):
        builder.UpdateVertex(vertex, BRep_Tool.Tolerance_s(edge))
    ShapeFix_Edge().FixAddPCurve(edge, face, False, BRep_Tool.Tolerance_s(edge))


__all__ = ["bridge_tips", "find_tips"]
