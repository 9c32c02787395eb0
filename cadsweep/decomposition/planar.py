"""A planar complex: cells with plane faces that share vertices, edges and faces.

Place in the flow: what the search for cuts works on where all faces of a solid are planes. A cut through one cell
divides the faces of its neighbours with it, so the complex agrees everywhere at every step; OpenCASCADE repeats only
the cuts that are taken.

Vertices and facets live in one pool, are never changed, and are known by what they are: a complex is nothing but a
tuple of cells, a cell a tuple of directed facets. Two states of the search share most of theirs, so whatever is found
out about a cell is found out once.

Not handled: curved faces and edges.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

from ..brep import Solid
from .tracing import Loop, area_vector
from .vectors import Vector, dot, minus, plus, times, to_vector, unit

Use = tuple[int, int]
"""A facet, and 1 where its normal points out of the cell, else -1."""
Cell = tuple[Use, ...]
Pair = tuple[int, int]
"""An edge by its two vertices."""

MERGED = 1e-9
"""Distance, as a share of the part's size, below which two points are one vertex."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Facet:
    """A plane polygon with holes.

    Attributes
    ----------
    loops : tuple of tuple of int
        Vertices, outer loop first, the polygon on the left for one whose head points along the normal.
    normal : (3,) unit vector
    offset : float
        ``normal . x`` of its points.
    area : float
    center : (3,)
    origin : int
        Face of the model's solid that it is a piece of; below zero for faces of cuts.
    """

    loops: tuple[Loop, ...]
    normal: Vector
    offset: float
    area: float
    center: Vector
    origin: int

    @cached_property
    def pairs(self) -> frozenset[Pair]:
        """Its directed edges."""
        return frozenset(pair for loop in self.loops for pair in zip(loop, loop[1:] + loop[:1], strict=True))

    @cached_property
    def vertices(self) -> frozenset[int]:
        """All its vertices."""
        return frozenset(v for loop in self.loops for v in loop)


@dataclass(kw_only=True, eq=False)
class Pool:
    """Vertices and facets of all complexes of one search.

    Attributes
    ----------
    points : list of (3,)
        By vertex.
    facets : list of Facet
    size : float
        Diagonal of the part's box.
    """

    size: float
    points: list[Vector] = field(default_factory=list)
    facets: list[Facet] = field(default_factory=list)
    _at: dict[tuple[int, int, int], int] = field(default_factory=dict)
    _known: dict[tuple[int, frozenset[Pair]], int] = field(default_factory=dict)
    _edges: dict[Pair, int] = field(default_factory=dict)

    def vertex(self, point: Vector) -> int:
        """The vertex at a point, a new one where none is there."""
        grain = MERGED * self.size
        low = [round(x / grain - 0.5) for x in point]
        for i in (low[0], low[0] + 1):
            for j in (low[1], low[1] + 1):
                for k in (low[2], low[2] + 1):
                    found = self._at.get((i, j, k))
                    if found is not None:
                        return found
        self._at[(round(point[0] / grain), round(point[1] / grain), round(point[2] / grain))] = len(self.points)
        self.points.append(point)
        return len(self.points) - 1

    def edge_key(self, a: int, b: int) -> int:
        """Number of the edge between two vertices."""
        return self._edges.setdefault((min(a, b), max(a, b)), len(self._edges))

    def facet(self, loops: tuple[Loop, ...], normal: Vector, offset: float, origin: int) -> int:
        """The facet with these loops, a new one where none is known."""
        pairs = frozenset(pair for loop in loops for pair in zip(loop, loop[1:] + loop[:1], strict=True))
        known = self._known.get((origin, pairs))
        if known is not None:
            return known
        vector, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for loop in loops:
            own, first = area_vector([self.points[v] for v in loop])
            vector, moment = plus(vector, own), plus(moment, _moment(self.points, loop, normal))
        area = dot(vector, normal)
        center = times(1.0 / area, moment) if area else first
        found = Facet(loops=loops, normal=normal, offset=offset, area=area, center=center, origin=origin)
        self._known[origin, pairs] = len(self.facets)
        self.facets.append(found)
        return len(self.facets) - 1

    def volume(self, cell: Cell) -> float:
        """Volume of a cell, or of a shell of it: negative where the shell bounds a void."""
        return sum(sign * self.facets[f].offset * self.facets[f].area for f, sign in cell) / 3.0

    def uses(self, cell: Cell) -> dict[Pair, list[Use]]:
        """For every undirected edge of the cell, the facets at it."""
        found: dict[Pair, list[Use]] = {}
        for f, sign in cell:
            for a, b in self.facets[f].pairs:
                found.setdefault((a, b) if a < b else (b, a), []).append((f, sign))
        return found

    def directed_loops(self, use: Use) -> tuple[Loop, ...]:
        """Loops of a facet as they are seen from outside the cell."""
        loops = self.facets[use[0]].loops
        return loops if use[1] > 0 else tuple(loop[::-1] for loop in loops)

    def outward(self, use: Use) -> Vector:
        """Normal out of the cell."""
        return times(use[1], self.facets[use[0]].normal)


def _moment(points: list[Vector], loop: Loop, normal: Vector) -> Vector:
    """First moment of the area that a loop encloses."""
    base = points[loop[0]]
    total = (0.0, 0.0, 0.0)
    for a, b in pairwise(loop[1:]):
        one, other = minus(points[a], base), minus(points[b], base)
        vector, _ = area_vector([(0.0, 0.0, 0.0), one, other])
        share = dot(vector, normal) / 3.0
        total = plus(total, times(share, plus(plus(points[a], points[b]), base)))
    return total


def is_planar(solid: Solid) -> bool:
    """Whether all faces are planes between straight edges that lie on them, and no two of these are one."""
    if any(face.kind != "plane" or face.tips for face in solid.faces):
        return False
    if any(edge.kind != "line" for edge in solid.edges):
        return False
    pool, cell = from_solid(solid)
    return all(len(uses) == 2 for uses in pool.uses(cell).values())


def from_solid(solid: Solid) -> tuple[Pool, Cell]:
    """A pool, and the solid as a cell of it."""
    pool = Pool(size=solid.size)
    number = [pool.vertex(to_vector(point)) for point in solid.vertices]
    cell = []
    for face in solid.faces:
        loops = tuple(tuple(number[solid.first_vertex(directed)] for directed in loop.directed) for loop in face.loops)
        vector = (0.0, 0.0, 0.0)
        for loop in loops:
            vector = plus(vector, area_vector([pool.points[v] for v in loop])[0])
        normal = unit(vector)
        vertices = [v for loop in loops for v in loop]
        offset = sum(dot(normal, pool.points[v]) for v in vertices) / len(vertices)
        cell.append((pool.facet(loops, normal, offset, face.id), 1))
    return pool, tuple(cell)
