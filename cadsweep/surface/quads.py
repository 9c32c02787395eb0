"""Quads on the source cap, face by face, on boundary nodes that are given.

Place in the flow: after the rings; gives ``mesh.QuadMesh``.

Method: a four-sided face with equal opposite counts is filled transfinitely. Any other face is
mapped to a plane (``charts``), meshed there by gmsh (``gmsh_quads``), and brought back. Settings are
tried from the cheapest on until the worst quad is good; quads are then relaxed on the surface
(``relax``). Around one hole our own strips and rings (``annulus``) compete with them. Inner edges of a
cap of several faces are divided once, so the faces conform.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Face
from ..errors import SurfaceMeshError
from ..mesh import QuadMesh
from ..sweep import DirectedEdge, Intervals, Sweep
from .annulus import THIN, fill_wall, wall_thickness
from .background import Background, count_interpolated, make_background, typical_length
from .chart import Chart, surface_background
from .charts import charts_of
from .gmsh_quads import mesh_polygon, settings_for
from .relax import corner_sines, relax_quads
from .rim import lay_rows, smooth_loops
from .transfinite import GOOD_ENOUGH, fill, join_chains

_CORNER = (np.radians(30), np.radians(150))
_STRAIGHT = (np.radians(150), np.radians(210))
_GOOD_WALL = 0.7
"""Worst corner sine of our own quads around a hole from which on gmsh is not asked."""


_FLAT = 1e-6
"""Worst corner sine below which quads are refused."""
_POOR = 0.1
"""Worst corner sine of quads around which a face that is refused should be divided finer."""
_FINER_OUTLINE = 2.0
"""The size over the outline's typical segment beyond which quads grow towards the size inside."""
_WORTH = 0.6
"""Part of the quads that growing ones must spare to be worth their irregular nodes."""
_GOOD_ROWS = 0.4
"""Worst corner sine from which on quads with a row along a smooth rim are taken."""


@dataclass(frozen=True, kw_only=True)
class FacePatch:
    """Quads of one face: ids below `n_fixed` are the cap's, the others count its inner nodes on."""

    inner_points: FloatArray
    quads: IntArray
    worst: float
    expected: float
    """Worst corner sine on both caps, as far as the angles of their vertices tell; at most `worst`."""


@dataclass(frozen=True, kw_only=True)
class KnownPatch:
    """Quads of one face, and the numbers that its nodes had then.

    Attributes
    ----------
    patch : FacePatch
    nodes : (k,) int64
        Of the face's edges in their order.
    first : int
        Of the inner nodes.
    """

    patch: FacePatch
    nodes: IntArray
    first: int

    def renumbered(self, nodes: IntArray, first: int) -> FacePatch:
        """The same quads on other numbers."""
        old, at = np.unique(self.nodes, return_index=True)
        quads = self.patch.quads
        outline = nodes[at[np.minimum(np.searchsorted(old, quads), len(old) - 1)]]
        return replace(self.patch, quads=np.where(quads < self.first, outline, quads - self.first + first))


Memory = dict[bytes, KnownPatch]
"""Quads of faces by the nodes of their outlines: for who meshes one cap again with other counts on a few edges."""


