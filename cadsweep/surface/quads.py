"""Quads on the source cap, face by face, on boundary nodes that are given.

Place in the flow: after the rings; gives ``mesh.QuadMesh``.

Method: the cap's nodes have one numbering, the ring's first. Inner edges of a cap of several faces are
divided once, so the faces conform; each face is then filled by the ways of ``filling``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..arrays import FloatArray, IntArray, distinct
from ..brep import Face
from ..errors import SurfaceMeshError
from ..mesh import QuadMesh, WallRows
from ..sweep import Intervals, Sweep
from .filling import best_quads
from .memory import Memory
from .outline import FaceQuads, Outline, reversed_loop
from .relax import corner_sines
from .rim import smooth_loops
from .walls import Walls

_FLAT = 1e-6
"""Worst corner sine below which quads are refused: they are folded but for rounding."""
_POOR = 0.1
"""Worst corner sine of quads around which a face that is refused should be divided finer."""


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
        graded: Mapping[int, FloatArray] | None = None,
        walls: Walls | None = None,
    ) -> None:
        """`graded`: arc-length fractions of the edges of the cap that are not divided evenly."""
        self.solid = sweep.solid
        self.sweep = sweep
        self.counts = intervals.counts
        self.size = intervals.size
        self.sizes = sizes
        self.memory = memory or Memory()
        self.graded = graded or {}
        self.walls = walls
        self.notes: list[str] = []
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
        self.fractions[edge] = self.graded.get(edge, np.linspace(0.0, 1.0, len(ids)))
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
                raise SurfaceMeshError(f"{edge.label()} inside the source cap has {n} segments")
            points = edge.curve.evaluate(self.graded.get(e, np.linspace(0.0, 1.0, n + 1)))[1:-1]
            ids = np.concatenate(
                [[self._vertex_nodes[edge.start]], self._add(points), [self._vertex_nodes[edge.end]]]
            ).astype(np.int64)
            self._take_edge(e, ids)

    def build(self) -> QuadMesh:
        """Mesh every face of the cap."""
        quads, owners = [], []
        walls: list[WallRows] = []
        failures: list[SurfaceMeshError] = []
        for f in self.sweep.source:
            try:
                patch = self._fill(self.solid.faces[f])
            except SurfaceMeshError as error:
                failures.append(error)
                continue
            self._add(patch.inner_points)
            quads.append(patch.quads)
            walls += patch.walls
            self.notes += patch.notes
            owners.append(np.full(len(patch.quads), f, dtype=np.int64))
        if failures:
            # All of them at once: who divides their edges finer need not come again for every one.
            edges = list(dict.fromkeys(e for error in failures for e in error.edges))
            raise SurfaceMeshError(str(failures[0]), edges=edges) from failures[0]
        return QuadMesh(
            points=np.concatenate(self.points),
            quads=np.concatenate(quads),
            faces=np.concatenate(owners),
            loops=self.loops,
            edge_nodes=self.edge_nodes,
            walls=tuple(walls),
        )

    def _fill(self, face: Face) -> FaceQuads:
        outline = self._outline(face)
        patch = self.memory.recall(outline)
        if patch is None:
            patch = best_quads(outline)
            self.memory.keep(outline, patch)
        if patch.worst < _FLAT:
            raise SurfaceMeshError(
                f"{face.label()}: the best quads that could be made are folded (worst corner sine "
                f"{patch.worst:.2g}); try a smaller size",
                edges=self._edges_at_folds(outline, patch),
            )
        return patch

    def _outline(self, face: Face) -> Outline:
        loops = tuple(tuple(reversed_loop(loop.directed)) for loop in face.loops)
        return Outline(
            face=face,
            loops=loops,
            smooth=tuple(smooth_loops(self.sweep, loops)),
            counts=self.counts,
            edge_nodes=self.edge_nodes,
            fractions=self.fractions,
            known=np.concatenate(self.points),
            opposite=self.opposite,
            size=self.size,
            sizes=self.sizes,
            walls=self.walls if self.walls and any(e in self.walls.layers for e in face.edges) else None,
        )

    def _edges_at_folds(self, outline: Outline, patch: FaceQuads) -> list[int]:
        """Edges of a face with a node of its worst quads or of their neighbours; all where these lie inside."""
        face = outline.face
        points = np.concatenate([outline.known, patch.inner_points])
        normals = np.zeros(points.shape)
        used = distinct(patch.quads)
        normals[used] = -face.surface.normals(face.surface.project(points[used]))
        sines = corner_sines(points, patch.quads, normals).min(axis=1)
        near = np.isin(np.arange(len(points)), patch.quads[sines < _POOR])
        near[patch.quads[near[patch.quads].any(axis=1)]] = True
        return [e for e in face.edges if near[self.edge_nodes[e]].any()] or list(face.edges)
