"""Where every edge and linking face of a sweep lies in the grid of ring nodes times layers.

Place in the flow: the first step of the surface stage. Recognition says which edges run along the
loops and which along the sweep, intervals how many segments each has; both together fix the integer
place of every vertex: ``column`` (position around its loop) and ``layer``.

Method: the source loops are laid down from their first vertices, then every linking side whose
corner is known is laid down in turn, until all are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import IntArray
from ..errors import SurfaceMeshError
from ..sweep import DirectedEdge, Intervals, LinkingSide, Sweep

CHAIN_NAMES = ("bottom", "right", "top", "left")


@dataclass(frozen=True, kw_only=True)
class PlacedEdge:
    """A directed edge in the grid.

    Attributes
    ----------
    edge : int
        Edge id.
    forward : bool
        Whether the edge, run from its start to its end, goes with the loop (or the sweep).
    along_loop : bool
        Along its loop, else along the sweep.
    loop : int
    column, layer : int
        Where it begins, seen in its loop's (or the sweep's) direction; columns count within the loop.
    n_segments : int
    """

    edge: int
    forward: bool
    along_loop: bool
    loop: int
    column: int
    layer: int
    n_segments: int


@dataclass(frozen=True, kw_only=True)
class PlacedSide:
    """A linking side in the grid: ``width`` columns by ``height`` layers from (column, layer)."""

    side: LinkingSide
    loop: int
    column: int
    layer: int
    width: int
    height: int


@dataclass(frozen=True, kw_only=True)
class SweepGrid:
    """The grid of a sweep.

    Attributes
    ----------
    n_layers : int
    loop_sizes : tuple of int
        Nodes of each loop.
    edges : dict of int to PlacedEdge
    sides : tuple of PlacedSide
    vertices : dict of int to (int, int)
        Vertex id to (ring position, layer).
    """

    n_layers: int
    loop_sizes: tuple[int, ...]
    edges: dict[int, PlacedEdge]
    sides: tuple[PlacedSide, ...]
    vertices: dict[int, tuple[int, int]]
    offsets: tuple[int, ...] = field(default=())

    @property
    def n_ring(self) -> int:
        """Nodes of one ring."""
        return sum(self.loop_sizes)

    def columns(self, loop: int, start: int, count: int) -> IntArray:
        """Ring positions of `count` successive nodes of a loop; the loop closes on itself."""
        return self.offsets[loop] + (start + np.arange(count, dtype=np.int64)) % self.loop_sizes[loop]

    def nodes(self, placed: PlacedEdge) -> tuple[IntArray, IntArray]:
        """Layers and ring positions of an edge's nodes, in its placed direction."""
        n = placed.n_segments + 1
        if placed.along_loop:
            return np.full(n, placed.layer, dtype=np.int64), self.columns(placed.loop, placed.column, n)
        column = self.columns(placed.loop, placed.column, 1)[0]
        return placed.layer + np.arange(n, dtype=np.int64), np.full(n, column, dtype=np.int64)

    def block(self, placed: PlacedSide) -> tuple[IntArray, IntArray]:
        """Index arrays ``(layers[:, None], columns[None, :])`` of a side's nodes."""
        layers = placed.layer + np.arange(placed.height + 1, dtype=np.int64)
        return layers[:, None], self.columns(placed.loop, placed.column, placed.width + 1)[None, :]

    def labels(self) -> tuple[IntArray, IntArray, IntArray]:
        """Face (n_layers, b) of every quad of the rings; edge and vertex (n_layers + 1, b) of every node, else -1."""
        side_faces = np.full((self.n_layers, self.n_ring), -1, dtype=np.int64)
        for side in self.sides:
            columns = self.columns(side.loop, side.column, side.width)
            side_faces[side.layer : side.layer + side.height, columns] = side.side.face
        node_edges = np.full((self.n_layers + 1, self.n_ring), -1, dtype=np.int64)
        for edge in self.edges.values():
            node_edges[self.nodes(edge)] = edge.edge
        node_vertices = np.full_like(node_edges, -1)
        for vertex, (column, layer) in self.vertices.items():
            node_vertices[layer, column] = vertex
        return side_faces, node_edges, node_vertices


def build_grid(sweep: Sweep, intervals: Intervals) -> SweepGrid:
    """Lay the edges and linking sides of a sweep out in the grid of ring nodes times layers.

    Raises
    ------
    SurfaceMeshError
        The counts of opposite chains differ, or the sides do not tile the band between the caps.
    """
    counts = intervals.counts
    n_layers = int(intervals.n_layers)
    loop_sizes = tuple(int(sum(counts[e] for e, _ in loop)) for loop in sweep.source_loops)
    builder = _Builder(sweep, counts, n_layers, loop_sizes)
    for j, loop in enumerate(sweep.source_loops):
        builder.lay_chain(loop, loop=j, column=0, layer=0, along_loop=True)
    waiting = list(sweep.linking_sides)
    while waiting:
        later = [side for side in waiting if not builder.lay_side(side)]
        if len(later) == len(waiting):
            faces = ", ".join(sweep.solid.faces[side.face].label() for side in later[:3])
            raise SurfaceMeshError(f"linking sides that no chain of sides joins to the source: {faces}")
        waiting = later
    layout = SweepGrid(
        n_layers=n_layers,
        loop_sizes=loop_sizes,
        edges=builder.edges,
        sides=tuple(builder.sides),
        vertices={v: (builder.offsets[j] + i % loop_sizes[j], k) for v, (j, i, k) in builder.vertices.items()},
        offsets=tuple(builder.offsets),
    )
    _check_tiling(sweep, layout)
    return layout


