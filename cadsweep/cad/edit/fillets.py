"""Rounded cap edges divided where their normal is half way between cap and side.

Place in the flow: called by the pipeline for a part whose best sweep has a cap that runs tangent into a rounding.
Wherever such a face belongs as a whole, to the cap or to the sides, cap and side meet tangentially somewhere, and hexes
there are flat. Divided in the middle, the cap grows over one half and the sides over the other, and what is
turned over one hex at the rim is turned by both its neighbours.

Method: along the edges of a face the place is looked for where the outward normal stands at 45 degrees to the
cap's. On a rounding of constant radius beside a plane cap all these places lie in one plane parallel to the
cap, which is cut with the face; otherwise the two places on opposite edges are joined by a line in the
parameters. OpenCASCADE's splitter then divides the faces of the solid along the new edges.

Not handled: caps without a plane face, and hollow (concave) roundings, which no cap should grow over.
"""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import cos, pi
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAlgoAPI import BRepAlgoAPI_Section
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepLib import BRepLib
from OCP.GCE2d import GCE2d_MakeSegment
from OCP.gp import gp_Dir, gp_Pln, gp_Pnt, gp_Pnt2d

from ...arrays import FloatArray
from ...brep import Face, Part, Solid
from ..geometry.composite import join_faces
from ..shapes import EDGE, SolidShape, subshapes
from ..trial import attempted
from .axial import direction_of, find_clusters, main_normals
from .splitting import divided_part
from .turned import TANGENT, TurnedBody

_HALF_WAY = cos(pi / 4)
"""Cosine between a rounding and its cap where the rounding is divided: as steep for the cap as for the side."""
_MARGIN = 0.12
"""How far beyond half way, in cosines, the normals of a face reach on both sides if it is to be divided."""
_SAMPLES = 33
"""Places along an edge: a rounding of a quarter turn is crossed within 3 degrees."""
_LEVEL = 1e-6
"""Greatest difference in height, as a share of the part's size, between places in one plane."""


def divide_roundings(part: Part, caps: Sequence[tuple[int, Sequence[int]]]) -> Part | None:
    """Divide the faces that round the edges of caps.

    Parameters
    ----------
    part : Part
        One solid.
    caps : sequence of (int, sequence of int)
        For every cap a plane face, and the faces that may round its edges.

    Returns
    -------
    Part
        The same solid. A divided face keeps id, name and key for the half at the sides. The half at the cap becomes a
        part of the cap's plane; where it has a name of its own, a patch of it.
    None
        Where no face is to be divided, or OpenCASCADE fails at it.
    """
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        return None
    solid, holder = part.solids[0], part.solids[0].kernel
    cuts: list[Any] = []
    n_divided = 0
    for plane, near in caps:
        for f in near:
            lines = _dividing_edges(solid, holder, solid.faces[f], solid.faces[plane].normal)
            cuts += lines
            n_divided += bool(lines)
    found = divided_part(part, cuts, [solid.faces[plane].normal for plane, _ in caps])
    if found is None:
        return None
    divided = found.solids[0]
    for plane, _ in caps:
        divided = _grown(divided, plane)
    note = f"faces that round the edge of a cap divided half way between cap and side: {n_divided}"
    return replace(part, solids=(divided,), notes=(*part.notes, note))


def divide_corners(part: Part) -> Part | None:
    """Divide roundings of a part that is to be cut: those all around a block, which no cell can have but as the edge of
    a cap, and those about the axis of a turned body, which are parted from it as rings.

    Parameters
    ----------
    part : Part
        One solid.

    Returns
    -------
    Part
        The same solid. A divided face keeps id, name and key for one half; the other has both names and comes last.
    None
        Where there is none, or OpenCASCADE fails at it.
    """
    if len(part.solids) != 1 or not isinstance(part.solids[0].kernel, SolidShape):
        return None
    solid, holder = part.solids[0], part.solids[0].kernel
    lines = [
        edge
        for f, directions in (*_around_block(solid), *_around_body(solid))
        for direction in directions
        for edge in _dividing_edges(solid, holder, solid.faces[f], direction)
    ]
    divided = divided_part(part, lines)
    note = "faces that round a block divided half way between its sides"
    return None if divided is None else replace(divided, notes=(*part.notes, note))


def _around_block(solid: Solid) -> Iterator[tuple[int, tuple[FloatArray, FloatArray]]]:
    """The roundings all around a block, each with the directions of the sides that it may part."""
    axes = [direction_of(solid, face) for face in solid.faces]
    normals = main_normals(solid, axes)
    if len(normals) < 3:
        return
    for cluster in find_clusters(solid, axes, normals, TANGENT):
        for way in cluster.ways if cluster.rounded else ():
            yield from ((f, (normals[way], -normals[way])) for f in cluster.rounded)


def _around_body(solid: Solid) -> Iterator[tuple[int, tuple[FloatArray, FloatArray]]]:
    """The roundings of a turned body that strips or spokes part, each with both directions of the axis."""
    body = TurnedBody.read(solid, TANGENT)
    if body is not None:
        yield from ((face.id, (body.line.direction, -body.line.direction)) for face in body.rounded_faces())


