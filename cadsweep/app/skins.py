"""What is seen of a mesh: the outside of the hexahedra that are kept, coloured by a figure of each.

Place in the flow: made once for a mesh, in a thread; every look is answered from its tables.

Method: each quad of the mesh is known with the hexahedra on its two sides. Whatever is kept, the quads that are seen
are those with one side kept and the other not: a clip of a million hexahedra is one comparison of three million pairs,
and only what is seen is sent. Layers from the boundary are counted once, by going from side to side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray
from ..cells import HEX_FACES
from ..mesh import HexMesh
from ..quality import scaled_jacobians

BINS = 40


@dataclass(frozen=True, kw_only=True)
class Look:
    """How a mesh is looked at.

    Attributes
    ----------
    axis : str
        ``"x"``, ``"y"``, ``"z"`` of the plane that clips; empty for none.
    place : float
        Where it is, from 0 to 1 along the axis.
    turned : bool
        The other side is taken away.
    peel : int
        Layers of hexahedra that are taken away from the boundary.
    apart : float
        How far blocks are drawn apart, over their distance from the middle.
    color : str
        ``"quality"``, ``"size"``, ``"solid"``, ``"cell"``, ``"distance"``.
    low, high : float
        Only hexahedra with a scaled Jacobian from `low` to `high` are shown.
    only : int
        A hexahedron to be shown with those around it; -1 for all.
    """

    axis: str = ""
    place: float = 0.5
    turned: bool = False
    peel: int = 0
    apart: float = 0.0
    color: str = "quality"
    low: float = -1.0
    high: float = 1.0
    only: int = -1


@dataclass(frozen=True, kw_only=True, eq=False)
class Surface:
    """What is seen of a mesh.

    Attributes
    ----------
    points : (p, 3) float64
    quads : (s, 4) int64
        On these points, outward.
    behind : (s,) int64
        The hexahedron behind each.
    rows : (s,) int64
        Which of the mesh's quads each is.
    n_shown : int
        Hexahedra that are kept.
    """

    points: FloatArray
    quads: IntArray
    behind: IntArray
    rows: IntArray
    n_shown: int


@dataclass(kw_only=True, eq=False)
class MeshView:
    """Tables of a mesh for looking at it.

    Attributes
    ----------
    mesh : HexMesh
    corners : (m, 8) int64
    quads : (q, 4) int64
        Every quad once, outward from its first hexahedron.
    sides : (q, 2) int64
        The hexahedra on its sides; -1 outside.
    quality, size : (m,) float64
        Scaled Jacobian; cube root of the volume.
    solid, cell : (m,) int64
        Which solid and which block each hexahedron is of.
    known_distances : dict of str to (k,) float64
        Distances from the CAD, model units, of the quads of boundaries by name.
    """

    mesh: HexMesh
    corners: IntArray
    quads: IntArray
    sides: IntArray
    quality: FloatArray
    size: FloatArray
    solid: IntArray
    cell: IntArray
    known_distances: Mapping[str, FloatArray] = field(default_factory=dict)
    _levels: IntArray | None = field(default=None, repr=False)

    @cached_property
    def centers(self) -> FloatArray:
        """Middles of the hexahedra (m, 3), single precision."""
        found = np.zeros((len(self.corners), 3), dtype=np.float32)
        points = self.mesh.points.astype(np.float32)
        for j in range(8):
            found += points[self.corners[:, j]]
        return found / 8

    @cached_property
    def bounds(self) -> FloatArray:
        """Lowest and highest coordinates, (2, 3)."""
        return np.array([self.mesh.points.min(axis=0), self.mesh.points.max(axis=0)])

    @property
    def levels(self) -> IntArray:
        """How many hexahedra lie between each one and the boundary, (m,)."""
        if self._levels is None:
            self._levels = _levels(len(self.corners), self.sides)
        return self._levels

    @property
    def n_blocks(self) -> int:
        """Blocks that can be drawn apart: cells, or else solids."""
        return int(self.cell.max()) + 1

    def kept(self, look: Look) -> BoolArray:
        """Which hexahedra are shown, (m,)."""
        kept = np.ones(len(self.corners), dtype=bool)
        if look.axis:
            axis = "xyz".index(look.axis)
            low, high = self.bounds[:, axis]
            behind = self.centers[:, axis] <= low + look.place * (high - low)
            kept &= ~behind if look.turned else behind
        if look.peel:
            kept &= self.levels >= look.peel
        if look.low > -1.0 or look.high < 1.0:
            kept &= (self.quality >= look.low) & (self.quality <= look.high)
        if look.only >= 0:
            nodes = np.zeros(self.mesh.n_nodes, dtype=bool)
            nodes[self.corners[look.only]] = True
            kept &= nodes[self.corners].any(axis=1)
        return kept

    def _seen(self, kept: BoolArray, *, apart: bool) -> tuple[IntArray, IntArray, IntArray]:
        """Rows of the quads that are seen of the hexahedra kept, the quads outward, and the hexahedron behind each.

        With `apart` the quads between two blocks are seen, too, from both.
        """
        first, second = self.sides[:, 0], self.sides[:, 1]
        of_first = kept[first]
        of_second = kept[second] & (second >= 0)
        bare = np.zeros(len(self.quads), dtype=bool)
        if apart:
            bare = (second >= 0) & (self.cell[first] != self.cell[second])
        forward = np.flatnonzero(of_first & (~of_second | bare))
        backward = np.flatnonzero(of_second & (~of_first | bare))
        quads = np.concatenate([self.quads[forward], self.quads[backward][:, ::-1]])
        return np.concatenate([forward, backward]), quads, np.concatenate([first[forward], second[backward]])

    def surface(self, look: Look) -> Surface:
        """What is seen of the mesh."""
        apart = look.apart > 0 and self.n_blocks > 1
        kept = self.kept(look)
        rows, quads, behind = self._seen(kept, apart=apart)
        if apart:
            # A node that two blocks share is drawn in both places.
            used, inverse = np.unique(quads + self.mesh.n_nodes * self.cell[behind][:, None], return_inverse=True)
            block, node = np.divmod(used, self.mesh.n_nodes)
            points = self.mesh.points[node] + look.apart * self._moves()[block]
        else:
            used, inverse = np.unique(quads, return_inverse=True)
            points = self.mesh.points[used]
        return Surface(
            points=points, quads=inverse.reshape(quads.shape), behind=behind, rows=rows, n_shown=int(kept.sum())
        )

    def _moves(self) -> FloatArray:
        """Away from the middle of all, for each block, (n_blocks, 3)."""
        n = np.maximum(np.bincount(self.cell, minlength=self.n_blocks), 1)
        middles = np.column_stack(
            [np.bincount(self.cell, weights=self.centers[:, j], minlength=self.n_blocks) / n for j in range(3)]
        )
        return middles - self.bounds.mean(axis=0)

    def histogram(self) -> tuple[FloatArray, IntArray]:
        """Edges (BINS + 1,) and counts (BINS,) of the scaled Jacobian, from the worst that is in a round bin to 1."""
        low = min(0.0, float(np.floor(self.quality.min() * 10) / 10))
        counts, edges = np.histogram(self.quality, bins=BINS, range=(low, 1.0))
        return edges, counts

    def worst(self, n: int = 10) -> IntArray:
        """Ids of the hexahedra with the least scaled Jacobian, the worst first."""
        n = min(n, len(self.quality))
        found = np.argpartition(self.quality, n - 1)[:n]
        return found[np.argsort(self.quality[found], kind="stable")]

    @cached_property
    def names(self) -> list[str]:
        """Names of boundaries, then of interfaces."""
        return [*self.mesh.boundaries, *self.mesh.interfaces]

    @cached_property
    def owners(self) -> IntArray:
        """For each row of `quads` its place in `names`, of the smallest of several; -1 inside."""
        owners = np.full(len(self.quads), -1, dtype=np.int64)
        every = [*self.mesh.boundaries.values(), *self.mesh.interfaces.values()]
        for number in sorted(range(len(every)), key=lambda j: -len(every[j])):
            owners[self._find(every[number][:, :4])] = number
        return owners

    @cached_property
    def distances(self) -> FloatArray | None:
        """Distance from the CAD of each row of `quads`, (q,); nan where it is not known."""
        if not self.known_distances:
            return None
        found = np.full(len(self.quads), np.nan)
        for name, values in self.known_distances.items():
            found[self._find(self.mesh.boundaries[name][:, :4])] = values
        return found if np.isfinite(found).any() else None

    @cached_property
    def _ordered(self) -> tuple[np.ndarray, IntArray]:
        keys = _quad_keys(_marks(self.mesh.n_nodes), self.quads)
        order = np.argsort(keys)
        return keys[order], order

    def _find(self, quads: IntArray) -> IntArray:
        """Rows of `quads` that have the corners of others (k, 4), all of which are of the mesh."""
        keys, order = self._ordered
        found: IntArray = order[np.searchsorted(keys, _quad_keys(_marks(self.mesh.n_nodes), quads))]
        return found


def make_view(mesh: HexMesh, distances: Mapping[str, FloatArray] | None = None) -> MeshView:
    """Make the tables; a second for a million hexahedra."""
    corners = mesh.hexes[:, :8]
    quads, sides = find_quads(corners)
    solid = np.zeros(mesh.n_hexes, dtype=np.int64)
    for j, ids in enumerate(mesh.parts.values()):
        solid[ids] = j
    blocks = list(mesh.info.get("blocks") or ())
    cell = np.repeat(np.arange(len(blocks)), blocks) if sum(blocks) == mesh.n_hexes else solid
    return MeshView(
        mesh=mesh,
        corners=corners,
        quads=quads,
        sides=sides,
        quality=scaled_jacobians(mesh.points, corners),
        size=np.cbrt(np.abs(_volumes(mesh.points, corners))),
        solid=solid,
        cell=cell,
        known_distances=distances or {},
    )


def find_quads(corners: IntArray) -> tuple[IntArray, IntArray]:
    """Every quad (q, 4) of hexahedra (m, 8) once, and the hexahedra (q, 2) on its sides, -1 outside.

    Two quads are one where their corners have the same sum of random 64-bit numbers, one a node: of ten million quads
    two others are taken for one with a chance of one in a hundred thousand, and then a picture has a hole.
    """
    n_hexes = len(corners)
    of_corners = _marks(int(corners.max()) + 1)[corners]
    a, b, c, d = (of_corners[:, HEX_FACES[:, j]] for j in range(4))
    keys = (a + b + c + d).T.ravel()
    order = np.argsort(keys, kind="stable")
    ordered = keys[order]
    same = ordered[1:] == ordered[:-1]
    begins = np.flatnonzero(np.concatenate([[True], ~same]))
    first = order[begins]
    doubled = np.concatenate([same, [False]])[begins]
    second = np.full(len(first), -1, dtype=np.int64)
    second[doubled] = order[begins[doubled] + 1] % n_hexes
    face, hexahedron = np.divmod(first, n_hexes)
    quads = corners[hexahedron[:, None], HEX_FACES[face]]
    return quads, np.column_stack([hexahedron, second])


def _marks(n_nodes: int) -> np.ndarray:
    """A random number for every node, the same every time."""
    return np.random.default_rng(2026).integers(0, 2**63, size=n_nodes, dtype=np.uint64)


def _quad_keys(marks: np.ndarray, quads: IntArray) -> np.ndarray:
    """What tells quads (k, 4) apart, whichever corner they begin with."""
    a, b, c, d = (marks[quads[:, j]] for j in range(4))
    keys: np.ndarray = a + b + c + d
    return keys


def _volumes(points: FloatArray, corners: IntArray) -> FloatArray:
    """Volumes of hexahedra with plane sides, by three products at the middle."""
    a = points[corners]
    u = a[:, [1, 2, 5, 6]].sum(axis=1) - a[:, [0, 3, 4, 7]].sum(axis=1)
    v = a[:, [2, 3, 6, 7]].sum(axis=1) - a[:, [0, 1, 4, 5]].sum(axis=1)
    w = a[:, 4:].sum(axis=1) - a[:, :4].sum(axis=1)
    found: FloatArray = np.einsum("ij,ij->i", np.cross(u, v), w) / 64.0
    return found


def _levels(n_hexes: int, sides: IntArray) -> IntArray:
    """How many quads must be crossed from the boundary to each hexahedron, less one."""
    outside = sides[:, 1] < 0
    levels = np.full(n_hexes, -1, dtype=np.int64)
    levels[sides[outside, 0]] = 0
    a, b = sides[~outside].T
    level = 0
    while True:
        one, other = levels[a], levels[b]
        left = (one < 0) | (other < 0)
        a, b, one, other = a[left], b[left], one[left], other[left]
        reached = np.concatenate([b[(one == level) & (other < 0)], a[(other == level) & (one < 0)]])
        if not len(reached):
            return levels
        level += 1
        levels[reached] = level