class _Builder:
    """Places found so far; vertices are (loop, column, layer)."""

    def __init__(self, sweep: Sweep, counts: IntArray, n_layers: int, loop_sizes: Sequence[int]) -> None:
        self.solid = sweep.solid
        self.counts = counts
        self.n_layers = n_layers
        self.loop_sizes = loop_sizes
        self.offsets = [int(sum(loop_sizes[:j])) for j in range(len(loop_sizes))]
        self.edges: dict[int, PlacedEdge] = {}
        self.sides: list[PlacedSide] = []
        self.vertices: dict[int, tuple[int, int, int]] = {}

    def _ends(self, directed: DirectedEdge) -> tuple[int, int]:
        edge = self.solid.edges[directed[0]]
        return (edge.start, edge.end) if directed[1] else (edge.end, edge.start)

    def _place_vertex(self, vertex: int, loop: int, column: int, layer: int) -> None:
        place = (loop, column % self.loop_sizes[loop], layer)
        known = self.vertices.setdefault(vertex, place)
        if known != place:
            at = self.solid.units.place(self.solid.vertices[vertex])
            raise SurfaceMeshError(
                f"the edge counts do not close around vertex {vertex} at ({at}): "
                f"column {known[1]} and {place[1]}, layer {known[2]} and {place[2]}"
            )

    def lay_chain(self, chain: Sequence[DirectedEdge], *, loop: int, column: int, layer: int, along_loop: bool) -> None:
        for directed in chain:
            edge, forward = directed
            n = int(self.counts[edge])
            placed = PlacedEdge(
                edge=edge,
                forward=forward,
                along_loop=along_loop,
                loop=loop,
                column=column % self.loop_sizes[loop],
                layer=layer,
                n_segments=n,
            )
            if n < 1 or self.edges.setdefault(edge, placed) != placed:
                label = self.solid.edges[edge].label()
                raise SurfaceMeshError(f"{label} ({n} segments) has no single place between the caps")
            start, end = self._ends(directed)
            self._place_vertex(start, loop, column, layer)
            column, layer = (column + n, layer) if along_loop else (column, layer + n)
            self._place_vertex(end, loop, column, layer)

    def _find_corner(self, side: LinkingSide, width: int, height: int) -> tuple[int, int, int] | None:
        """Loop, column and layer of a side's first corner, from any of its vertices that has a place."""
        starts = {"bottom": (0, 0), "left": (0, 0), "right": (width, 0), "top": (0, height)}
        for name, (i, k) in starts.items():
            run = 0
            for directed in getattr(side, name):
                known = self.vertices.get(self._ends(directed)[0])
                if known is not None:
                    along = name in ("bottom", "top")
                    return known[0], known[1] - i - (run if along else 0), known[2] - k - (0 if along else run)
                run += int(self.counts[directed[0]])
        return None

    def lay_side(self, side: LinkingSide) -> bool:
        """Lay a side down if one of its vertices has a place."""
        bottom, right, top, left = (sum(int(self.counts[e]) for e, _ in getattr(side, name)) for name in CHAIN_NAMES)
        if bottom != top or left != right:
            raise SurfaceMeshError(
                f"{self.solid.faces[side.face].label()} has {bottom} segments at the bottom and {top} at the top, "
                f"{left} on the left and {right} on the right; opposite sums must be equal"
            )
        corner = self._find_corner(side, bottom, left)
        if corner is None:
            return False
        loop, column, layer = corner
        chains = {"bottom": (0, 0), "left": (0, 0), "right": (bottom, 0), "top": (0, left)}
        for name, (i, k) in chains.items():
            self.lay_chain(
                getattr(side, name), loop=loop, column=column + i, layer=layer + k, along_loop=name in ("bottom", "top")
            )
        self.sides.append(
            PlacedSide(
                side=side, loop=loop, column=column % self.loop_sizes[loop], layer=layer, width=bottom, height=left
            )
        )
        return True


def _check_tiling(sweep: Sweep, layout: SweepGrid) -> None:
    """Every quad between the caps belongs to exactly one side."""
    uses = np.zeros((layout.n_layers, layout.n_ring), dtype=np.int64)
    for placed in layout.sides:
        if placed.layer < 0 or placed.layer + placed.height > layout.n_layers:
            label = sweep.solid.faces[placed.side.face].label()
            raise SurfaceMeshError(
                f"{label} would reach from layer {placed.layer} to {placed.layer + placed.height} of {layout.n_layers}"
            )
        columns = layout.columns(placed.loop, placed.column, placed.width)
        uses[placed.layer : placed.layer + placed.height, columns] += 1
    if (uses != 1).any():
        layer, column = np.argwhere(uses != 1)[0]
        raise SurfaceMeshError(
            f"the linking sides do not tile the band between the caps: {uses[layer, column]} sides "
            f"at layer {layer}, ring node {column}"
        )