class CapBuilder:
    """Nodes and quads of the source cap; the ring's nodes come first."""

    def __init__(
        self,
        sweep: Sweep,
        intervals: Intervals,
        ring: FloatArray,
        loops: Sequence[IntArray],
        opposite: FloatArray,
        *,
        sizes: Callable[[FloatArray], FloatArray] | None = None,
        memory: Memory | None = None,
    ) -> None:
        self.solid = sweep.solid
        self.sweep = sweep
        self.counts = intervals.counts
        self.size = intervals.size
        self.sizes = sizes
        self.memory = memory
        self.points = [ring]
        self.n_points = len(ring)
        self.loops = tuple(loops)
        self.opposite = opposite
        self.edge_nodes: dict[int, IntArray] = {}
        self.fractions: dict[int, FloatArray] = {}
        self._vertex_nodes: dict[int, int] = {}
        self._take_loops()
        self._divide_inner_edges()

    def _add(self, points: FloatArray) -> IntArray:
        ids = np.arange(self.n_points, self.n_points + len(points), dtype=np.int64)
        self.points.append(points)
        self.n_points += len(points)
        return ids

    def _take_loops(self) -> None:
        for directed_edges, nodes in zip(self.sweep.source_loops, self.loops, strict=True):
            at = 0
            for edge, forward in directed_edges:
                n = int(self.counts[edge])
                ids = nodes[(at + np.arange(n + 1)) % len(nodes)]
                self._take_edge(edge, ids if forward else ids[::-1])
                at += n

    def _take_edge(self, edge: int, ids: IntArray) -> None:
        self.edge_nodes[edge] = ids
        self.fractions[edge] = np.linspace(0.0, 1.0, len(ids))
        self._vertex_nodes[self.solid.edges[edge].start] = int(ids[0])
        self._vertex_nodes[self.solid.edges[edge].end] = int(ids[-1])

    def _divide_inner_edges(self) -> None:
        inner = sorted({e for f in self.sweep.source for e in self.solid.faces[f].edges} - set(self.edge_nodes))
        for vertex in sorted({v for e in inner for v in (self.solid.edges[e].start, self.solid.edges[e].end)}):
            if vertex not in self._vertex_nodes:
                self._vertex_nodes[vertex] = int(self._add(self.solid.vertices[vertex][None])[0])
        for e in inner:
            edge = self.solid.edges[e]
            n = int(self.counts[e])
            if n < 1:
                raise SurfaceMeshError(f"edge {e} inside the source cap has {n} segments")
            points = edge.curve.evaluate(np.linspace(0.0, 1.0, n + 1))[1:-1]
            ids = np.concatenate(
                [[self._vertex_nodes[edge.start]], self._add(points), [self._vertex_nodes[edge.end]]]
            ).astype(np.int64)
            self._take_edge(e, ids)

    def build(self) -> QuadMesh:
        """Mesh every face of the cap."""
        quads, owners = [], []
        failures: list[SurfaceMeshError] = []
        for f in self.sweep.source:
            try:
                patch = self._patch(self.solid.faces[f])
            except SurfaceMeshError as error:
                failures.append(error)
                continue
            self._add(patch.inner_points)
            quads.append(patch.quads)
            owners.append(np.full(len(patch.quads), f, dtype=np.int64))
        if failures:
            # All of them at once: who divides their edges finer need not come again for every one.
            raise SurfaceMeshError(
                str(failures[0]), edges=list(dict.fromkeys(e for error in failures for e in error.edges))
            ) from failures[0]
        return QuadMesh(
            points=np.concatenate(self.points),
            quads=np.concatenate(quads),
            faces=np.concatenate(owners),
            loops=self.loops,
            edge_nodes=self.edge_nodes,
        )

    def _patch(self, face: Face) -> FacePatch:
        """Quads of one face: those made before on the same nodes, where there are any."""
        nodes = np.concatenate([self.edge_nodes[e] for e in face.edges])
        known = np.concatenate(self.points)
        key = b"".join(part.tobytes() for part in (np.array([face.id]), known[nodes], self._opposite_of(nodes)))
        if self.memory is not None and key in self.memory:
            return self.memory[key].renumbered(nodes, self.n_points)
        patch = self._made(face, known)
        if self.memory is not None:
            self.memory[key] = KnownPatch(patch=patch, nodes=nodes, first=self.n_points)
        return patch

    def _made(self, face: Face, known: FloatArray) -> FacePatch:
        loops = [reversed_loop(loop.directed) for loop in face.loops]
        patch = self._structured(face, loops, known) if len(loops) == 1 else None
        if patch is None or patch.expected < GOOD_ENOUGH or any(smooth_loops(self.sweep, loops)):
            other = self._other_than_grid(face, loops, known, patch)
            patch = other if patch is None or _better(other, patch) else patch
        if patch.worst < _FLAT:
            raise SurfaceMeshError(
                f"{face.label()}: the best quads that could be made are folded (worst corner sine "
                f"{patch.worst:.2g}); try a smaller size",
                edges=self._edges_at_folds(face, known, patch),
            )
        return patch

    def _edges_at_folds(self, face: Face, known: FloatArray, patch: FacePatch) -> list[int]:
        """Edges of a face with a node of its worst quads or of their neighbours; all where these lie inside."""
        points = np.concatenate([known, patch.inner_points])
        normals = np.zeros(points.shape)
        used = np.unique(patch.quads)
        normals[used] = -face.surface.normals(face.surface.project(points[used]))
        sines = corner_sines(points, patch.quads, normals).min(axis=1)
        near = np.isin(np.arange(len(points)), patch.quads[sines < _POOR])
        near[patch.quads[near[patch.quads].any(axis=1)]] = True
        return [e for e in face.edges if near[self.edge_nodes[e]].any()] or list(face.edges)

    def _chain_nodes(self, chain: Sequence[DirectedEdge]) -> IntArray:
        return join_chains([self.edge_nodes[e][:: 1 if forward else -1] for e, forward in chain])

    def _structured(self, face: Face, loops: Sequence[Sequence[DirectedEdge]], known: FloatArray) -> FacePatch | None:
        """Fill a four-sided face, or None where it is none."""
        sides = four_sides(face, loops[0], self.counts)
        if sides is None:
            return None
        a, b, c, d = sides
        chains = (a, b, [(e, not f) for e, f in reversed(c)], [(e, not f) for e, f in reversed(d)])
        nodes = tuple(self._chain_nodes(chain) for chain in chains)
        chains_uv = tuple(
            join_chains([face.surface.edge_uv(e, self.fractions[e])[:: 1 if forward else -1] for e, forward in chain])
            for chain in chains
        )
        points, _, worst = fill(face.surface, chains_uv, tuple(known[ids] for ids in nodes), side=-1.0)
        h, w = points.shape[0] - 1, points.shape[1] - 1
        ids = np.empty((h + 1, w + 1), dtype=np.int64)
        ids[1:-1, 1:-1] = self.n_points + np.arange((h - 1) * (w - 1)).reshape(h - 1, w - 1)
        ids[0], ids[:, -1], ids[-1], ids[:, 0] = nodes
        quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
        return self._judged(points[1:-1, 1:-1].reshape(-1, 3), quads, worst)

    def _other_than_grid(
        self, face: Face, loops: Sequence[Sequence[DirectedEdge]], known: FloatArray, grid: FacePatch | None
    ) -> FacePatch:
        """A row along a smooth rim, our own quads around a hole, or gmsh's: whichever have the better worst corner."""
        rows = self._rows(face, loops, known)
        if rows is not None and rows.expected >= _GOOD_ROWS:
            return rows
        wall = self._wall(face, loops, known, thin=True)
        if wall is not None and wall.expected >= _GOOD_WALL:
            return wall
        patch = self._unstructured(face, loops, known, wall or grid)
        if wall is None and patch.expected < GOOD_ENOUGH:
            wall = self._wall(face, loops, known, thin=False)
        return wall if wall is not None and _better(wall, patch) else patch

    def _charts(
        self, face: Face, loops: Sequence[Sequence[DirectedEdge]], nodes: Sequence[IntArray], known: FloatArray
    ) -> Iterator[Chart]:
        points = [known[ids] for ids in nodes]
        return charts_of(face, loops, self.fractions, nodes, known, size=self._largest(points))

    def _largest(self, loops: Sequence[FloatArray]) -> float:
        """Wanted length inside a face, away from its outline.

        An outline that is divided coarsely goes before the size. So does one that is divided a little finer all
        around, for its curves: a few larger quads in the middle of a section would gain nothing.
        """
        outline = typical_length(loops)
        return outline if outline >= self.size / _FINER_OUTLINE else self.size

    def _background(self, chart: Chart, loops: Sequence[FloatArray]) -> Background | None:
        """Sizes inside a chart; None where those of its outline, interpolated, do as well."""
        largest = self._largest(loops)
        if self.sizes is not None or chart.conformal:
            return surface_background(chart, largest, sizes=self.sizes)
        background = make_background(chart.boundary, largest=largest)
        few = background.count_quads(chart.boundary) < _WORTH * count_interpolated(chart.boundary)
        return background if few else None

    def _rows(self, face: Face, loops: Sequence[Sequence[DirectedEdge]], known: FloatArray) -> FacePatch | None:
        """Lay a row of quads along smooth rims and mesh the rest with gmsh, or None where that does not go."""
        smooth = smooth_loops(self.sweep, loops)
        if not any(smooth):
            return None
        nodes = [self._chain_nodes(loop)[:-1] for loop in loops]
        best: FacePatch | None = None
        for chart in self._charts(face, loops, nodes, known):
            rows = lay_rows(chart.boundary, smooth, partial(_normals_at, face, chart))
            if rows is None:
                continue
            inner, quads, left = rows
            places = np.concatenate([*chart.boundary, inner])
            outline = [places[loop] for loop in left]
            for setting in settings_for(outline):
                try:
                    more, others = mesh_polygon(outline, setting)
                except SurfaceMeshError:
                    continue  # the next setting, or the face without rows
                number = np.concatenate([*left, len(places) + np.arange(len(more), dtype=np.int64)])
                patch = self._lift(
                    face, chart, np.concatenate([inner, more]), np.concatenate([quads, number[others]]),
                    np.concatenate(nodes), n_rows=len(inner),
                )  # fmt: skip
                if best is None or patch.worst > best.worst:
                    best = patch
                if best.worst >= setting.good_enough:
                    return best
        return best

    def _wall(
        self, face: Face, loops: Sequence[Sequence[DirectedEdge]], known: FloatArray, *, thin: bool
    ) -> FacePatch | None:
        """Fill a face with one hole by strips or rings, or None where that does not go.

        Where `thin`, a wall of many quads is left out, unless rings go around it.
        """
        if len(loops) != 2:
            return None
        nodes = [self._chain_nodes(loop)[:-1] for loop in loops]
        for chart in self._charts(face, loops, nodes, known):
            if thin and wall_thickness(chart.boundary) >= THIN and len(nodes[0]) != len(nodes[1]):
                return None
            filled = fill_wall(chart.boundary, self._opposite_of(np.concatenate(nodes)))
            return None if filled is None else self._lift(face, chart, *filled, np.concatenate(nodes))
        return None

    def _unstructured(
        self, face: Face, loops: Sequence[Sequence[DirectedEdge]], known: FloatArray, other: FacePatch | None
    ) -> FacePatch:
        """Mesh a face with gmsh in a chart: the best of several settings by the worst quad."""
        nodes = [self._chain_nodes(loop)[:-1] for loop in loops]
        for loop in nodes:
            if len(loop) % 2 and len(nodes) == 1:
                raise SurfaceMeshError(
                    f"{face.label()} has {len(loop)} boundary segments; quads alone need an even number"
                )
        nodes = [_start_at_corner(ids, loop, face, self.counts) for ids, loop in zip(nodes, loops, strict=True)]
        boundary = np.concatenate(nodes)
        # A sharp corner between two edges is one quad's corner whatever the mesher does.
        limit = min((np.sin(a) for loop in loops for a in loop_angles(face, loop) if a < np.pi / 2), default=1.0)
        reasons: list[str] = []
        best: FacePatch | None = None
        for chart in self._charts(face, loops, nodes, known):
            background = self._background(chart, [known[ids] for ids in nodes])
            for setting in settings_for(chart.boundary):
                if setting.size_factor < 1 and best is not None and best.expected >= GOOD_ENOUGH / 2:
                    break  # many more quads are no way to make fair ones good
                try:
                    inner, quads = mesh_polygon(chart.boundary, setting, self._opposite_of(boundary), background)
                except SurfaceMeshError as error:
                    reasons.append(str(error))
                    continue
                patch = self._lift(face, chart, inner, quads, boundary)
                if best is None or _better(patch, best):
                    best = patch
                if best.expected >= min(setting.good_enough, 0.95 * limit):
                    return best
            if best is not None and best.expected >= GOOD_ENOUGH / 2:
                return best
        if best is None and other is not None:
            return other
        if best is None:
            why = (
                "; ".join(list(dict.fromkeys(reasons))[:3])
                or "its outline overlaps itself in every plane view; split the face"
            )
            raise SurfaceMeshError(f"{face.label()} could not be meshed with quads alone: {why}", edges=face.edges)
        return best

    def _lift(
        self, face: Face, chart: Chart, inner: FloatArray, quads: IntArray, boundary: IntArray, *, n_rows: int = 0
    ) -> FacePatch:
        """Bring a chart's mesh onto the surface and relax it, but for the first `n_rows` nodes inside."""
        points, uv = chart.lift(inner)
        everything = np.concatenate([np.concatenate(self.points)[boundary], points])
        n = len(boundary)
        all_uv = np.concatenate([chart.boundary_uv, uv])
        everything, _, worst = relax_quads(face.surface, everything, all_uv, quads, n_fixed=n + n_rows)
        ids = np.concatenate([boundary, self.n_points + np.arange(len(inner), dtype=np.int64)])
        return self._judged(everything[n:], ids[quads], worst)

    def _opposite_of(self, nodes: IntArray) -> FloatArray:
        """Angles of nodes on the target cap; NaN for those on edges inside the cap, too."""
        on_ring = nodes < len(self.opposite)
        return np.where(on_ring, self.opposite[np.where(on_ring, nodes, 0)], np.nan)

    def _judged(self, inner: FloatArray, quads: IntArray, worst: float) -> FacePatch:
        """A patch with what its corners will be where vertices of the other cap have other angles."""
        nodes, uses = np.unique(quads, return_counts=True)
        angles = self._opposite_of(nodes) / uses
        sines = np.sin(np.minimum(angles[np.isfinite(angles)], np.pi))
        return FacePatch(inner_points=inner, quads=quads, worst=worst, expected=min([worst, *sines.tolist()]))


