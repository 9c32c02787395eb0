"""Faces that run tangent into each other, joined to one face of the topology.

Place in the flow: ``fillets`` joins a cap's plane with the halves of the roundings around it. A quad mesh need not
follow the edges between them, which are no edges of the shape, and is better where it does not.

Method: the joined face is a graph over the plane of the cap. Its parameters are the coordinates in that plane; a point
is found on the member above whose outline its place lies, by Newton's iteration along the normal of the plane.

Not handled: faces that lean too far over to be a graph; the caller does not join them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...brep import Face, FormerFace, Loop, Solid
from ...sweep import DirectedEdge
from ..shapes import SolidShape
from .face_surface import FaceSurface

_SAMPLES = 17
"""Points on every edge of a member's outline."""
_STEPS = 12
"""Newton steps onto the surface: they double the digits, so 12 are ample from any start that converges."""
_CLOSE = 1e-13
"""Greatest step, as a share of the face's extent, after which the iteration ends."""
_CHUNK = 4096
"""Points at a time: their squares of distances to all pieces stay within a megabyte or so."""


class GraphSurface:
    """Several surfaces as one graph over a plane; parameters are coordinates in the plane."""

    def __init__(self, members: Sequence[Face], solid: Solid, normal: FloatArray) -> None:
        axis = np.eye(3)[np.argmin(np.abs(normal))]
        first = np.cross(axis, normal) / np.linalg.norm(np.cross(axis, normal))
        self.frame = np.stack([first, np.cross(normal, first), normal])
        self.curves = {e: solid.edges[e].curve for face in members for e in face.edges}
        self.surfaces = [face.surface for face in members]
        fractions = np.linspace(0.0, 1.0, _SAMPLES)
        along = {e: curve.evaluate(fractions) @ self.frame.T for e, curve in self.curves.items()}
        ends = solid.vertices @ self.frame.T
        for e, points in along.items():
            # To the last bit, or a ray slips through between two edges.
            points[0], points[-1] = ends[solid.edges[e].start], ends[solid.edges[e].end]
        self.outlines = [
            np.concatenate([np.stack([along[e][:-1], along[e][1:]], axis=1) for e in face.edges]) for face in members
        ]
        self.extent = float(np.ptp(np.concatenate(self.outlines).reshape(-1, 3), axis=0).max())

    @property
    def periods(self) -> tuple[float | None, float | None]:
        """None: a graph closes nowhere."""
        return None, None

    def _owners(self, uv: FloatArray) -> IntArray:
        """The member above each place (m,): the one whose outline it is in, or whose outline is nearest."""
        owners = np.full(len(uv), -1, dtype=np.int64)
        for start in range(0, len(uv), _CHUNK):
            part = uv[start : start + _CHUNK]
            mine = owners[start : start + _CHUNK]
            for k, outline in enumerate(self.outlines):
                mine[_inside(part, outline[..., :2])] = k
            outside = np.flatnonzero(mine < 0)
            if len(outside):
                away = [_distances(part[outside], outline[..., :2]) for outline in self.outlines]
                mine[outside] = np.argmin(away, axis=0)
        return owners

    def _raise(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (m, 3) above places in the plane, and the normals there."""
        owners = self._owners(uv)
        points, normals = np.empty((len(uv), 3)), np.empty((len(uv), 3))
        for k, surface in enumerate(self.surfaces):
            mine = np.flatnonzero(owners == k)
            if not len(mine):
                continue
            height = np.full((len(mine), 1), self.outlines[k][..., 2].mean())
            at = np.hstack([uv[mine], height]) @ self.frame
            for _ in range(_STEPS):
                feet = surface.project(at)
                normal = surface.normals(feet)
                lean = normal @ self.frame[2]
                lean = np.where(np.abs(lean) > 0.1, lean, 0.1)
                step = np.einsum("ij,ij->i", surface.evaluate(feet) - at, normal) / lean
                at = at + step[:, None] * self.frame[2]
                if np.abs(step).max() < _CLOSE * self.extent:
                    break
            points[mine], normals[mine] = at, surface.normals(surface.project(at))
        return points, normals

    def evaluate(self, uv: FloatArray) -> FloatArray:
        """Points (m, 3) of the face."""
        return self._raise(np.asarray(uv, dtype=np.float64).reshape(-1, 2))[0]

    def normals(self, uv: FloatArray) -> FloatArray:
        """Unit normals (m, 3) out of the solid."""
        return self._raise(np.asarray(uv, dtype=np.float64).reshape(-1, 2))[1]

    def derivatives(self, uv: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Partial derivatives (m, 3) by both coordinates."""
        lean = self.normals(uv) @ self.frame.T
        by_u = self.frame[0] - (lean[:, :1] / lean[:, 2:]) * self.frame[2]
        by_v = self.frame[1] - (lean[:, 1:2] / lean[:, 2:]) * self.frame[2]
        return by_u, by_v

    def project(self, points: FloatArray) -> FloatArray:
        """Coordinates (m, 2) of the nearest points."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        best = points @ self.frame[:2].T
        # The foot may belong to another member than the place below the point.
        for _ in range(2):
            owners = self._owners(best)
            for k, surface in enumerate(self.surfaces):
                mine = owners == k
                if mine.any():
                    best[mine] = surface.evaluate(surface.project(points[mine])) @ self.frame[:2].T
        return best

    def distance(self, points: FloatArray, *, close: float = np.inf) -> FloatArray:
        """Distances (m,) of `points` (m, 3); `close` as in ``brep.Surface``."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        owners = self._owners(self.project(points))
        found = np.empty(len(points))
        for k, surface in enumerate(self.surfaces):
            mine = owners == k
            if mine.any():
                found[mine] = surface.distance(points[mine], close=close)
        return found

    def member_at(self, points: FloatArray) -> IntArray:
        """The member (m,) that points (m, 3) of the face lie on."""
        return self._owners(self.project(points))

    def edge_uv(self, edge: int, fractions: FloatArray) -> FloatArray:
        """Coordinates (m, 2) of an edge's points."""
        uv: FloatArray = self.curves[edge].evaluate(fractions) @ self.frame[:2].T
        return uv


def _inside(places: FloatArray, outline: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether places (m, 2) lie inside an outline of segments (n, 2, 2) in any order: crossings of a ray, counted."""
    (ax, ay), (bx, by) = outline[:, 0].T, outline[:, 1].T
    x, y = places[:, :1], places[:, 1:]
    spans = (ay > y) != (by > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = x < ax + (y - ay) / (by - ay) * (bx - ax)
    inside: npt.NDArray[np.bool_] = (spans & right).sum(axis=1) % 2 == 1
    return inside


def _distances(places: FloatArray, outline: FloatArray) -> FloatArray:
    """Distance (m,) of places from the nearest segment of an outline."""
    start, step = outline[:, 0], outline[:, 1] - outline[:, 0]
    off = places[:, None] - start
    t = np.einsum("mnd,nd->mn", off, step) / np.maximum(np.einsum("nd,nd->n", step, step), 1e-300)
    away: FloatArray = np.linalg.norm(off - np.clip(t, 0.0, 1.0)[..., None] * step, axis=2).min(axis=1)
    return away


def join_faces(solid: Solid, group: Sequence[int], into: int) -> Solid | None:
    """Join faces that are a graph over the plane of one of them.

    Parameters
    ----------
    solid : Solid
    group : sequence of int
        Faces that hang together through edges at which they are tangent.
    into : int
        The plane face of the group; the joined face takes its id, name and key. The ids of the others are gone.

    Returns
    -------
    Solid or None
        None where the group's outline is not a set of simple loops.
    """
    members = set(group)
    inner = {edge.id for edge in solid.edges if members.issuperset(edge.faces)}
    loops = _outline(solid, group, inner)
    if loops is None:
        return None
    plane = solid.faces[into]
    faces = [solid.faces[f] for f in sorted(members)]
    surface = GraphSurface(faces, solid, plane.normal)
    areas = np.array([face.area for face in faces])
    center = np.average([face.center for face in faces], axis=0, weights=areas)
    joined = replace(
        plane,
        kind="other",
        area=float(areas.sum()),
        center=center,
        normal=surface.normals(surface.project(center[None]))[0],
        loops=_ordered(loops, surface),
        surface=surface,
        former=_former_faces(faces, plane.names, surface),
    )
    return _without(solid, members - {into}, inner, joined)


def _former_faces(faces: Sequence[Face], names: tuple[str, ...], surface: GraphSurface) -> tuple[FormerFace, ...]:
    """A patch for every name among the members that is not the plane's."""
    by_names: dict[tuple[str, ...], list[int]] = {}
    for k, face in enumerate(faces):
        if face.names and face.names != names:
            by_names.setdefault(face.names, []).append(k)
    patches = []
    for own, members in by_names.items():
        mine = [faces[k] for k in members]
        largest = max(mine, key=lambda face: face.area)
        patches.append(
            FormerFace(
                names=own,
                key=largest.key,
                color=largest.color,
                area=sum(face.area for face in mine),
                place=surface.evaluate(surface.project(largest.center[None]))[0],
                piece_at=surface.member_at,
                pieces=tuple(members),
            )
        )
    return tuple(patches)


def _outline(solid: Solid, group: Sequence[int], inner: set[int]) -> list[Loop] | None:
    """Loops around a group of faces, with the angles of all members at a vertex added up."""
    angles: dict[int, float] = {}
    leaving: dict[int, DirectedEdge] = {}
    for f in group:
        for loop in solid.faces[f].loops:
            for directed, angle in zip(loop.directed, loop.angles, strict=True):
                v = solid.first_vertex(directed)
                angles[v] = angles.get(v, 0.0) + angle
                if directed[0] not in inner:
                    if v in leaving:
                        return None
                    leaving[v] = directed
    loops = []
    while leaving:
        start = next(iter(leaving))
        chain, corner, v = [], [], start
        while v in leaving:
            corner.append(angles[v])
            chain.append(leaving.pop(v))
            v = solid.last_vertex(chain[-1])
        if v != start:
            return None
        loops.append(
            Loop(edges=tuple(e for e, _ in chain), forward=tuple(way for _, way in chain), angles=tuple(corner))
        )
    return loops


def _ordered(loops: Sequence[Loop], surface: GraphSurface) -> tuple[Loop, ...]:
    """The outer loop, which encloses the most, first."""
    fractions = np.linspace(0.0, 1.0, _SAMPLES)

    def area(loop: Loop) -> float:
        x, y = np.concatenate(
            [surface.edge_uv(e, fractions)[:: 1 if forward else -1][:-1] for e, forward in loop.directed]
        ).T
        return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    return tuple(sorted(loops, key=area, reverse=True))


def _without(solid: Solid, faces: set[int], edges: set[int], joined: Face) -> Solid | None:
    """The solid without some faces and edges, everything numbered anew in the old order."""
    holder = solid.kernel
    if not isinstance(holder, SolidShape):
        return None
    kept_faces = [face.id for face in solid.faces if face.id not in faces]
    kept_edges = [edge.id for edge in solid.edges if edge.id not in edges]
    kept_vertices = sorted({v for e in kept_edges for v in (solid.edges[e].start, solid.edges[e].end)})
    new_face = {f: j for j, f in enumerate(kept_faces)} | dict.fromkeys(faces, kept_faces.index(joined.id))
    new_edge = {e: j for j, e in enumerate(kept_edges)}
    new_vertex = {v: j for j, v in enumerate(kept_vertices)}
    return replace(
        solid,
        vertices=solid.vertices[kept_vertices],
        edges=tuple(
            replace(
                edge,
                id=new_edge[edge.id],
                start=new_vertex[edge.start],
                end=new_vertex[edge.end],
                faces=(new_face[edge.faces[0]], new_face[edge.faces[1]]),
            )
            for edge in (solid.edges[e] for e in kept_edges)
        ),
        faces=tuple(
            _renumbered(joined if f == joined.id else solid.faces[f], new_face[f], new_edge) for f in kept_faces
        ),
        kernel=SolidShape(
            shape=holder.shape,
            faces=[holder.faces[f] for f in kept_faces],
            edges=[holder.edges[e] for e in kept_edges],
            vertices=[holder.vertices[v] for v in kept_vertices],
        ),
        vertex_keys=solid.vertex_keys[kept_vertices],
        edge_keys=solid.edge_keys[kept_edges],
        face_keys=solid.face_keys[kept_faces],
    )


def _renumbered(face: Face, number: int, new_edge: dict[int, int]) -> Face:
    loops = tuple(replace(loop, edges=tuple(new_edge[e] for e in loop.edges)) for loop in face.loops)
    surface = face.surface
    if isinstance(surface, GraphSurface):
        surface.curves = {new_edge[e]: curve for e, curve in surface.curves.items() if e in new_edge}
    elif isinstance(surface, FaceSurface):
        surface = replace(surface, curves={new_edge[e]: curve for e, curve in surface.curves.items() if e in new_edge})
    return replace(face, id=number, loops=loops, surface=surface)