def join_halves(part: Part, caps: Sequence[Sequence[int]]) -> Part | None:
    """Join the plane caps of cells to the halves of divided roundings beside them; None where there are none.

    What is joined is one cap. The solids' shapes are those of before: such a part is meshed, and not cut any further.

    Parameters
    ----------
    part : Part
    caps : sequence of sequence of int
        For every cell the faces that are to be caps.
    """
    solids = [_with_halves(solid, own) for solid, own in zip(part.solids, caps, strict=True)]
    return None if all(map(operator.is_, solids, part.solids)) else replace(part, solids=tuple(solids))


def _with_halves(solid: Solid, caps: Sequence[int]) -> Solid:
    """A cell with its caps joined to the halves beside them."""
    planes = [solid.faces[f] for f in caps if solid.faces[f].kind == "plane"]
    for plane in planes:
        # Ids change when faces are joined, surfaces do not; what was joined to another plane has no face of its own.
        now = next((face for face in solid.faces if face.surface is plane.surface), None)
        solid = _grown(solid, now.id) if now is not None and _has_half_beside(solid, now) else solid
    return solid


def _has_half_beside(solid: Solid, plane: Face) -> bool:
    """Whether a face that runs tangent into a plane one ends half way."""
    beside = _tangent_beside(solid, plane)
    return any(abs(_least_lean(face, plane.normal) - _HALF_WAY) < _LEVEL for face in beside if face.kind != "plane")


def _tangent_beside(solid: Solid, face: Face) -> Iterator[Face]:
    """The faces that a face runs tangent into."""
    for edge in map(solid.edges.__getitem__, face.edges):
        if abs(edge.dihedral - pi) <= TANGENT:
            yield solid.faces[edge.faces[0] if edge.faces[1] == face.id else edge.faces[1]]


def _least_lean(face: Face, normal: FloatArray) -> float:
    """Least cosine between a face's normals, along its edges, and a direction."""
    uv = np.concatenate([face.surface.edge_uv(e, np.linspace(0.0, 1.0, _SAMPLES)) for e in face.edges])
    return float(np.min(face.surface.normals(uv) @ normal))


def _grown(solid: Solid, plane: int) -> Solid:
    """The solid with a plane face joined to what runs tangent into it and leans less than half way."""
    normal = solid.faces[plane].normal
    group = [plane]
    for f in group:
        for face in _tangent_beside(solid, solid.faces[f]):
            if face.id not in group and _least_lean(face, normal) > _HALF_WAY - _LEVEL:
                group.append(face.id)
    joined = join_faces(solid, group, plane) if len(group) > 1 else None
    return solid if joined is None else joined


def _dividing_edges(solid: Solid, holder: SolidShape, face: Face, direction: FloatArray) -> list[Any]:
    """New edges that divide a face where its normal is half way between a direction and square to it."""
    if face.kind == "plane" or len(face.loops) != 1:
        return []
    heights, cosines, places = [], [], []
    fractions = np.linspace(0.0, 1.0, _SAMPLES)
    for e in face.edges:
        uv = face.surface.edge_uv(e, fractions)
        along = face.surface.normals(uv) @ direction
        points = face.surface.evaluate(uv)
        heights.append(points @ direction)
        cosines.append(along)
        for k in np.flatnonzero((along[1:] > _HALF_WAY) != (along[:-1] > _HALF_WAY)).tolist():
            places.append(_crossing(face, e, (float(fractions[k]), float(fractions[k + 1])), direction))
    cosine, height = np.concatenate(cosines), np.concatenate(heights)
    above = cosine > _HALF_WAY
    low, high = float(np.min(cosine)), float(np.max(cosine))
    if low > _HALF_WAY - _MARGIN or high < _HALF_WAY + _MARGIN or len(places) != 2:
        return []
    if low < -_MARGIN or np.mean(height[above]) <= np.mean(height[~above]):
        return []  # it goes round to the other cap, or is hollow
    levels = face.surface.evaluate(np.array(places)) @ direction
    if np.ptp(levels) <= _LEVEL * solid.size:
        section = BRepAlgoAPI_Section(holder.faces[face.id], _plane(direction, float(levels.mean())), False)
        section.Approximation(True)
        section.ComputePCurveOn1(True)
        done = attempted(section.Build, "finding where a rounding is half way", on=[holder.faces[face.id]])
        return subshapes(section.Shape(), EDGE) if done and section.IsDone() else []
    surface = BRep_Tool.Surface_s(holder.faces[face.id])
    first, last = (gp_Pnt2d(*map(float, uv)) for uv in places)
    edge = BRepBuilderAPI_MakeEdge(GCE2d_MakeSegment(first, last).Value(), surface).Edge()
    BRepLib.BuildCurves3d_s(edge)
    return [edge]


def _crossing(face: Face, edge: int, between: tuple[float, float], direction: FloatArray) -> FloatArray:
    """Parameters (2,) of the place on an edge where the face's normal is half way; by bisection."""

    def above(fraction: float) -> bool:
        normal = face.surface.normals(face.surface.edge_uv(edge, np.array([fraction])))[0]
        return bool(normal @ direction > _HALF_WAY)

    low, high = between
    at_low = above(low)
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if above(middle) == at_low else (low, middle)
    place: FloatArray = face.surface.edge_uv(edge, np.array([(low + high) / 2]))[0]
    return place


def _plane(normal: FloatArray, height: float) -> Any:
    return gp_Pln(gp_Pnt(*(height * normal)), gp_Dir(*normal))


__all__ = ["divide_corners", "divide_roundings", "join_halves"]
