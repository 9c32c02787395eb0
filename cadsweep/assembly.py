"""From layers of nodes to a named mesh: which quads bound which face, and what the face is called.

Place in the flow: after ``projection`` and ``smoothing``, before ``quality``. A :class:`FactoredMesh` is
the whole mesh in a few megabytes: the factors, the moved nodes, and the owner of every boundary quad.
It is what a file of factors holds, what MPI ranks share, and what slabs are streamed from.

Every boundary quad belongs to exactly one CAD face, or patch of a merged face. These may have several names
(their own, and those of groups they are in): what has the same names has one *owner*; the quads of owners never
overlap, and a boundary is all quads of the owners with its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from .mesh import HexMesh, SurfaceMesh, SweptStructure, side_quads, sweep_hexes
from .patches import own_quads
from .quality import CadReference
from .topology import FloatArray, IntArray, Part, Solid, Sweep

if TYPE_CHECKING:
    from .projection import FactoredSweep


def name_pieces(sweep: Sweep) -> dict[tuple[int, int], tuple[str, ...]]:
    """Name every face of the solid, and every patch of a face.

    They keep the names that their user gave them. The others are ``source``, ``target`` and
    ``side_1``, ``side_2``, ... in the order of the loops; a cap of several unnamed faces is
    ``source_1``, ``source_2``, ... Pieces of one divided face share a name.

    Returns
    -------
    dict of (int, int) to tuple of str
        Boundary names of the faces (face id, -1) and of their patches (face id, number).
    """
    faces = sweep.solid.faces
    roles = [("source", sweep.source), ("target", sweep.target), ("side", [s.face for s in sweep.linking_sides])]
    names: dict[tuple[int, int], tuple[str, ...]] = {}
    pieces: list[tuple[str, list[tuple[tuple[int, int], tuple[str, ...], str]]]] = []
    for role, ids in roles:
        own: list[tuple[tuple[int, int], tuple[str, ...], str]] = []
        for i in ids:
            own.append(((i, -1), faces[i].names, faces[i].key or f"face {i}"))
            own += [((i, j), patch.names, patch.key) for j, patch in enumerate(faces[i].patches)]
        pieces.append((role, own))
    taken = {name for _, own in pieces for _, given, _ in own for name in given}
    for role, own in pieces:
        numbers: dict[str, int] = {}
        for _, given, key in own:
            if not given:
                numbers.setdefault(key, len(numbers) + 1)
        for place, given, key in own:
            names[place] = given
            if not given:
                name = role if role != "side" and len(numbers) == 1 else f"{role}_{numbers[key]}"
                while name in taken:
                    name += "_"
                names[place] = (name,)
    return names


def pieces_by_name(sweep: Sweep) -> dict[str, list[tuple[int, int]]]:
    """Faces and patches of every boundary."""
    found: dict[str, list[tuple[int, int]]] = {}
    for piece, names in name_pieces(sweep).items():
        for name in names:
            found.setdefault(name, []).append(piece)
    return found


def find_colors(sweep: Sweep, part: str) -> dict[str, dict[str, str]]:
    """Colours of the CAD model: ``boundaries`` and ``parts`` by name, empty where there are none.

    A boundary has a colour where all its faces are of that one, and not by being of the part's.
    """
    solid = sweep.solid
    boundaries = {}
    for name, pieces in pieces_by_name(sweep).items():
        own = {(solid.faces[i] if j < 0 else solid.faces[i].patches[j]).color for i, j in pieces}
        if len(own) == 1 and None not in own:
            boundaries[name] = str(own.pop())
    return {"boundaries": boundaries, "parts": {} if solid.color is None else {part: solid.color}}


@dataclass(frozen=True, kw_only=True, eq=False)
class FactoredMesh:
    """A swept mesh that is not yet multiplied out.

    Attributes
    ----------
    sweep : FactoredSweep
        Places of the nodes, working units.
    structure : SweptStructure
    owner_names : tuple of tuple of str
        Boundary names of every owner; the owners below are indices into it.
    source_owners, target_owners : (q,) int64
        Owner of the quad of the source and of the target cap.
    side_owners : (n_layers, b) int64
    moved_nodes : (m,) int64
        Nodes that smoothing moved; empty where none was needed.
    moved_points : (m, 3) float64
        Where to, working units.
    part : str
        Name of the volume.
    scale : float
    offset : (3,) float64
        From working to model units, as in ``topology.Part``.
    info : dict
    """

    sweep: FactoredSweep
    structure: SweptStructure
    owner_names: tuple[tuple[str, ...], ...]
    source_owners: IntArray
    target_owners: IntArray
    side_owners: IntArray
    moved_nodes: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    moved_points: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    part: str = "part"
    scale: float = 1.0
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))
    info: dict[str, Any] = field(default_factory=dict)

    @property
    def n_node_layers(self) -> int:
        """Layers of distinct nodes: one fewer on a closed ring."""
        return self.structure.n_layers + (not self.structure.periodic)

    @property
    def is_changed(self) -> bool:
        """Whether nodes were moved away from where the factors put them."""
        return len(self.moved_nodes) > 0

    def points(self, start: int = 0, stop: int | None = None, *, out: FloatArray | None = None) -> FloatArray:
        """Nodes of the layers ``start`` to ``stop`` (exclusive), (layers, n_nodes, 3), model units."""
        stop = self.n_node_layers if stop is None else stop
        block = self.sweep.points(slice(start, stop), out=out)
        n = self.structure.n_nodes
        first, last = np.searchsorted(self.moved_nodes, [start * n, stop * n])
        if last > first:
            block.reshape(-1, 3)[self.moved_nodes[first:last] - start * n] = self.moved_points[first:last]
        return self.to_model(block)

    def to_model(self, points: FloatArray) -> FloatArray:
        """Bring working points to model units, in place where there is anything to do."""
        if self.scale != 1.0:
            points = np.multiply(points, self.scale, out=points)
        if self.offset.any():
            points = np.add(points, self.offset, out=points)
        return points

    def owned_quads(self) -> list[tuple[tuple[str, ...], IntArray]]:
        """Names and outward quads (m, 4) of the owners: source, target, sides; an owner may come more than once."""
        s = self.structure
        sides = side_quads(s.loops, s.n_nodes, s.n_layers, periodic=s.periodic).reshape(-1, 4)
        blocks = [(sides, self.side_owners.reshape(-1))]
        if not s.periodic:
            blocks = [
                (s.quads[:, ::-1], self.source_owners),
                (s.quads + s.n_layers * s.n_nodes, self.target_owners),
                *blocks,
            ]
        found = []
        for quads, owners in blocks:
            order = np.argsort(owners, kind="stable")
            ids, starts = np.unique(owners[order], return_index=True)
            for owner, chosen in zip(ids, np.split(order, starts[1:]), strict=True):
                found.append((self.owner_names[int(owner)], quads[chosen]))
        return found

    def boundaries(self) -> dict[str, IntArray]:
        """Outward boundary quads (m, 4) by name."""
        return unite_quads(self.owned_quads())

    def to_mesh(self) -> HexMesh:
        """Multiply out."""
        s = self.structure
        points = np.empty((self.n_node_layers, s.n_nodes, 3))
        self.points(out=points)
        return HexMesh(
            points=points.reshape(-1, 3),
            hexes=sweep_hexes(s.quads, s.n_nodes, s.n_layers, periodic=s.periodic),
            boundaries=self.boundaries(),
            parts={self.part: np.arange(s.n_layers * len(s.quads), dtype=np.int64)},
            structure=s,
            info=self.info,
        )


def unite_quads(owned: Iterable[tuple[tuple[str, ...], IntArray]]) -> dict[str, IntArray]:
    """Quads of every name, from the names and quads of owners."""
    groups: dict[str, list[IntArray]] = {}
    for names, quads in owned:
        for name in names:
            groups.setdefault(name, []).append(quads)
    return {name: np.concatenate(pieces) for name, pieces in groups.items()}


def factor_mesh(
    sweep: Sweep,
    surfaces: SurfaceMesh,
    placed: FactoredSweep,
    target_faces: IntArray,
    *,
    periodic: bool = False,
    part: str = "part",
    scale: float = 1.0,
    offset: FloatArray | None = None,
    info: dict[str, Any] | None = None,
) -> FactoredMesh:
    """Join the placed layers with the names of the CAD faces."""
    pieces = name_pieces(sweep)
    owner_names = tuple(dict.fromkeys(pieces.values()))
    index = {names: i for i, names in enumerate(owner_names)}
    table = np.zeros(len(sweep.solid.faces), dtype=np.int64)
    patches = {place: index[names] for place, names in pieces.items() if place[1] >= 0}
    for (face, j), names in pieces.items():
        if j < 0:
            table[face] = index[names]
    source = surfaces.source
    structure = SweptStructure(
        quads=source.quads,
        loops=source.loops,
        n_nodes=len(source.points),
        n_layers=len(surfaces.rings) - 1,
        periodic=periodic,
    )
    info = {} if info is None else info
    owners = {}
    first_names = [names[0] for names in owner_names]
    for role, ids, corners in _boundary_quads(surfaces, placed, target_faces):
        owners[role], shares = own_quads(ids, corners, sweep.solid.faces, table, patches)
        info["notes"] = [*info.get("notes", []), *(share.describe(sweep.solid.faces, first_names) for share in shares)]
    return FactoredMesh(
        sweep=placed,
        structure=structure,
        owner_names=owner_names,
        source_owners=owners["source"],
        target_owners=owners["target"],
        side_owners=owners["side"],
        part=part,
        scale=scale,
        offset=np.zeros(3) if offset is None else offset,
        info=info,
    )


def _boundary_quads(
    surfaces: SurfaceMesh, placed: FactoredSweep, target_faces: IntArray
) -> list[tuple[str, IntArray, FloatArray]]:
    """Role, face ids and corners (..., 4, 3) of the quads of source, target and sides."""
    source, rings = surfaces.source, surfaces.rings
    n_layers = len(rings) - 1
    starts = np.concatenate([[0], np.cumsum([len(loop) for loop in source.loops])])
    following = np.concatenate([np.roll(np.arange(a, b), -1) for a, b in pairwise(starts)])
    sides = np.stack([rings[:-1], rings[:-1, following], rings[1:, following], rings[1:]], axis=2)
    target = placed.points(slice(n_layers, n_layers + 1))[0]
    return [
        ("source", source.faces, source.points[source.quads]),
        ("target", target_faces, target[source.quads]),
        ("side", surfaces.side_faces, sides),
    ]


def is_ring(sweep: Sweep) -> bool:
    """Whether the caps lie on each other: a full ring that was cut open, whose mesh closes on itself."""
    faces, size = sweep.solid.faces, sweep.solid.size
    centers = [sum(faces[i].area * faces[i].center for i in cap) for cap in (sweep.source, sweep.target)]
    areas = [sum(faces[i].area for i in cap) for cap in (sweep.source, sweep.target)]
    if abs(areas[0] - areas[1]) > 1e-6 * areas[0]:
        return False
    return bool(np.linalg.norm(centers[0] - centers[1]) <= 1e-6 * areas[0] * size)


def make_reference(part: Part, sweep: Sweep) -> CadReference:
    """Collect what the CAD model says the mesh must be, in model units."""
    solid = sweep.solid
    ring = is_ring(sweep)
    by_name: dict[str, set[int]] = {}
    mixed: list[set[str]] = []  # names of which the mesh knows no lines between: only their common area is known
    for name, pieces in pieces_by_name(sweep).items():
        faces = {i for i, _ in pieces if not (ring and i in (*sweep.source, *sweep.target))}
        if faces:
            by_name[name] = faces
        for i in faces:
            if sum(1 for face, _ in pieces if face == i) < 1 + len(solid.faces[i].patches):
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
        for surface in surfaces:
            left = np.flatnonzero(nearest > close)
            nearest[left] = np.minimum(nearest[left], surface.distance(places[left], close=close))
        return nearest * part.scale

    def area(names: Iterable[str]) -> float:
        return sum(solid.faces[i].area for i in {i for name in names for i in by_name[name]}) * part.scale**2

    return CadReference(
        volume=solid.volume * part.scale**3,
        areas={name: area([name]) for name in by_name if name not in parted},
        joint_areas={tuple(sorted(names)): area(names) for names in mixed},
        euler=0 if ring else euler_characteristic(solid),  # a ring cut open is a ball; closed, it is a torus
        distance=distance,
        rim_distance=_make_rim_distance(part, sweep, set().union(*by_name.values())),
        tolerance=max(1e-6, 2.0 * solid.tolerance / solid.size),
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
    joined: list[set[frozenset[str]]] = []
    for own in owners.values():
        merged = own.union(*(others for others in joined if others & own))
        joined = [others for others in joined if not others & own] + [merged]
    group_of = {owner: j for j, group in enumerate(joined) for owner in group}
    groups = {face: group_of[next(iter(own))] for face, own in owners.items()}
    edges: dict[frozenset[int], list[int]] = {}
    vertices: dict[int, set[int]] = {}
    twins = {t: e for e, (t, _) in sweep.target_edges.items()} if is_ring(sweep) else {}
    twins |= {e: t for t, e in twins.items()}  # of a ring cut open, the sides beside both edges of a pair meet there
    for edge in solid.edges:
        beside = [*edge.faces, *(solid.edges[twins[edge.id]].faces if edge.id in twins else ())]
        around = frozenset(groups[face] for face in beside if face in groups)
        edges.setdefault(around, []).append(edge.id)
        for vertex in (edge.start, edge.end):
            vertices.setdefault(vertex, set()).update(around)

    def rim_distance(points: FloatArray, meeting_owners: frozenset[frozenset[str]]) -> FloatArray:
        meeting = frozenset(group_of[owner] for owner in meeting_owners)
        if len(meeting) == 1:
            return np.zeros(len(points))
        places = (points - part.offset) / part.scale
        away = [solid.edges[e].curve.distance(places) for e in edges.get(meeting, ())]
        if not away:
            corners = [v for v, around in vertices.items() if meeting <= around]
            away = [np.linalg.norm(places - solid.vertices[v], axis=1) for v in corners]
        return np.min([np.full(len(places), np.inf), *away], axis=0) * part.scale

    return rim_distance


def euler_characteristic(solid: Solid) -> int:
    """Vertices - edges + faces of the solid's surface; a face with holes counts 2 - its loops."""
    return len(solid.vertices) - len(solid.edges) + sum(2 - len(face.loops) for face in solid.faces)
