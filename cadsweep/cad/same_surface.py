"""Faces that are pieces of one surface, of whatever kind: found, grouped, and given one surface in common.

Place in the flow: for :mod:`.merging`. An imprint, a sketch's outline or a boolean operation without
clean-up leaves such pieces; a file keeps a copy of the surface for each.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location

from ..topology import Edge, FloatArray, Solid
from .face_surface import FaceSurface
from .shapes import EDGE, FACE, explore, typed

_SMOOTH = 1e-6
"""Radians from pi within which two faces count as tangent."""
_NEAR = 1e-7
"""Distance, as a share of the part's size, within which two surfaces count as one."""
_N_SAMPLES = 7


def dividing_edges(solid: Solid) -> list[int]:
    """Ids of the edges on both sides of which lies one surface.

    Edges that were made by dividing a closed face do not count, nor does what prolongs them.
    """
    known: dict[tuple[int, int], bool] = {}

    def is_one(edge: Edge) -> bool:
        f, g = edge.faces
        if solid.faces[f].key == solid.faces[g].key or abs(edge.dihedral - pi) > _SMOOTH:
            return False
        if (f, g) not in known:
            known[f, g] = known[g, f] = is_same_surface(solid, f, g)
        return known[f, g]

    found = {edge.id for edge in solid.edges if is_one(edge)}
    cuts = [e.id for e in solid.edges if solid.faces[e.faces[0]].key == solid.faces[e.faces[1]].key]
    at_vertex: dict[int, list[int]] = {}
    for e in found:
        for v in (solid.edges[e].start, solid.edges[e].end):
            at_vertex.setdefault(v, []).append(e)
    while cuts:
        cut = solid.edges[cuts.pop()]
        for v in (cut.start, cut.end):
            for e in at_vertex.get(v, []):
                if e in found and _direction(cut, v) @ _direction(solid.edges[e], v) < -1.0 + _SMOOTH:
                    found.remove(e)
                    cuts.append(e)
    return sorted(found)


def _direction(edge: Edge, vertex: int) -> FloatArray:
    """Unit tangent that leads from a vertex of an edge into it."""
    out: FloatArray = edge.tangents[0] if edge.start == vertex else -edge.tangents[1]
    return out


def group_faces(solid: Solid, edges: Sequence[int]) -> list[tuple[int, ...]]:
    """Groups of two faces and more that hang together across the given edges."""
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
    at = one.geometry.project(points) if hasattr(one.geometry, "project") else uv
    if ((at < one.limits[0]) | (at > one.limits[1])).any():
        return False
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
    for shape in faces[1:]:
        face = typed(shape.Oriented(TopAbs_Orientation.TopAbs_FORWARD), FACE)
        for edge in explore(face, EDGE):
            curve = BRep_Tool.CurveOnSurface_s(edge, face, 0.0, 1.0)
            if curve is not None:
                first, last = BRep_Tool.Range_s(edge, face)
                builder.UpdateEdge(edge, curve, surface, place, BRep_Tool.Tolerance_s(edge))
                builder.Range(edge, surface, place, first, last)
        builder.UpdateFace(face, surface, place, BRep_Tool.Tolerance_s(face))
