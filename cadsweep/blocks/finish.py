"""From a joined mesh to one with names: parts, boundaries, interfaces, and the CAD figures of every solid.

Place in the flow: ``pipeline`` calls it on a :class:`~cadsweep.blocks.joined.JoinedMesh` before the checks. A face
with one cell is a boundary, one between two solids of the model an interface, one between two cells of one solid a
cut, which is neither.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Face, Part, Units
from ..io.sides import find_sides
from ..mesh import HexMesh
from ..quality import CadReference, fit_surfaces
from .block import unite_quads
from .block_mesh import BlockMesh, Faces
from .cells import CellBlocks, SweptCell
from .joined import JoinedMesh, neighbours_of
from .reference import area_doubt, volume_doubt
from .slabs import ArrayBlock, Block

Place = tuple[int, int]
"""A cell, and its id of a face."""


@dataclass(frozen=True, kw_only=True, eq=False)
class NamedFaces:
    """What the faces of the cells are called.

    Attributes
    ----------
    outside : dict of (cell, face) to tuple of str
        Boundary names.
    between : dict of (cell, face) to tuple of str
        Interface names, of both cells' faces.
    first : dict of (cell, face) to bool
        Whether an interface's face is that of the solid which its name begins with.
    """

    outside: dict[Place, tuple[str, ...]]
    between: dict[Place, tuple[str, ...]]
    first: dict[Place, bool]

    def of(self, place: Place) -> tuple[str, ...]:
        """All names of a face; none of a cut."""
        return self.outside.get(place) or self.between.get(place) or ()


def name_faces(part: Part, roles: dict[Place, str]) -> NamedFaces:
    """Name every face.

    Faces keep the names that their user gave them. The others are called by their role in the sweep of their cell,
    behind the name of their solid where the model has several; pieces of one face of the input share a name.
    An interface is ``first__second``, after the solids that it is between, in the order of the model.
    """
    beyond = neighbours_of(part)
    outside: dict[Place, tuple[str, ...]] = {}
    between: dict[Place, tuple[str, ...]] = {}
    first: dict[Place, bool] = {}
    taken = {name for solid in part.solids for face in solid.faces for name in face.names}
    unnamed: dict[tuple[int, str], dict[str, list[Place]]] = {}
    role_of: dict[tuple[int, str], str] = {}
    for cell, solid in enumerate(part.solids):
        owner = part.owners[cell]
        for face in solid.faces:
            place = (cell, face.id)
            other = beyond.get(place)
            if other is not None:
                theirs = part.owners[other[0]]
                if theirs == owner:
                    continue
                low, high = sorted((owner, theirs))
                users = (*face.names, *part.solids[other[0]].faces[other[1]].names)
                between[place] = tuple(dict.fromkeys((f"{part.models[low].name}__{part.models[high].name}", *users)))
                first[place] = owner == low
            elif face.names:
                outside[place] = face.names
            else:
                key = face.key or f"key {int(solid.face_keys[face.id])}"
                role = role_of.setdefault((owner, key), roles.get(place, "side"))
                unnamed.setdefault((owner, role), {}).setdefault(key, []).append(place)
    for (owner, role), pieces in unnamed.items():
        prefix = f"{part.models[owner].name}_" if len(part.models) > 1 else ""
        for number, places in enumerate(pieces.values(), start=1):
            name = prefix + (role if role != "side" and len(pieces) == 1 else f"{role}_{number}")
            while name in taken:
                name += "_"
            outside |= dict.fromkeys(places, (name,))
    return NamedFaces(outside=outside, between=between, first=first)


def to_hex_mesh(part: Part, mesh: JoinedMesh, names: NamedFaces, info: dict[str, Any]) -> HexMesh:
    """Give a joined mesh its names; points in model units."""
    owners = np.array(part.owners, dtype=np.int64)[mesh.hex_cells]
    faces = by_face(mesh)
    parts = {model.name: np.flatnonzero(owners == j) for j, model in enumerate(part.models)}
    return HexMesh(
        points=part.to_model(mesh.points),
        hexes=mesh.hexes,
        boundaries=unite_quads((names.outside[place], quads) for place, quads in faces if place in names.outside),
        interfaces=unite_quads((names.between[place], quads) for place, quads in faces if names.first.get(place)),
        parts={name: ids for name, ids in parts.items() if len(ids)},
        info=info,
    )


def to_block_mesh(part: Part, mesh: CellBlocks, names: NamedFaces, info: dict[str, Any]) -> BlockMesh:
    """The mesh of :func:`to_hex_mesh`, its cells left in blocks."""
    units = Units(part.scale, part.offset)
    points = units.to_model(mesh.points)
    starts = np.cumsum([0, *(own.n_hexes for own in mesh.cells)])
    blocks: list[Block] = []
    beside = []
    for number, own in enumerate(mesh.cells):
        first = int(starts[number])
        if isinstance(own, SweptCell):
            blocks.append(mesh.swept_block(number, units, first))
            beside.append(own.quad_hexes() + first)
        else:
            blocks.append(ArrayBlock(points=points, nodes=mesh.numbers, hexes=own.hexes, first_hex=first))
            quads = mesh.quads[mesh.quad_cells == own.cell]
            beside.append(find_sides(own.hexes, quads, len(points))[0] + first)
    owners = [part.owners[own.cell] for own in mesh.cells]
    present = [j for j in range(len(part.models)) if j in owners]
    of_quad = np.array(part.owners, dtype=np.int64)[mesh.quad_cells]
    surfaces, problems = [], list[str]()
    for owner in present:
        quads = mesh.quads[of_quad == owner]
        rows, unfit = fit_surfaces(quads)
        surfaces.append(mesh.numbers[quads[rows]])
        problems += [f"part '{part.models[owner].name}': {problem}" for problem in unfit]
    with_hexes = replace(mesh, quads=np.column_stack([mesh.numbers[mesh.quads], np.concatenate(beside)]))

    def faces(labels: dict[Place, tuple[str, ...]]) -> dict[str, Faces]:
        rows = unite_quads((labels[place], own) for place, own in by_face(with_hexes) if place in labels)
        return {name: Faces(own[:, :4], own[:, 4]) for name, own in rows.items()}

    return BlockMesh(
        blocks=tuple(blocks),
        block_parts=tuple(present.index(owner) for owner in owners),
        parts=tuple(part.models[owner].name for owner in present),
        n_nodes=mesh.n_nodes,
        kept_nodes=mesh.numbers,
        kept_points=points,
        surface_nodes=mesh.numbers,
        surface_points=points,
        part_quads=tuple(surfaces),
        boundaries=faces(names.outside),
        interfaces=faces({place: given for place, given in names.between.items() if names.first[place]}),
        problems=tuple(problems),
        info=info,
    )


def by_face(mesh: JoinedMesh | CellBlocks) -> list[tuple[Place, IntArray]]:
    """Quads of every face of every cell, outward from the cell."""
    width = int(mesh.quad_faces.max(initial=0)) + 1
    keys = mesh.quad_cells * width + mesh.quad_faces
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    starts = np.flatnonzero(np.diff(ordered, prepend=-1))
    pieces = np.split(mesh.quads[order], starts)[1:]
    return [(divmod(key, width), quads) for key, quads in zip(ordered[starts].tolist(), pieces, strict=True)]


def find_colors(part: Part, names: NamedFaces) -> dict[str, dict[str, str]]:
    """Colours of the CAD model: ``boundaries`` and ``parts`` by name, where all faces of a boundary have one."""
    seen: dict[str, set[str | None]] = {}
    for (cell, face), given in names.outside.items():
        for name in given:
            seen.setdefault(name, set()).add(part.solids[cell].faces[face].color)
    own = {name: next(iter(colors)) for name, colors in seen.items() if len(colors) == 1}
    return {
        "boundaries": {name: color for name, color in own.items() if color is not None},
        "parts": {model.name: model.color for model in part.models if model.color is not None},
    }


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
        self.names = {
            (cell, face.id): names.of((cell, face.id))
            for cell in self.cells
            for face in part.solids[cell].faces
            if names.of((cell, face.id))
        }
        self.by_name: dict[str, list[Face]] = {}
        for (cell, face), given in self.names.items():
            for name in given:
                self.by_name.setdefault(name, []).append(part.solids[cell].faces[face])

    def make(self) -> CadReference:
        """Collect the figures."""
        solids = [self.part.solids[cell] for cell in self.cells]
        scale = self.part.scale
        size = max(solid.size for solid in solids)
        gap = max((max(solid.tolerance, *(edge.gap for edge in solid.edges)) for solid in solids), default=0.0)
        doubts: dict[str, float] = {}
        for (cell, face), given in self.names.items():
            solid = self.part.solids[cell]
            for name in given:
                doubts[name] = doubts.get(name, 0.0) + area_doubt(solid, solid.faces[face]) * scale**2
        return CadReference(
            volume=self.part.models[self.owner].volume * scale**3,
            volume_doubt=(sum(volume_doubt(solid) for solid in solids) + self.moved_volume()) * scale**3,
            areas={name: sum(face.area for face in faces) * scale**2 for name, faces in self.by_name.items()},
            area_doubts=doubts,
            euler=self.euler(),
            distance=self.distance,
            rim_distance=self.rim_distance(),
            tolerance=max(1e-6, 2.0 * gap / size),
        )

    def moved_volume(self) -> float:
        """What faces in contact sweep over at most, working units, where imprinting has closed gaps."""
        touching = [place for place in self.names if place in self.between]
        return self.part.touch * sum(self.part.solids[cell].faces[face].area for cell, face in touching)

    def euler(self) -> int:
        """Vertices - edges + faces of the solid's surface; a face with holes counts 2 - its loops."""
        vertices, edges, faces = set[int](), set[int](), 0
        for cell, face in self.names:
            solid = self.part.solids[cell]
            own = solid.faces[face]
            faces += 2 - len(own.loops)
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
        surfaces = [face.surface for face in self.by_name[name]]
        enough = close if np.isfinite(close) else -1.0
        nearest = np.full(len(places), np.inf)
        for ways in ({}, {"close": close}):
            limit = close if ways else enough
            for surface in surfaces if (nearest > limit).any() else ():
                left = np.flatnonzero(nearest > limit)
                nearest[left] = np.minimum(nearest[left], surface.distance(places[left], **ways))
        return nearest * self.part.scale

    def rim_distance(self) -> Callable[[FloatArray, frozenset[frozenset[str]]], FloatArray]:
        """Distances from the edges between two sets of names, and from the vertices where more of them meet."""
        around: dict[int, set[frozenset[str]]] = {}
        curves: dict[int, Any] = {}
        corners: dict[int, set[frozenset[str]]] = {}
        places: dict[int, FloatArray] = {}
        for (cell, face), given in self.names.items():
            solid = self.part.solids[cell]
            for e in solid.faces[face].edges:
                key, edge = int(solid.edge_keys[e]), solid.edges[e]
                around.setdefault(key, set()).add(frozenset(given))
                curves[key] = edge.curve
                for v in (edge.start, edge.end):
                    corners.setdefault(int(solid.vertex_keys[v]), set()).add(frozenset(given))
                    places[int(solid.vertex_keys[v])] = solid.vertices[v]
        by_sets: dict[frozenset[frozenset[str]], list[Any]] = {}
        for key, sets in around.items():
            by_sets.setdefault(frozenset(sets), []).append(curves[key])
        return partial(self._rim_distance, by_sets, corners, places)

    def _rim_distance(
        self,
        curves: dict[frozenset[frozenset[str]], list[Any]],
        corners: dict[int, set[frozenset[str]]],
        vertices: dict[int, FloatArray],
        points: FloatArray,
        meeting: frozenset[frozenset[str]],
    ) -> FloatArray:
        if len(meeting) == 1:
            return np.zeros(len(points))
        places = self.to_working(points)
        away: Iterable[Any] = [curve.distance(places) for curve in curves.get(meeting, ())]
        if not away:
            away = [np.linalg.norm(places - vertices[v], axis=1) for v, sets in corners.items() if meeting <= sets]
        return np.min([np.full(len(places), np.inf), *away], axis=0) * self.part.scale
