"""Faces that are pieces of one surface, of whatever kind: found, grouped, and given one surface in common.

Place in the flow: for :mod:`.merging`. An imprint, a sketch's outline or a boolean operation without
clean-up leaves such pieces; a file keeps a copy of the surface for each.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import pi
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location

from ...arrays import FloatArray
from ...brep import Edge, Solid
from ..shapes import EDGE, FACE, explore, surface_range, typed
from .face_surface import FaceSurface
from .surfaces import ELEMENTARY

_SMOOTH = 1e-6
"""Radians from pi within which two faces count as tangent."""
_NEAR = 1e-7
"""Distance, as a share of the part's size, within which two surfaces count as one."""
_N_SAMPLES = 7
"""Places in each direction: surfaces of degree 6 that agree there are the same."""


def dividing_edges(solid: Solid) -> list[int]:
    """Ids of the edges on both sides of which lies one surface, those that divide a closed face among them."""
    known: dict[tuple[int, int], bool] = {}

    def is_one(edge: Edge) -> bool:
        f, g = edge.faces
        if abs(edge.dihedral - pi) > _SMOOTH:
            return False
        if (f, g) not in known:
            same = solid.faces[f].key == solid.faces[g].key or is_same_surface(solid, f, g)
            known[f, g] = known[g, f] = same
        return known[f, g]

    return [edge.id for edge in solid.edges if is_one(edge)]


def cutting_edges(solid: Solid, dividing: Sequence[int]) -> set[int]:
    """Those of the edges that were made by dividing a closed face, and those that prolong them."""
    at_vertex: dict[int, list[int]] = {}
    for e in dividing:
        for v in (solid.edges[e].start, solid.edges[e].end):
            at_vertex.setdefault(v, []).append(e)
    cuts = [e for e in dividing if len({solid.faces[f].key for f in solid.edges[e].faces}) == 1]
    found = set(cuts)
    for cut in cuts:
        for v in (solid.edges[cut].start, solid.edges[cut].end):
            for e in at_vertex[v]:
                straight = _direction(solid.edges[cut], v) @ _direction(solid.edges[e], v) < -1.0 + _SMOOTH
                if e not in found and straight:
                    found.add(e)
                    cuts.append(e)
    return found


def prolonged_kinks(solid: Solid, dividing: Collection[int]) -> set[int]:
    """Those of the edges at both of whose ends three others meet, none of which divides a surface.

    Two of the three go on along the faces beside the edge, so the third, a true edge, goes on from it.
    """
    at_vertex: dict[int, list[int]] = {}
    for edge in solid.edges:
        for v in (edge.start, edge.end):
            at_vertex.setdefault(v, []).append(edge.id)

    def goes_on(e: int, v: int) -> bool:
        others = [other for other in at_vertex[v] if other != e]
        return len(others) == 3 and not any(other in dividing for other in others)

    return {e for e in dividing if goes_on(e, solid.edges[e].start) and goes_on(e, solid.edges[e].end)}


def is_elementary(solid: Solid, face: int) -> bool:
    """Whether a face's surface has a closed form: plane, cylinder, cone, sphere or torus."""
    return isinstance(getattr(solid.faces[face].surface, "geometry", None), ELEMENTARY)


def _direction(edge: Edge, vertex: int) -> FloatArray:
    """Unit tangent that leads from a vertex of an edge into it."""
    out: FloatArray = edge.tangents[0] if edge.start == vertex else -edge.tangents[1]
    return out


def group_faces(solid: Solid, edges: Sequence[int]) -> list[tuple[int, ...]]:
    """Groups of faces that hang together across the given edges and were two faces or more in the model."""
    beside: dict[int, set[int]] = {}
    for e in edges:
        f, g = solid.edges[e].faces
        beside.setdefault(f, set()).add(g)
        beside.setdefault(g, set()).add(f)
    groups, seen = [], set[int]()
    for first in sorted(beside):
        if first not in seen:
            members = [first]
            seen.add(first)
            for f in members:
                new = sorted(beside[f] - seen)
                seen.update(new)
                members += new
            if len({solid.faces[f].key for f in members}) > 1:
                groups.append(tuple(sorted(members)))
    return groups


def is_same_surface(solid: Solid, f: int, g: int) -> bool:
    """Whether two faces lie on one surface: by distance where it is known in closed form, else by parameters."""
    one, other = solid.faces[f].surface, solid.faces[g].surface
    if not (isinstance(one, FaceSurface) and isinstance(other, FaceSurface)):
        return False
    if type(one.geometry) is not type(other.geometry):
        return False
    uv = _samples(other)
    points = other.evaluate(uv)
    if is_elementary(solid, f):
        at = one.project(points)
    elif ((uv < one.limits[0]) | (uv > one.limits[1])).any():
        return False
    else:
        at = uv
    return bool(np.max(np.linalg.norm(one.evaluate(at) - points, axis=1)) <= _NEAR * solid.size)


def _samples(surface: FaceSurface) -> FloatArray:
    shares = np.linspace(0.0, 1.0, _N_SAMPLES)
    grid = np.stack(np.meshgrid(shares, shares, indexing="ij"), axis=-1).reshape(-1, 2)
    out: FloatArray = surface.box[0] + grid * (surface.box[1] - surface.box[0])
    return out


def share_surface(faces: Sequence[Any]) -> None:
    """Put faces on the surface of the first of them, in place; the parameters of all must be the same."""
    place = TopLoc_Location()
    surface = BRep_Tool.Surface_s(faces[0], place)
    builder = BRep_Builder()
    uses: list[tuple[Any, list[Any]]] = []
    for shape in faces:
        face = typed(shape.Oriented(TopAbs_Orientation.TopAbs_FORWARD), FACE)
        for edge in explore(face, EDGE):
            curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0)
            if curve is not None:
                known = next((own for other, own in uses if other.IsSame(edge)), None)
                if known is None:
                    known = []
                    uses.append((edge, known))
                known.append((edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED, curve.Copy(), face))
    for edge, known in uses:
        first, last = surface_range(edge, known[0][2])
        curves = [curve for _, curve, _ in sorted(known, key=lambda use: use[0])]
        middles = [curve.Value((first + last) / 2) for curve in curves]
        if len(curves) == 2 and middles[0].Distance(middles[1]) < 1e-3 * _period(surface):
            curves = curves[:1]  # not on a seam, where the curve of the forward use comes first
        builder.UpdateEdge(edge, *curves, surface, place, BRep_Tool.Tolerance_s(edge))
        builder.Range(edge, surface, place, first, last)
    for shape in faces[1:]:
        builder.UpdateFace(typed(shape, FACE), surface, place, BRep_Tool.Tolerance_s(shape))


def _period(surface: Any) -> float:
    """Least width of the surface's parameters, to know the two sides of a seam by."""
    u0, u1, v0, v1 = surface.Bounds()
    return float(min(u1 - u0, v1 - v0))
