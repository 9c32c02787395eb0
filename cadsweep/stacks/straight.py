"""Straight stacks: every column is a small product, of the quads below it and of the heights of its layers.

Place in the flow: instead of :mod:`.blocks`, where all caps are flat and no outline was laid on another. What columns
share, the nodes on lines and on caps, is here as arrays; the nodes inside of a column follow from a few numbers a
layer, so that whoever writes or measures the mesh need not have all of it in memory.

Method: a node inside of a column keeps its place in the plane. Its height is that of its layer, by the column's two
caps and the mean heights of the levels, and where the lines around differ from that, by what harmonic functions carry
inwards: few, since lines differ in few ways.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, distinct
from ..mesh import QuadMesh
from ..stack import Levels, Stack
from ..stack_mesh import StraightColumn, StraightStack
from .blocks import find_material, find_walls
from .harmonic import carried
from .lines import nodes_on_edges
from .nodes import Heights, fill_levels, quads_by_cell
from .rims import even_out, segments_of, short_sides
from .sheets import TOLERANCE, is_flat

_FLAT = 1e-9
_SAME = 1e-12
"""Height, in sizes of the part, by which a line may differ from a layer without anything being carried inwards."""


def build_straight(stack: Stack, levels: Levels, mesh: QuadMesh) -> StraightStack | None:
    """Make the columns of a stack as products; None where its caps lean, or its outlines are not those of the plane.

    Parameters
    ----------
    stack : Stack
    levels : Levels
    mesh : QuadMesh
        The source cap of ``stack.plan``.

    Raises
    ------
    SurfaceMeshError
        A wall is missing.
    """
    if stack.arrangement.claims or not _is_flat(stack, levels):
        return None
    skeleton = _Skeleton.of(stack, levels, mesh)
    if skeleton is None:
        return None
    owners = {e: found[2] for e, found in find_walls(stack, levels, skeleton.material).items()}
    free = np.full(levels.n_layers, -1, dtype=np.int64)
    place_in = np.empty(len(mesh.points), dtype=np.int64)
    columns, rows, faces = [], [], []
    for c, own in enumerate(skeleton.quads):
        nodes = skeleton.nodes_of[c]
        place_in[nodes] = np.arange(len(nodes))
        local = place_in[own]
        loops, segments = _loops(stack, mesh, c)
        ring = np.concatenate(loops)
        if len(np.unique(ring)) != len(ring) or len(ring) != np.count_nonzero(skeleton.line_of[nodes] >= 0):
            return None  # a rim that touches itself at a point, or a line inside: no rim of one sweep
        lines, line = np.unique(segments, return_inverse=True)
        walls = np.stack([owners.get(e, free) for e in lines.tolist()], axis=1)[:, line]
        for a, b in stack.columns[c]:
            column = skeleton.column(nodes, local, loops, (a, b))
            sides = walls[column.low : column.low + column.n_layers]
            seen = np.flatnonzero(sides >= 0)
            following = np.concatenate(
                [np.roll(np.arange(first, last), -1) for first, last in pairwise(np.cumsum([0, *map(len, loops)]))]
            )
            low, high = column.rings[:-1], column.rings[1:]
            upright = np.stack([low, low[:, following], high[:, following], high], axis=-1).reshape(-1, 4)
            rows += [column.bottom[column.quads[:, ::-1]], column.top[column.quads], upright[seen]]
            faces += [np.full(len(own), a), np.full(len(own), b), sides.reshape(-1)[seen]]
            columns.append(replace(column, seen=np.concatenate([np.arange(2 * len(own)), 2 * len(own) + seen])))
    points, level_of, place_of = skeleton.nodes()
    on_lines = replace(mesh, edge_nodes={e: skeleton.line_of[nodes] for e, nodes in mesh.edge_nodes.items()})
    return StraightStack(
        points=points,
        columns=tuple(columns),
        quads=np.concatenate(rows),
        faces=np.concatenate(faces),
        edge_nodes=nodes_on_edges(stack, levels, on_lines, lambda k, _: skeleton.numbers[k], points),
        skeleton_levels=level_of,
        skeleton_places=place_of,
    )


class _Skeleton:
    """The nodes on lines, numbered level by level, and after them those inside of caps, column by column."""

    def __init__(self, stack: Stack, levels: Levels, mesh: QuadMesh) -> None:
        self.stack, self.levels = stack, levels
        self.lines = np.unique(np.concatenate([mesh.edge_nodes[e] for e in stack.arrangement.over]))
        self.line_of = np.full(len(mesh.points), -1, dtype=np.int64)
        self.line_of[self.lines] = np.arange(len(self.lines))
        self.quads = quads_by_cell(stack, mesh)
        self.nodes_of = [distinct(own) for own in self.quads]
        self.material = find_material(stack, levels)
        self.flat = mesh.points - np.outer(mesh.points @ stack.direction, stack.direction)
        self.heights = np.full((levels.n_layers + 1, len(self.lines)), np.nan)
        self.numbers = np.full(self.heights.shape, -1, dtype=np.int64)
        self._caps: list[tuple[int, float, IntArray]] = []
        self._n = 0

    @classmethod
    def of(cls, stack: Stack, levels: Levels, mesh: QuadMesh) -> _Skeleton | None:
        """The skeleton of a stack; None where a level has two heights over one node."""
        made = cls(stack, levels, mesh)
        around = [made.line_of[own] for own in made.nodes_of]
        around = [on[on >= 0] for on in around]
        if not made._find_heights(mesh, around):
            return None
        used = np.zeros(made.heights.shape, dtype=bool)
        for on, there in zip(around, made.material, strict=True):
            used[np.ix_(np.append(there, False) | np.append(False, there), on)] = True
        made.numbers[used] = np.arange(np.count_nonzero(used))
        made._n = int(np.count_nonzero(used))
        return made

    def _find_heights(self, mesh: QuadMesh, around: list[IntArray]) -> bool:
        stack, levels, solid = self.stack, self.levels, self.stack.solid
        fixed = [
            (levels.caps[f], _height(stack, f), on)
            for on, caps in zip(around, stack.arrangement.caps, strict=True)
            for f in sorted(caps)
        ]
        for e, over in stack.arrangement.over.items():
            for station in sorted(set(over) & levels.stations.keys()):
                height = float(solid.edges[station].midpoint @ stack.direction)
                fixed.append((levels.stations[station], height, self.line_of[mesh.edge_nodes[e]]))
        # Inner nodes by short sides are evened out with the lines, as in :func:`.nodes.place_nodes`.
        sides = short_sides(mesh.quads, mesh.points, levels.heights)
        number = self.line_of.copy()
        inner = np.unique(sides[number[sides] < 0])
        number[inner] = len(self.lines) + np.arange(len(inner))
        is_inner = np.zeros(len(number), dtype=bool)
        is_inner[inner] = True
        for nodes, caps in zip(self.nodes_of, stack.arrangement.caps, strict=True):
            on = number[nodes[is_inner[nodes]]]
            fixed += [(levels.caps[f], _height(stack, f), on) for f in sorted(caps) if len(on)]
        heights = np.full((levels.n_layers + 1, len(self.lines) + len(inner)), np.nan)
        tolerance = TOLERANCE * solid.size + 2.0 * solid.tolerance
        for level, height, on in fixed:
            known = heights[level, on]
            if (np.abs(known - height) > tolerance).any():
                return False  # a crack between two layers that stands open
            heights[level, on] = np.where(np.isnan(known), height, known)
        known = np.isfinite(heights)
        fill_levels(Heights(below=heights, above=heights), levels.heights)
        lines = [mesh.edge_nodes[e] for e in stack.arrangement.over]
        segments, lengths = segments_of(lines, sides, mesh.points)
        found = even_out(heights, heights, known, levels.heights, number[segments], lengths)
        self.heights = np.ascontiguousarray(found[:, : len(self.lines)])
        return True

    def column(self, nodes: IntArray, quads: IntArray, loops: list[IntArray], caps: tuple[int, int]) -> StraightColumn:
        """A column over nodes of the plane; its caps get their numbers."""
        levels, means = self.levels, self.levels.heights
        own_loops = tuple(np.searchsorted(nodes, loop) for loop in loops)
        ring = np.concatenate(own_loops)
        on_ring = np.zeros(len(nodes), dtype=bool)
        on_ring[ring] = True
        low, high = (levels.caps[f] for f in caps)
        bottom, top = (_height(self.stack, f) for f in caps)
        rim = (slice(low, high + 1), self.line_of[nodes[ring]])
        rises = bottom + (means[low : high + 1] - means[low]) / (means[high] - means[low]) * (top - bottom)
        rims = self.heights[rim]
        modes, amounts = _modes(rims - rises[:, None], quads, ring, on_ring, _SAME * self.stack.solid.size)
        ends = []
        for level, height in ((low, bottom), (high, top)):
            numbers = np.empty(len(nodes), dtype=np.int64)
            numbers[ring] = self.numbers[level, rim[1]]
            numbers[~on_ring] = np.arange(self._n, self._n + len(nodes) - len(ring))
            self._n += len(nodes) - len(ring)
            self._caps.append((level, height, nodes[~on_ring]))
            ends.append(numbers)
        return StraightColumn(
            nodes=nodes,
            quads=quads,
            loops=own_loops,
            low=low,
            points=self.flat[nodes],
            rises=rises,
            rims=rims,
            modes=modes,
            amounts=amounts,
            bottom=ends[0],
            top=ends[1],
            rings=self.numbers[rim],
            seen=np.arange(0),
        )

    def nodes(self) -> tuple[FloatArray, IntArray, IntArray]:
        """Points of all nodes, their levels, and what of the plane they are over."""
        level, line = np.nonzero(self.numbers >= 0)
        places = np.concatenate([self.lines[line], *(own for _, _, own in self._caps)])
        heights = [self.heights[level, line], *(np.full(len(own), height) for _, height, own in self._caps)]
        levels = np.concatenate([level, *(np.full(len(own), level) for level, _, own in self._caps)])
        return self.flat[places] + np.concatenate(heights)[:, None] * self.stack.direction, levels, places


def _height(stack: Stack, cap: int) -> float:
    return float(stack.solid.faces[cap].center @ stack.direction)


def _is_flat(stack: Stack, levels: Levels) -> bool:
    """Whether all caps lie across the direction, and all stations are level."""
    faces = (stack.solid.faces[f] for f in (*stack.source, *stack.target))
    at = np.linspace(0.0, 1.0, 9)
    rises = (np.ptp(stack.solid.edges[e].curve.evaluate(at) @ stack.direction) for e in levels.stations)
    return all(is_flat(face, stack.direction) for face in faces) and all(
        rise <= _FLAT * stack.solid.size for rise in rises
    )


def _loops(stack: Stack, mesh: QuadMesh, cell: int) -> tuple[list[IntArray], list[int]]:
    """Nodes around a cell, its outer loop first, as its quads run; and the line of each segment that begins there."""
    loops, segments = [], list[int]()
    for loop in stack.arrangement.prism.faces[stack.arrangement.bottoms[cell]].loops:
        chain, lines = [], list[int]()
        # The bottom is seen from below by its own loops, from above by its quads.
        for e, forward in reversed(loop.directed):
            nodes = mesh.edge_nodes[e][::-1] if forward else mesh.edge_nodes[e]
            chain.append(nodes[:-1])
            lines += [e] * (len(nodes) - 1)
        loops.append(np.concatenate(chain))
        segments += lines
    return loops, segments


def _modes(
    off: FloatArray, quads: IntArray, ring: IntArray, on_ring: BoolArray, same: float
) -> tuple[FloatArray, FloatArray]:
    """In which ways (n, r) a column's rim is off its layers, carried inwards, and how much of each (layers, r)."""
    if np.abs(off).max() <= same or on_ring.all():
        return np.empty((len(on_ring), 0)), np.empty((len(off), 0))
    left, sizes, right = np.linalg.svd(off, full_matrices=False)
    kept = sizes > same
    modes = np.zeros((len(on_ring), int(kept.sum())))
    modes[ring] = right[kept].T
    return carried(modes, on_ring, quads), left[:, kept] * sizes[kept]


__all__ = ["build_straight"]