def _better(one: FacePatch, other: FacePatch) -> bool:
    """Folded quads are never better, whatever is expected of the others."""
    return (one.worst > 0, one.expected, one.worst) > (other.worst > 0, other.expected, other.worst)


def _normals_at(face: Face, chart: Chart, places: FloatArray) -> FloatArray:
    return face.surface.normals(chart.lift(places)[1])


def reversed_loop(loop: Sequence[DirectedEdge]) -> list[DirectedEdge]:
    """A face's loop run the other way: seen along the sweep instead of from outside."""
    return [(edge, not forward) for edge, forward in reversed(loop)]


def loop_angles(face: Face, loop: Sequence[DirectedEdge]) -> list[float]:
    """Interior angle of the face at the vertex where each edge of a reversed loop begins."""
    at_end: dict[DirectedEdge, float] = {}
    for own in face.loops:
        for j, directed in enumerate(own.directed):
            # The reversed loop begins edge j where the face's own loop ends it.
            at_end[directed] = own.angles[(j + 1) % len(own.angles)]
    return [at_end[edge, not forward] for edge, forward in loop]


def four_sides(face: Face, loop: Sequence[DirectedEdge], counts: IntArray) -> list[list[DirectedEdge]] | None:
    """Split a loop at its four corners; None where there are not four, or opposite counts differ."""
    angles = loop_angles(face, loop)
    corners = [j for j, angle in enumerate(angles) if _CORNER[0] < angle < _CORNER[1]]
    straight = [j for j, angle in enumerate(angles) if _STRAIGHT[0] <= angle <= _STRAIGHT[1]]
    if len(corners) != 4 or len(corners) + len(straight) != len(angles):
        return None
    turned = list(loop[corners[0] :]) + list(loop[: corners[0]])
    cuts = [c - corners[0] for c in corners] + [len(loop)]
    sides = [turned[a:b] for a, b in pairwise(cuts)]
    sums = [int(sum(counts[e] for e, _ in side)) for side in sides]
    return sides if sums[0] == sums[2] and sums[1] == sums[3] else None


def _start_at_corner(ids: IntArray, loop: Sequence[DirectedEdge], face: Face, counts: IntArray) -> IntArray:
    """Turn a loop's nodes so that as many sharp corners as possible stand at even places.

    gmsh's all-quad algorithm works on every second boundary node first, counted from the beginning.
    """
    sharpness = np.abs(np.pi - np.array(loop_angles(face, loop)))
    places = np.concatenate([[0], np.cumsum([int(counts[e]) for e, _ in loop])])[:-1]
    even = sharpness[places % 2 == 0].sum()
    return ids if even >= sharpness[places % 2 == 1].sum() else np.roll(ids, -1)
