"""Edges and faces of a part of several cells, each meshed once and known by its key.

Place in the flow: after ``intervals`` has counted all edges of the part; ``pipeline`` asks for edges first, then the
grids of logical rectangles, then the caps, and carries quads from cap to cap in between. What a cell needs of its
neighbours it finds here: nodes have their final numbers from the beginning, so that blocks fit without being joined.

A cell whose linking sides no other cell has gets rings that follow the affine image of its source (:mod:`.sides`); its
edges that others have, too, are as they are to these.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray, IntArray
from ..asked import WallLayers
from ..brep import Face, Solid
from ..errors import SurfaceMeshError
from ..mesh import QuadMesh, WallRows
from ..sweep import DirectedEdge, Intervals, LinkingSide, Sweep
from .memory import Memory
from .outline import reversed_loop
from .partners import Partners, image_nodes
from .quads import CapBuilder
from .rings import Rings
from .transfinite import fill, join_chains
from .walls import Walls


@dataclass(frozen=True, kw_only=True, eq=False)
class FaceMesh:
    """The quads of one face.

    Attributes
    ----------
    quads : (q, 4) int64
        Node numbers of the whole part, turned outward as seen from the cell and its face at `place`.
    place : (int, int)
    grid : (h + 1, w + 1) int64 or None
        The nodes in rows and columns, where the face is a logical rectangle.
    patches : mapping of int to (h + 1, w + 1) int64
        The same for every corner of a star, by the key of its vertex.
    """

    quads: IntArray
    place: tuple[int, int]
    grid: IntArray | None = None
    patches: Mapping[int, IntArray] = field(default_factory=dict)


class Skeleton:
    """What has been meshed so far: nodes, edges by key, faces by key."""

    def __init__(
        self,
        solids: Sequence[Solid],
        intervals: Sequence[Intervals],
        *,
        fractions: Mapping[int, FloatArray] | None = None,
        sizes: Mapping[int, Callable[[FloatArray], FloatArray]] | None = None,
        partners: Sequence[Partners] = (),
        walls: Mapping[int, WallLayers] | None = None,
        rings: Mapping[int, Rings] | None = None,
        memory: Memory | None = None,
    ) -> None:
        """`fractions`: by key, arc-length fractions of the nodes of edges that are not divided evenly.

        `sizes`: wanted lengths (m,) at points (m, 3) of sources, by cell, where they are not the same everywhere.
        `partners`: edges and faces that are images of others. `walls`: layers along faces, by key, working units.
        `rings`: of cells whose linking sides are nobody else's. `memory`: faces of caps that were meshed before, of the
        same part with the same sizes.
        """
        self.solids = solids
        self.intervals = intervals
        self.sizes = sizes or {}
        self.partners = [own for one in partners for own in (one, one.inverse())]
        self._images = {b: (a, same, one.motion) for one in partners for a, (b, same) in one.edges.items() if a != b}
        self._cell_of = {
            int(key): (cell, f) for cell, solid in enumerate(solids) for f, key in enumerate(solid.face_keys)
        }
        self._edge_of: dict[int, tuple[Solid, Intervals, int]] = {}
        self.walls = walls or {}
        self.edges: dict[int, IntArray] = {}
        self.fractions: dict[int, FloatArray] = dict(fractions or {})
        self.faces: dict[int, FaceMesh] = {}
        self.rows: dict[int, list[WallRows]] = {}
        self.notes: list[str] = []
        self._memory = memory or Memory()
        self._placed: dict[int, FloatArray] = {}
        for cell, own in (rings or {}).items():
            self._follow(solids[cell], own)
        self._n = 0
        self._table = np.empty((1024, 3))
        self._vertices: dict[int, int] = {}
        for solid, counts in zip(solids, intervals, strict=True):
            for edge, key in enumerate(solid.edge_keys.tolist()):
                self._edge_of.setdefault(key, (solid, counts, edge))
        for solid in solids:
            self._lay_edges(solid)

    @property
    def n_nodes(self) -> int:
        """Nodes so far."""
        return self._n

    def move(self, nodes: IntArray, points: FloatArray) -> None:
        """Put nodes elsewhere."""
        self._table[nodes] = points

    @property
    def points(self) -> FloatArray:
        """All nodes so far (n, 3), working units."""
        return self._table[: self._n]

    def add(self, points: FloatArray) -> IntArray:
        """Number new nodes (m, 3)."""
        first, self._n = self._n, self._n + len(points)
        if self._n > len(self._table):  # twice as much: nodes come face by face
            self._table = np.concatenate([self._table[:first], np.empty((max(self._n, first), 3))])
        self._table[first : self._n] = points
        return np.arange(first, self._n, dtype=np.int64)

    def _follow(self, solid: Solid, rings: Rings) -> None:
        """Take the divisions of edges, and the nodes on sides, of a cell whose rings are placed."""
        for e, fractions in rings.fractions.items():
            self.fractions[int(solid.edge_keys[e])] = fractions
        for side in rings.layout.sides:
            self._placed[int(solid.face_keys[side.side.face])] = rings.points[rings.layout.block(side)]
        self.notes += rings.notes

    def _lay_edges(self, solid: Solid) -> None:
        for vertex, key in enumerate(solid.vertex_keys.tolist()):
            if key not in self._vertices:
                self._vertices[key] = int(self.add(solid.vertices[vertex][None])[0])
        for key in solid.edge_keys.tolist():
            self._lay_edge(key)

    def _lay_edge(self, key: int) -> None:
        if key in self.edges:
            return
        solid, intervals, e = self._edge_of[key]
        edge = solid.edges[e]
        n = int(intervals.counts[e])
        fractions = self.fractions.setdefault(key, np.linspace(0.0, 1.0, n + 1))
        if key in self._images:
            other, same, motion = self._images[key]
            self._lay_edge(other)
            inner = motion(self.points[self.edges[other]])[:: 1 if same else -1][1:-1]
        else:
            inner = np.asarray(edge.curve.evaluate(fractions))[1:-1]
        for v in (edge.start, edge.end):
            vertex = int(solid.vertex_keys[v])
            if vertex not in self._vertices:
                self._vertices[vertex] = int(self.add(solid.vertices[v][None])[0])
        ends = [self._vertices[int(solid.vertex_keys[v])] for v in (edge.start, edge.end)]
        self.edges[key] = np.concatenate([ends[:1], self.add(inner), ends[1:]]).astype(np.int64)

    def chain(self, cell: int, chain: Sequence[DirectedEdge]) -> IntArray:
        """Nodes along directed edges of a cell."""
        keys = self.solids[cell].edge_keys
        return join_chains([self.edges[int(keys[e])][:: 1 if forward else -1] for e, forward in chain])

    def lay_grid(self, cell: int, side: LinkingSide) -> None:
        """Fill a logical rectangle, unless a neighbour did.

        Raises
        ------
        SurfaceMeshError
            Opposite chains have unlike counts, or the surface gives no finite points.
        """
        solid = self.solids[cell]
        key = int(solid.face_keys[side.face])
        if key in self.faces:
            return
        face = solid.faces[side.face]
        chains = [self.chain(cell, chain) for chain in (side.bottom, side.right, side.top, side.left)]
        if len(chains[0]) != len(chains[2]) or len(chains[1]) != len(chains[3]):
            raise SurfaceMeshError(f"{face.label()} has {[len(c) - 1 for c in chains]} segments on its four sides")
        filled = self._placed.get(key)
        if filled is None:
            filled = self._filled(cell, side, face, chains)
        h, w = filled.shape[0] - 1, filled.shape[1] - 1
        grid = np.empty((h + 1, w + 1), dtype=np.int64)
        grid[1:-1, 1:-1] = self.add(filled[1:-1, 1:-1].reshape(-1, 3)).reshape(h - 1, w - 1)
        grid[0], grid[:, -1], grid[-1], grid[:, 0] = chains
        self._take(key, FaceMesh(quads=grid_quads(grid), place=(cell, side.face), grid=grid))

    def _filled(self, cell: int, side: LinkingSide, face: Face, chains: Sequence[IntArray]) -> FloatArray:
        points = self.points
        chains_uv = tuple(
            join_chains([self.edge_uv(cell, face, e)[:: 1 if forward else -1] for e, forward in chain])
            for chain in (side.bottom, side.right, side.top, side.left)
        )
        filled, _, worst = fill(face.surface, chains_uv, tuple(points[c] for c in chains))
        if not np.isfinite(filled).all():
            raise SurfaceMeshError(f"{face.label()} could not be filled: its surface gives no finite points")
        if worst <= 0:
            self.notes.append(f"{face.label()}: its quads are folded at the worst corner (sine {worst:.2g})")
        return filled

    def _take(self, key: int, mesh: FaceMesh) -> None:
        """Keep the mesh of a face, and its image as that of the face's partner."""
        self.faces[key] = mesh
        for own in self.partners:
            other = own.faces.get(key)
            if other is None or other in self.faces:
                continue
            (cell, f), (there, g) = self._cell_of[key], self._cell_of[other]
            face, image = self.solids[cell].faces[f], self.solids[there].faces[g]
            edges = [int(self.solids[cell].edge_keys[e]) for e in face.edges]
            nodes = image_nodes(mesh.quads, self.points, own, self.edges, edges, self.add)
            quads = nodes[self.quads_of(cell, f)]
            faces_away = float((own.motion.matrix @ face.normal) @ image.normal) > 0
            self._take(
                other,
                FaceMesh(
                    quads=quads if faces_away else quads[:, ::-1],
                    place=(there, g),
                    grid=None if mesh.grid is None else nodes[mesh.grid],
                ),
            )

    def edge_uv(self, cell: int, face: Face, edge: int) -> FloatArray:
        """Parameters on a face of the nodes of one of its edges, from the edge's start to its end."""
        return face.surface.edge_uv(edge, self.fractions[int(self.solids[cell].edge_keys[edge])])

    def lay_source(self, cell: int, sweep: Sweep, opposite: FloatArray | None = None) -> None:
        """Mesh the faces of a source cap that no neighbour has meshed with quads of any kind.

        `opposite`: angles of the ring's nodes on the target, where they are others than on the source.

        Raises
        ------
        SurfaceMeshError
            It cannot be meshed with quads alone.
        """
        solid = self.solids[cell]
        left = [f for f in sweep.source if int(solid.face_keys[f]) not in self.faces]
        if len(left) == len(sweep.source):
            self._lay_cap(cell, sweep, opposite)
            return
        for face in left:
            loops = tuple(tuple(reversed_loop(loop.directed)) for loop in solid.faces[face].loops)
            self._lay_cap(cell, replace(sweep, source=(face,), source_loops=loops, target_loops=loops), None)

    def build_cap(
        self, cell: int, cap: Sweep, opposite: FloatArray | None = None, walls: Walls | None = None
    ) -> QuadMesh:
        """Quads of a cap in numbers of their own, the ring's first, and nothing kept of it.

        `walls`: edges along which rows are laid, where they are not below faces that have layers.

        Raises
        ------
        SurfaceMeshError
            It cannot be meshed with quads alone.
        """
        solid = self.solids[cell]
        keys = solid.edge_keys
        rings = [self.chain(cell, loop)[:-1] for loop in cap.source_loops]
        ring = np.concatenate(rings)
        starts = np.cumsum([0, *(len(r) for r in rings)])
        edges = {e for f in cap.source for e in solid.faces[f].edges}
        builder = CapBuilder(
            cap,
            self.intervals[cell],
            self.points[ring],
            [np.arange(a, b, dtype=np.int64) for a, b in pairwise(starts)],
            np.full(len(ring), np.nan) if opposite is None else opposite,
            sizes=partial(_at_most, self.intervals[cell].size, self.sizes[cell]) if cell in self.sizes else None,
            memory=self._memory,
            graded={e: self.fractions[int(keys[e])] for e in edges},
            walls=walls or self._walls_at(solid, cap.source),
        )
        made = builder.build()
        self.notes += builder.notes
        return made

    def _lay_cap(self, cell: int, cap: Sweep, opposite: FloatArray | None) -> None:
        solid = self.solids[cell]
        keys = solid.edge_keys
        made = self.build_cap(cell, cap, opposite)
        ring = np.concatenate([self.chain(cell, loop)[:-1] for loop in cap.source_loops])
        numbers = np.full(len(made.points), -1, dtype=np.int64)
        numbers[: len(ring)] = ring
        for e, nodes in made.edge_nodes.items():
            numbers[nodes] = self.edges[int(keys[e])]
        new = np.flatnonzero(numbers < 0)
        numbers[new] = self.add(made.points[new])
        around = numbers[np.concatenate(made.loops)]
        self.rows.setdefault(cell, []).extend(
            replace(rows, ring=around[rows.ring], nodes=numbers[rows.nodes]) for rows in made.walls
        )
        for face in cap.source:
            quads = numbers[made.quads[made.faces == face]][:, ::-1]
            self._take(int(solid.face_keys[face]), FaceMesh(quads=quads, place=(cell, face)))

    def _walls_at(self, solid: Solid, cap: Sequence[int]) -> Walls | None:
        """The edges of a cap at which walls with layers stand."""
        layers: dict[int, WallLayers] = {}
        faces = set()
        for e in (e for f in cap for e in solid.faces[f].edges):
            for other in solid.edges[e].faces:
                key = int(solid.face_keys[other])
                if other not in cap and key in self.walls:
                    layers[e] = self.walls[key]
                    faces.add(other)
        return Walls(layers=layers, faces=frozenset(faces)) if layers else None

    def keep_patches(self, cell: int, face: int, patches: Mapping[int, IntArray]) -> None:
        """Keep the patches of a star, each turned outward as seen from the cell."""
        quads = np.concatenate([grid_quads(patch) for patch in patches.values()])
        self._take(int(self.solids[cell].face_keys[face]), FaceMesh(quads=quads, place=(cell, face), patches=patches))

    def keep(self, cell: int, face: int, quads: IntArray) -> None:
        """Keep quads (q, 4) that were carried to a face, outward from the cell that they were carried through."""
        self._take(int(self.solids[cell].face_keys[face]), FaceMesh(quads=quads, place=(cell, face)))

    def quads_of(self, cell: int, face: int) -> IntArray:
        """Quads (q, 4) of a meshed face, outward as seen from a cell."""
        mesh = self.faces[int(self.solids[cell].face_keys[face])]
        return mesh.quads if mesh.place == (cell, face) else mesh.quads[:, ::-1]

    def grid_of(self, cell: int, side: LinkingSide) -> IntArray:
        """Nodes (h + 1, w + 1) of a logical rectangle, rows along its bottom, from bottom to top."""
        key = int(self.solids[cell].face_keys[side.face])
        grid = self.faces[key].grid
        assert grid is not None, "a linking side has a grid"
        corners = [self.chain(cell, side.bottom)[[0, -1]], self.chain(cell, side.top)[[0, -1]]]
        found = turn_grid(grid, np.array(corners))
        if found is None:
            raise SurfaceMeshError(f"{self.solids[cell].faces[side.face].label()} has other corners in its neighbour")
        return found


def _at_most(size: float, sizes: Callable[[FloatArray], FloatArray], points: FloatArray) -> FloatArray:
    return np.minimum(sizes(points), size)


def grid_quads(grid: IntArray) -> IntArray:
    """Quads (q, 4) of nodes (h + 1, w + 1) in rows, the normal along rows times columns upward."""
    return np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=-1).reshape(-1, 4)


def turn_grid(grid: IntArray, corners: IntArray) -> IntArray | None:
    """The grid seen so that its corners are as given (2, 2); None where no turn or flip does that."""
    for one in (grid, grid.T):
        for rows in (1, -1):
            for columns in (1, -1):
                seen = one[::rows, ::columns]
                if (seen[[0, 0, -1, -1], [0, -1, 0, -1]] == corners.ravel()).all():
                    return seen
    return None
