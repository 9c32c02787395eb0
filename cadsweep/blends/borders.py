"""Borders of blends as lines of a carried mesh, where straight lines of its quads run along them.

Place in the flow: once a mesh of the design lies on the model and is valid there; ``pipeline`` checks it again.

Method: smooth edges within a patch are borders, in runs between the places where others meet them. Such a place goes to
one node near to it, the end of a run on an edge of the model to a node of the line there. From node to node leads what
goes straight on through quads, four around every node, nowhere farther off the border than a share of the quads beside
it. As many have a line as can, the nearest; what makes hexahedra poor, or quads farther off the model, is given up.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array
from scipy.spatial import cKDTree

from ..arrays import FloatArray, IntArray
from ..brep import Curve, Solid
from ..harmonic import sides_of
from ..quality import scaled_jacobians
from ..quality.deviation import quad_sags
from .carrying import Carried, fractions_of, spread
from .finding import Blend
from .patches import PatchSurface
from .runs import LaidLine, Run, as_curve, chained, is_line

BORDERS = "design: lines on borders"
"""The name among the rows of tables that may be switched off."""
_REACH, _INSIDE = 0.9, 1.6
"""Distance of a node from its border at most, as a share of the quads across it, and how many times that counts within
the blend."""
_ON = 1e-6
"""Share of the solid's size within which a vertex is on a line of the mesh."""
_ASKED = 4
"""Nodes that the end of a run may go to: as many as the corners of the quad that it is in."""
_TURNS = 6
"""Times that the borders nearest to what is poor are given up; half of all then, so that it ends."""
_GAP, _SECONDS = 0.01, 5.0
"""How near to the best choice of lines is good enough, and how long it is looked for."""
_FAIR, _WORSE = 0.4, 0.01
"""Scaled Jacobian that hexahedra may have for a border, and what they may lose below it."""
_FARTHER = 1.5
"""How far quads may be off the model for a border, over the farthest before."""


BorderChoice = tuple[tuple[tuple[int, ...], tuple[int, ...], tuple[tuple[int, int], ...]], ...]
"""Of every border that is followed its edges, the nodes on it, and which of them are at which vertices."""


class Border(NamedTuple):
    """A run of smooth edges, nodes (k,) that follow it and how far off, and the vertices that those at its ends go to.

    Of a closed run the first node is the last, too; it goes to no vertex where nothing else ends there.
    """

    run: Run
    nodes: IntArray
    at: dict[int, int]
    off: float


class Bordered(NamedTuple):
    """Points (n, 3), the borders of blends that lines of the mesh follow, their curves, and of how many they are."""

    points: FloatArray
    borders: list[Border]
    curves: list[Curve]
    n_runs: int

    @property
    def at_vertices(self) -> list[int]:
        """Nodes that stay where borders meet, or end."""
        return sorted({node for border in self.borders for node in border.at})

    @property
    def choice(self) -> BorderChoice:
        """What another mesh with the same hexahedra needs to be laid alike."""
        return tuple(
            (tuple(edge.id for edge in border.run.edges), tuple(border.nodes.tolist()), tuple(border.at.items()))
            for border in self.borders
        )


