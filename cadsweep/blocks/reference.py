"""What the CAD model says the mesh must be: the figures that :mod:`cadsweep.quality` holds a mesh against."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from ..arrays import FloatArray
from ..brep import Curve, Face, Part, Solid, volume_doubt
from ..quality import CadReference
from .naming import NamedFaces, Piece, Place

Names = frozenset[str]
"""All names of a piece of a face."""


def make_references(part: Part, names: NamedFaces) -> dict[str, CadReference]:
    """What the CAD model says of every solid, by name, in model units."""
    return {
        model.name: _Reference(part, names, owner).make()
        for owner, model in enumerate(part.models)
        if owner in part.owners
    }


class _Reference:
    """The outside of one solid of the model, put together from its cells' faces that are no cuts."""

    def __init__(self, part: Part, names: NamedFaces, owner: int) -> None:
        self.part = part
        self.owner = owner
        self.between = names.between
        self.cells = [cell for cell, own in enumerate(part.owners) if own == owner]
        self.pieces: dict[Piece, tuple[str, ...]] = {
            piece: given for piece, given in names.pieces().items() if piece[0] in self.cells
        }
        self.places = list(dict.fromkeys(piece[:2] for piece in self.pieces))
        self.by_name: dict[str, dict[Place, int]] = {}  # how many pieces of each face
        for piece, given in self.pieces.items():
            for name in given:
                own = self.by_name.setdefault(name, {})
                own[piece[:2]] = own.get(piece[:2], 0) + 1

    def face(self, place: Place) -> Face:
        """A face of a cell."""
        return self.part.solids[place[0]].faces[place[1]]

    def make(self) -> CadReference:
        """Collect the figures."""
        solids = [self.part.solids[cell] for cell in self.cells]
        scale = self.part.scale
        size = max(solid.size for solid in solids)
        gap = max((max([solid.tolerance, *(edge.gap for edge in solid.edges)]) for solid in solids), default=0.0)
        areas = {place: self.face(place).area * scale**2 for place in self.places}
        doubts = {place: area_doubt(self.part.solids[place[0]], self.face(place)) * scale**2 for place in self.places}
        joint = [tuple(sorted(names)) for names in self.mixed()]
        alone = [name for name in self.by_name if not any(name in names for names in joint)]

        def total(figures: Mapping[Place, float], names: Iterable[str]) -> float:
            return sum(figures[place] for place in dict.fromkeys(p for name in names for p in self.by_name[name]))

        return CadReference(
            volume=self.part.models[self.owner].volume * scale**3,
            volume_doubt=(sum(volume_doubt(solid) for solid in solids) + self.moved_volume()) * scale**3,
            areas={name: total(areas, [name]) for name in alone},
            area_doubts={name: total(doubts, [name]) for name in alone},
            joint_areas={names: total(areas, names) for names in joint},
            joint_doubts={names: total(doubts, names) for names in joint},
            euler=self.euler(),
            distance=self.distance,
            rim_distance=self.rim_distance(),
            tolerance=max(1e-6, 2.0 * gap / size),
        )

    def mixed(self) -> list[set[str]]:
        """Names of which the mesh knows no lines between, as in a merged face: only their common area is known."""
        found = [
            {name}
            for name, places in self.by_name.items()
            if any(n < 1 + len(self.face(place).former) for place, n in places.items())
        ]
        parted = set[str]().union(*found)
        for place in self.places if parted else ():
            joined = {name for name, places in self.by_name.items() if place in places}
            if joined & parted:
                joined.update(*(names for names in found if names & joined))
                found = [names for names in found if not names & joined] + [joined]
        return found

    def moved_volume(self) -> float:
        """What faces in contact sweep over at most, working units, where imprinting has closed gaps."""
        return self.part.touch * sum(self.face(place).area for place in self.places if place in self.between)

    def euler(self) -> int:
        """Vertices - edges + faces of the solid's surface, each face by its own Euler number."""
        vertices, edges, faces = set[int](), set[int](), 0
        for cell, face in self.places:
            solid = self.part.solids[cell]
            own = solid.faces[face]
            faces += own.euler
            for e in own.edges:
                edges.add(int(solid.edge_keys[e]))
                vertices.update(int(solid.vertex_keys[v]) for v in (solid.edges[e].start, solid.edges[e].end))
        return len(vertices) - len(edges) + faces

    def to_working(self, points: FloatArray) -> FloatArray:
        """Model points in working units."""
        return (points - self.part.offset) / self.part.scale

    def distance(self, points: FloatArray, name: str, close: float) -> FloatArray:
        """Distances of points from the faces of a boundary or an interface."""
        places, close = self.to_working(points), close / self.part.scale
        surfaces = [self.face(place).surface for place in self.by_name[name]]
        enough = close if np.isfinite(close) else -1.0
        nearest = np.full(len(places), np.inf)
        # The slower ways are for what is far from all faces: of the pieces of a divided one, a node lies on one alone.
        for ways, limit in (({}, enough), ({"close": close}, close)):
            for surface in surfaces if (nearest > limit).any() else ():
                left = np.flatnonzero(nearest > limit)
                nearest[left] = np.minimum(nearest[left], surface.distance(places[left], **ways))
        return nearest * self.part.scale

    def rim_distance(self) -> Callable[[FloatArray, frozenset[Names]], FloatArray]:
        """Distances from the edges between owners of quads, and from the vertices where more of them meet.

        An owner is known by its set of names. Between those that share a face there may be no edge: they count as one.
        """
        group_of = self.groups()
        own_group = {place: group_of[frozenset(self.pieces[(*place, -1)])] for place in self.places}
        around: dict[int, set[int]] = {}
        curves: dict[int, Curve] = {}
        corners: dict[int, set[int]] = {}
        vertices: dict[int, FloatArray] = {}
        for place, group in own_group.items():
            solid = self.part.solids[place[0]]
            for e in solid.faces[place[1]].edges:
                edge, key = solid.edges[e], int(solid.edge_keys[e])
                curves[key] = edge.curve
                around.setdefault(key, set()).add(group)
        for place in self.places:
            solid = self.part.solids[place[0]]
            for e in solid.faces[place[1]].edges:
                edge, key = solid.edges[e], int(solid.edge_keys[e])
                for v in (edge.start, edge.end):
                    corners.setdefault(int(solid.vertex_keys[v]), set()).update(around[key])
                    vertices[int(solid.vertex_keys[v])] = solid.vertices[v]
        between: dict[frozenset[int], list[Curve]] = {}
        for key, meeting in around.items():
            if key in curves:
                between.setdefault(frozenset(meeting), []).append(curves[key])

        def distance(points: FloatArray, owners: frozenset[Names]) -> FloatArray:
            meeting = frozenset(group_of[owner] for owner in owners)
            if len(meeting) == 1:
                return np.zeros(len(points))
            places = self.to_working(points)
            away = [curve.distance(places) for curve in between.get(meeting, ())]
            if not away:
                away = [np.linalg.norm(places - vertices[v], axis=1) for v, met in corners.items() if meeting <= met]
            return np.min([np.full(len(places), np.inf), *away], axis=0) * self.part.scale

        return distance

    def groups(self) -> dict[Names, int]:
        """A number for every owner; the same for those that share a face."""
        owners: dict[Place, set[Names]] = {}
        for piece, given in self.pieces.items():
            owners.setdefault(piece[:2], set()).add(frozenset(given))
        group_of: dict[Names, int] = {}
        members: list[set[Names]] = []
        for own in owners.values():
            met = {group_of[owner] for owner in own if owner in group_of}
            members.append(own.union(*(members[j] for j in met)))
            group_of |= dict.fromkeys(members[-1], len(members) - 1)
        return group_of


def area_doubt(solid: Solid, face: Face) -> float:
    """How uncertain the area of a face is, working units: the strips between its border and its edges."""
    return sum(solid.edges[e].gap * solid.edges[e].length for e in face.edges)
