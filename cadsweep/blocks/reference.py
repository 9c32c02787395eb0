"""What the CAD model says the mesh must be: the figures that :mod:`cadsweep.quality` holds a mesh against."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from ..arrays import FloatArray
from ..brep import Face, Part, Solid
from ..quality import CadReference
from ..sweep import Sweep
from .naming import name_pieces, pieces_by_name


def make_reference(part: Part, sweep: Sweep) -> CadReference:
    """Collect what the CAD model says the mesh must be, in model units."""
    solid = sweep.solid
    ring = sweep.closed
    by_name: dict[str, set[int]] = {}
    mixed: list[set[str]] = []  # names of which the mesh knows no lines between: only their common area is known
    for name, pieces in pieces_by_name(sweep).items():
        faces = {i for i, _ in pieces if not (ring and i in (*sweep.source, *sweep.target))}
        if faces:
            by_name[name] = faces
        for i in faces:
            if sum(1 for face, _ in pieces if face == i) < 1 + len(solid.faces[i].former):
                mixed.append({name})
                break
    parted = set().union(*mixed)
    for one in solid.faces:
        joined = {name for name, ids in by_name.items() if one.id in ids}
        if joined & parted:
            joined.update(*(names for names in mixed if names & joined))
            mixed = [names for names in mixed if not names & joined] + [joined]

    def distance(points: FloatArray, name: str, close: float) -> FloatArray:
        places, close = (points - part.offset) / part.scale, close / part.scale
        surfaces = [solid.faces[face].surface for face in by_name[name]]
        enough = close if np.isfinite(close) else -1.0
        nearest = np.full(len(places), np.inf)
        for surface in surfaces:
            left = np.flatnonzero(nearest > enough)
            nearest[left] = np.minimum(nearest[left], surface.distance(places[left]))
        # The slower ways are for what is far from all faces: of the pieces of a divided one, a node lies on one alone.
        for surface in surfaces if (nearest > close).any() else ():
            left = np.flatnonzero(nearest > close)
            nearest[left] = np.minimum(nearest[left], surface.distance(places[left], close=close))
        return nearest * part.scale

    def total(figures: Sequence[float], names: Iterable[str]) -> float:
        return sum(figures[i] for i in {i for name in names for i in by_name[name]}) * part.scale**2

    areas, doubts = [face.area for face in solid.faces], [area_doubt(solid, face) for face in solid.faces]
    alone = [name for name in by_name if name not in parted]
    joint = [tuple(sorted(names)) for names in mixed]
    gap = max((edge.gap for edge in solid.edges), default=0.0)

    return CadReference(
        volume=solid.volume * part.scale**3,
        volume_doubt=volume_doubt(solid) * part.scale**3,
        areas={name: total(areas, [name]) for name in alone},
        area_doubts={name: total(doubts, [name]) for name in alone},
        joint_areas={names: total(areas, names) for names in joint},
        joint_doubts={names: total(doubts, names) for names in joint},
        euler=0 if ring else euler_characteristic(solid),  # a ring cut open is a ball; closed, it is a torus
        distance=distance,
        rim_distance=_make_rim_distance(part, sweep, set().union(*by_name.values())),
        tolerance=max(1e-6, 2.0 * max(solid.tolerance, gap) / solid.size),
    )


def _make_rim_distance(
    part: Part, sweep: Sweep, faces: set[int]
) -> Callable[[FloatArray, frozenset[frozenset[str]]], FloatArray]:
    """Distances from the edges between two owners of quads, and from the vertices where more of them meet.

    An owner is known by its set of names. Between those that share a face there may be no edge: they count as one.
    """
    solid = sweep.solid
    owners: dict[int, set[frozenset[str]]] = {}
    for (face, _), names in name_pieces(sweep).items():
        if face in faces:
            owners.setdefault(face, set()).add(frozenset(names))
    group_of: dict[frozenset[str], int] = {}
    members: list[set[frozenset[str]]] = []
    for own in owners.values():
        met = {group_of[owner] for owner in own if owner in group_of}
        members.append(own.union(*(members[j] for j in met)))
        group_of |= dict.fromkeys(members[-1], len(members) - 1)
    groups = {face: group_of[next(iter(own))] for face, own in owners.items()}
    edges: dict[frozenset[int], list[int]] = {}
    vertices: dict[int, set[int]] = {}
    twins = {t: e for e, (t, _) in sweep.target_edges.items()} if sweep.closed else {}
    twins |= {e: t for t, e in twins.items()}  # of a ring cut open, the sides beside both edges of a pair meet there
    for edge in solid.edges:
        beside = [*edge.faces, *(solid.edges[twins[edge.id]].faces if edge.id in twins else ())]
        around = frozenset(groups[face] for face in beside if face in groups)
        edges.setdefault(around, []).append(edge.id)
        for vertex in (edge.start, edge.end):
            vertices.setdefault(vertex, set()).update(around)

    at_group: dict[int, set[int]] = {}
    for vertex, meeting in vertices.items():
        for group in meeting:
            at_group.setdefault(group, set()).add(vertex)

    def rim_distance(points: FloatArray, meeting_owners: frozenset[frozenset[str]]) -> FloatArray:
        meeting = frozenset(group_of[owner] for owner in meeting_owners)
        if len(meeting) == 1:
            return np.zeros(len(points))
        places = (points - part.offset) / part.scale
        away = [solid.edges[e].curve.distance(places) for e in edges.get(meeting, ())]
        if not away:
            corners = sorted(set.intersection(*(at_group.get(group, set()) for group in meeting)))
            away = [np.linalg.norm(places - solid.vertices[v], axis=1) for v in corners]
        return np.min([np.full(len(places), np.inf), *away], axis=0) * part.scale

    return rim_distance


def volume_doubt(solid: Solid) -> float:
    """How uncertain the volume is, working units: nothing says what lies in the gaps between the faces.

    A face that is off by a gap at all of its border changes the volume by the gap times its area. Where only short
    edges are off, it is the area of the open strips times half of the solid's size at most.
    """
    gaps = [edge.gap for edge in solid.edges]
    found = 0.0
    for face in solid.faces:
        strips = sum(gaps[e] * solid.edges[e].length for e in face.edges)
        found += min(max(gaps[e] for e in face.edges) * face.area, strips * solid.size / 2)
    return found


def area_doubt(solid: Solid, face: Face) -> float:
    """How uncertain the area of a face is, working units: the strips between its border and its edges."""
    return sum(solid.edges[e].gap * solid.edges[e].length for e in face.edges)


def euler_characteristic(solid: Solid) -> int:
    """Vertices - edges + faces of the solid's surface; a face with holes counts 2 - its loops."""
    return len(solid.vertices) - len(solid.edges) + sum(2 - len(face.loops) for face in solid.faces)