def with_borders(  # noqa: PLR0917
    solid: Solid,
    blends: Collection[Blend],
    patch_of: IntArray,
    carried: Carried,
    points: FloatArray,
    hexes: IntArray,
    quads: IntArray,
    like: BorderChoice | None = None,
) -> Bordered:
    """Lay lines of a mesh on borders of blends, as far as no hexahedron becomes poor by it.

    Parameters
    ----------
    solid : Solid
        The model.
    blends : collection of Blend
        What the design is without.
    patch_of : (n_faces,) int64
        Patch of each of its faces.
    carried : Carried
        The mesh on it.
    points : (n, 3) float64
        Where its nodes are since.
    hexes : (m, 8) int64
    quads : (q, 4) int64
    like : optional
        The lines of another mesh, which are taken as they are.

    Raises
    ------
    SurfaceMeshError
        A line has no room on its border.
    """
    runs = _border_runs(solid, patch_of)
    if like is not None:
        by_edges = {tuple(edge.id for edge in run.edges): run for run in runs}
        left = [Border(by_edges[e], np.array(own), dict(at), 0.0) for e, own, at in like if e in by_edges]
        found, curves = _laid(solid, carried, left, points, hexes, quads)
        return Bordered(found, left, curves, len(runs))
    depth = np.zeros(len(solid.faces), dtype=np.int64)
    for blend in blends:
        depth[list(blend.faces)] = 1 + (blend.kind == "corner")
    left = _chosen(_find_lines(runs, _Walks(solid, depth, carried, quads, points))) if runs else []
    before = scaled_jacobians(points, hexes)
    least = np.where(before >= _FAIR, _FAIR, np.maximum(before - _WORSE, 0.5 * before))
    most = max(_sags(carried, points, quads).max(), _ON * solid.size)
    turn = 0
    while left:
        found, curves = _laid(solid, carried, left, points, hexes, quads)
        by_hex = least - scaled_jacobians(found, hexes)
        by_quad = _sags(carried, found, quads) / most - _FARTHER
        worst = max(by_hex.max(), by_quad.max())
        if worst <= 0.0:
            return Bordered(found, left, curves, len(runs))
        poor = np.union1d(hexes[by_hex > 0.5 * worst], quads[by_quad > 0.5 * worst])
        tree = cKDTree(found[poor])
        away = np.array([tree.query(found[border.nodes])[0].min() for border in left])
        order = np.argsort(away, kind="stable")
        turn += 1
        n_gone = max(np.count_nonzero(away == away.min()), (turn > _TURNS) * len(left) // 2)
        left = [left[k] for k in sorted(order[n_gone:].tolist())]
    return Bordered(points, [], [], len(runs))


def _laid(  # noqa: PLR0917
    solid: Solid, carried: Carried, borders: Sequence[Border], points: FloatArray, hexes: IntArray, quads: IntArray
) -> tuple[FloatArray, list[Curve]]:
    """All points once lines of the mesh are on borders, and the curves of these."""
    wanted = {node: vertex for border in borders for node, vertex in border.at.items()}
    found, is_set = points.copy(), np.zeros(len(points), dtype=bool)
    for line in carried.lines:
        found[line.nodes] = _pinned(solid, line, wanted, points)
        is_set[line.nodes] = True
    found[list(wanted)] = solid.vertices[list(wanted.values())]
    curves = []
    for border in borders:
        at = fractions_of(solid, border.run, found[border.nodes[[0, -1]]], found[border.nodes])
        within = slice(1, -1) if border.at else slice(None)
        found[border.nodes[within]] = border.run.evaluate(at[within])
        is_set[border.nodes] = True
        curves.append(as_curve(border.run, float(at[0]), float(at[-1])))
    found = spread(points, found, is_set, hexes, quads, carried.patches, carried.surfaces, by_length=True)
    return found, curves


def _sags(carried: Carried, points: FloatArray, quads: IntArray) -> FloatArray:
    """How far quads (q,) are off their patches."""
    found = np.zeros(len(quads))
    for patch, surface in carried.surfaces.items():
        own = carried.patches == patch
        found[own] = quad_sags(surface, points[quads[own]])
    return found


def _border_runs(solid: Solid, patch_of: IntArray) -> list[Run]:
    sharp = {v for edge in solid.edges if is_line(edge, patch_of) for v in (edge.start, edge.end)}
    smooth = [edge.id for edge in solid.edges if not is_line(edge, patch_of) and edge.faces[0] != edge.faces[1]]
    return chained(solid, patch_of, smooth, lambda vertex, *_: vertex not in sharp)


def _pinned(solid: Solid, line: LaidLine, wanted: dict[int, int], points: FloatArray) -> FloatArray:
    """Points of a line once some of its nodes go to vertices: those between follow by their shares."""
    pins = [k for k, node in enumerate(line.nodes.tolist()) if node in wanted and 0 < k < len(line.nodes) - 1]
    if not pins:
        return points[line.nodes]
    at = line.curve.project(points[line.nodes])
    at[[0, -1]] = 0.0, 1.0
    to = line.curve.project(solid.vertices[[wanted[int(line.nodes[k])] for k in pins]])
    found = points[line.nodes]
    found[1:-1] = line.curve.evaluate(np.interp(at, at[[0, *pins, -1]], [0.0, *to, 1.0])[1:-1])
    return found


def _find_lines(runs: Sequence[Run], walks: _Walks) -> list[Border]:
    """All lines of a mesh that runs may have."""
    n_ends = Counter(vertex for run in runs for vertex in run.ends)
    found = []
    for run in runs:
        for off, nodes in walks.along(run):
            is_free = run.is_closed and n_ends[run.ends[0]] == 2
            at = {} if is_free else dict(zip(nodes[[0, -1]].tolist(), run.ends, strict=True))
            found.append(Border(run, nodes, at, off))
    return found


def _chosen(borders: Sequence[Border]) -> list[Border]:
    """Lines for as many runs as can have one, the nearest; a node is on one, or at the end of several.

    An integer programme: whether a line is taken, and whether a vertex is at a node; of what excludes each other one.
    """
    if not borders:
        return []
    excluding: dict[tuple[str, int], list[int]] = defaultdict(list)
    for k, border in enumerate(borders):
        excluding["run", id(border.run)].append(k)
        for node in set(border.nodes.tolist()) - set(border.at):
            excluding["node", node].append(k)
    places = sorted({place for border in borders for place in border.at.items()})
    column = {place: len(borders) + k for k, place in enumerate(places)}
    for node, vertex in places:
        excluding["node", node].append(column[node, vertex])
        excluding["vertex", vertex].append(column[node, vertex])
    entries = [(row, k, 1.0) for row, own in enumerate(excluding.values()) for k in own]
    n_rows = len(excluding)
    needing: dict[tuple[int, tuple[int, int]], list[int]] = defaultdict(list)
    for k, border in enumerate(borders):
        for place in border.at.items():
            needing[id(border.run), place].append(k)
    for (_, place), own in needing.items():  # the one line of a run needs its places
        entries += [(n_rows, column[place], -1.0), *((n_rows, k, 1.0) for k in own)]
        n_rows += 1
    row, col, value = zip(*entries, strict=True)
    n = len(borders) + len(places)
    limits = np.zeros(n_rows)
    limits[: len(excluding)] = 1.0
    worth = np.array([*(1.0 - 0.5 * border.off for border in borders), *[0.0] * len(places)])
    found = milp(
        -worth,
        integrality=np.ones(n),
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(coo_array((value, (row, col)), shape=(n_rows, n)), -np.inf, limits),
        options={"mip_rel_gap": _GAP, "time_limit": _SECONDS},
    )
    if found.x is None:
        return []  # out of time
    return [border for border, chosen in zip(borders, found.x, strict=False) if chosen > 0.5]


class _Walks:
    """Straight lines of quads on a skin."""

    def __init__(self, solid: Solid, depth: IntArray, carried: Carried, quads: IntArray, points: FloatArray) -> None:
        self.points = points
        self.depth, self.depths = depth, np.zeros(len(points), dtype=np.int64)  # of faces, and of nodes
        for patch, surface in carried.surfaces.items():
            if isinstance(surface, PatchSurface):
                own = np.unique(quads[carried.patches == patch])
                self.depths[own] = depth[surface.face_at(points[own])]
        self.corners = solid.vertices
        self.segments, pairs = sides_of(quads)
        self.beside = [set(own) for own in pairs.tolist()]
        self.on_line = np.zeros(len(points), dtype=bool)
        on_line = set()
        self.nodes: dict[int, IntArray] = {}  # of lines, which vertices on them may go to
        for line in carried.lines:
            self.on_line[line.nodes] = True
            on_line |= {frozenset(pair) for pair in zip(line.nodes[:-1].tolist(), line.nodes[1:].tolist(), strict=True)}
            vertices = sorted({v for edge in line.run.edges for v in (edge.start, edge.end)})
            off = line.curve.distance(solid.vertices[vertices])
            for vertex in np.array(vertices)[off <= _ON * solid.size].tolist():
                self.nodes[vertex] = np.concatenate([self.nodes.get(vertex, line.nodes[:0]), line.nodes])
        self.at: dict[int, list[int]] = defaultdict(list)  # segments within patches at every node
        for s, segment in enumerate(self.segments.tolist()):
            if frozenset(segment) not in on_line:
                for node in segment:
                    self.at[node].append(s)
        self.within = {
            patch: own[~self.on_line[own]]
            for patch in np.unique(carried.patches).tolist()
            for own in [np.unique(quads[carried.patches == patch])]
        }

    def along(self, run: Run) -> Iterator[tuple[float, IntArray]]:
        """Lines of nodes that follow a run, and how far each is off it, as a share of the quads across.

        What is on the blend counts as farther: to have fewer quads bends these more than to have them narrower.
        """
        first, last = (self._near(vertex, run.pair[0]) for vertex in run.ends)
        for start in first:
            for s in self.at[start]:
                yield from self._walked(run, start, s, [start] if run.is_closed else last)

    def _near(self, vertex: int, patch: int) -> list[int]:
        own = self.nodes.get(vertex, self.within[patch])
        away = np.linalg.norm(self.points[own] - self.corners[vertex], axis=1)
        return [int(node) for node in own[np.argsort(away, kind="stable")[:_ASKED]]]

    def _walked(self, run: Run, start: int, segment: int, last: Sequence[int]) -> Iterator[tuple[float, IntArray]]:
        nodes, worst = [start], 0.0
        while True:
            a, b = self.segments[segment].tolist()
            node = b if a == nodes[-1] else a
            if node in nodes[1:]:
                return
            nodes.append(node)
            if node in last:
                yield worst, np.array(nodes, dtype=np.int64)
            across = [s for s in self.at[node] if s != segment and self.beside[s] & self.beside[segment]]
            following = [s for s in self.at[node] if s != segment and s not in across]
            if self.on_line[node] or not following:
                return
            off = float(run.distance(self.points[node][None])[0])
            width = np.linalg.norm(np.diff(self.points[self.segments[across]], axis=1), axis=2).mean()
            is_inside = self.depths[node] > self.depth[list(run.edges[0].faces)].min()
            worst = max(worst, off / float(width) * (_INSIDE if is_inside else 1.0))
            if worst > _REACH:
                return
            if len(following) > 1:
                middles = self.points[self.segments[following]].mean(axis=1)
                following = [following[int(run.distance(middles).argmin())]]
            (segment,) = following


__all__ = ["BORDERS", "BorderChoice", "Bordered", "with_borders"]
