"""From layers of nodes to a named mesh: which quads bound which face, and what the face is called.

Place in the flow: after ``projection`` and ``smoothing``, before ``quality``. A :class:`FactoredMesh` is
the whole mesh in a few megabytes: the factors, the moved nodes, and the owner of every boundary quad.
It is what a file of factors holds, what MPI ranks share, and what slabs are streamed from.

Every boundary quad belongs to exactly one CAD face, and every CAD face to exactly one name, so the
boundaries of a mesh never overlap.
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


def name_faces(sweep: Sweep) -> dict[int, str]:
    """Name every face of the solid.

    A face keeps the name that its user gave it. The others are ``source``, ``target`` and
    ``side_1``, ``side_2``, ... in the order of the loops; a cap of several unnamed faces is
    ``source_1``, ``source_2``, ... Pieces of one divided face share a name.

    Returns
    -------
    dict of int to str
        Face id to boundary name.
    """
    return {f: name for (f, j), name in _name_pieces(sweep).items() if j < 0}


def _name_pieces(sweep: Sweep) -> dict[tuple[int, int], str]:
    """Names of the faces (face id, -1) and of their patches (face id, number)."""
    faces = sweep.solid.faces
    roles = [("source", sweep.source), ("target", sweep.target), ("side", [s.face for s in sweep.linking_sides])]
    names: dict[tuple[int, int], str] = {}
    pieces: list[tuple[str, list[tuple[tuple[int, int], str | None, str]]]] = []
    for role, ids in roles:
        own: list[tuple[tuple[int, int], str | None, str]] = []
        for i in ids:
            own.append(((i, -1), faces[i].name, faces[i].key or f"face {i}"))
            own += [((i, j), patch.name, patch.key) for j, patch in enumerate(faces[i].patches)]
        pieces.append((role, own))
    taken = {name for _, own in pieces for _, name, _ in own if name}
    for role, own in pieces:
        numbers: dict[str, int] = {}
        for _, name, key in own:
            if not name:
                numbers.setdefault(key, len(numbers) + 1)
        for place, given, key in own:
            name = given
            if not name:
                name = role if role != "side" and len(numbers) == 1 else f"{role}_{numbers[key]}"
                while name in taken:
                    name += "_"
            names[place] = name
    return names


@dataclass(frozen=True, kw_only=True, eq=False)
class FactoredMesh:
    """A swept mesh that is not yet multiplied out.

    Attributes
    ----------
    sweep : FactoredSweep
        Places of the nodes, working units.
    structure : SweptStructure
    names : tuple of str
        Boundary names; the owners below are indices into it.
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
    names: tuple[str, ...]
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
        return self.sweep.corrections is not None or len(self.moved_nodes) > 0

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

    def boundaries(self) -> dict[str, IntArray]:
        """Outward boundary quads (m, 4) by name: source, target, sides."""
        s = self.structure
        sides = side_quads(s.loops, s.n_nodes, s.n_layers, periodic=s.periodic).reshape(-1, 4)
        blocks = [(sides, self.side_owners.reshape(-1))]
        if not s.periodic:
            blocks = [
                (s.quads[:, ::-1], self.source_owners),
                (s.quads + s.n_layers * s.n_nodes, self.target_owners),
                *blocks,
            ]
        groups: dict[str, list[IntArray]] = {}
        for quads, owners in blocks:
            order = np.argsort(owners, kind="stable")
            ids, starts = np.unique(owners[order], return_index=True)
            for owner, chosen in zip(ids, np.split(order, starts[1:]), strict=True):
                groups.setdefault(self.names[int(owner)], []).append(quads[chosen])
        return {name: np.concatenate(parts) for name, parts in groups.items()}

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
    pieces = _name_pieces(sweep)
    names = tuple(dict.fromkeys(pieces.values()))
    index = {name: i for i, name in enumerate(names)}
    table = np.zeros(len(sweep.solid.faces), dtype=np.int64)
    patches = {place: index[name] for place, name in pieces.items() if place[1] >= 0}
    for (face, j), name in pieces.items():
        if j < 0:
            table[face] = index[name]
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
    for role, ids, corners in _boundary_quads(surfaces, placed, target_faces):
        owners[role], shares = own_quads(ids, corners, sweep.solid.faces, table, patches)
        info["notes"] = [*info.get("notes", []), *(share.describe(sweep.solid.faces, names) for share in shares)]
    return FactoredMesh(
        sweep=placed,
        structure=structure,
        names=names,
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
    by_name: dict[str, list[int]] = {}
    mixed: list[set[str]] = []  # names that share faces, so that only their common area is known
    for (face, _), name in _name_pieces(sweep).items():
        if not (ring and face in (*sweep.source, *sweep.target)):
            by_name.setdefault(name, []).append(face)
    for one in solid.faces:
        joined = {name for name, ids in by_name.items() if one.id in ids}
        if len(joined) > 1:
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
        areas={name: area([name]) for name in by_name if not any(name in names for names in mixed)},
        joint_areas={tuple(sorted(names)): area(names) for names in mixed},
        euler=0 if ring else euler_characteristic(solid),  # a ring cut open is a ball; closed, it is a torus
        distance=distance,
        rim_distance=_make_rim_distance(part, solid, by_name, mixed),
        tolerance=max(1e-6, 2.0 * solid.tolerance / solid.size),
    )


def _make_rim_distance(
    part: Part, solid: Solid, by_name: dict[str, list[int]], mixed: list[set[str]]
) -> Callable[[FloatArray, frozenset[str]], FloatArray]:
    """Distances from the edges that two boundaries share, and from the vertices where more of them meet."""
    # Between boundaries that share a face there may be no edge: they count as one.
    group_of = {name: min(next((names for names in mixed if name in names), {name})) for name in by_name}
    groups = {face: group_of[name] for name, faces in by_name.items() for face in faces}
    edges: dict[frozenset[str], list[int]] = {}
    vertices: dict[int, set[str]] = {}
    for edge in solid.edges:
        around = frozenset(groups[face] for face in edge.faces if face in groups)
        edges.setdefault(around, []).append(edge.id)
        for vertex in (edge.start, edge.end):
            vertices.setdefault(vertex, set()).update(around)

    def rim_distance(points: FloatArray, names: frozenset[str]) -> FloatArray:
        meeting = frozenset(group_of[name] for name in names)
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
