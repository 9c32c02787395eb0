"""A cap's face as its quads are asked for: its outline, the nodes that are given, and the sizes inside.

Place in the flow: ``quads`` makes an outline for each face of a cap; the ways of ``filling`` fill it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count, pairwise

import numpy as np

from ..arrays import FloatArray, IntArray
from ..brep import Face
from ..mesh import WallRows
from ..sweep import DirectedEdge
from .background import Background, make_background, typical_length
from .chart import Chart, surface_background
from .charts import charts_of
from .relax import relax_quads
from .transfinite import join_chains
from .walls import Walls

CORNER = (np.radians(30), np.radians(150))
"""Interior angles of a corner of a grid: within 60 degrees of the right angle that a grid wants."""
STRAIGHT = (np.radians(150), np.radians(210))
"""Interior angles inside a side of a grid: within 30 degrees of straight on."""
SMOOTH = np.pi / 6 + 1e-6
"""Greatest turn at a vertex of an outline that has no corners: a dodecagon's."""
_FINER_OUTLINE = 2.0
"""The size over the outline's typical segment beyond which quads grow towards the size inside."""
_COARSE = 1.5
"""Mean side of a quad over the length wanted in its middle beyond which quads are not what is asked for."""
_WORTH = 0.6
"""Part of the quads that growing ones must spare to be worth their irregular nodes."""


@dataclass(frozen=True, kw_only=True)
class FaceQuads:
    """Quads of one face: ids below the number of known nodes are the cap's, the others count its inner nodes on."""

    inner_points: FloatArray
    quads: IntArray
    worst: float
    """Worst corner sine; negative where a quad is folded."""
    expected: float
    """Worst corner sine on both caps, as far as the angles of their vertices tell; at most `worst`."""
    walls: tuple[WallRows, ...] = ()
    notes: tuple[str, ...] = ()
    excess: float = 1.0
    """Above 1: how much larger than allowed quads inside are, for the sizes that are wanted there."""

    def better_than(self, other: FaceQuads) -> bool:
        """Folded quads are never better, whatever is expected of the others; those that miss the sizes seldom are."""
        return self._merits() > other._merits()

    def _merits(self) -> tuple[bool, float, float]:
        return self.worst > 0, self.expected / self.excess**2, self.worst

    def enough(self, expected: float) -> bool:
        """Whether no others are worth a try: nothing worse than `expected`, and no quad too large."""
        return self.expected >= expected and self.excess <= 1.0


class _Remembered:
    """Charts that are made when they are first asked for, and handed out again after."""

    def __init__(self, charts: Iterator[Chart]) -> None:
        self._known: list[Chart] = []
        self._coming = charts

    def replayed(self) -> Iterator[Chart]:
        for place in count():
            if place == len(self._known):
                chart = next(self._coming, None)
                if chart is None:
                    return
                self._known.append(chart)
            yield self._known[place]


@dataclass(frozen=True, kw_only=True)
class Outline:
    """A face with its loops seen along the sweep, the nodes on them, and what is wanted inside."""

    face: Face
    loops: tuple[tuple[DirectedEdge, ...], ...]
    smooth: tuple[bool, ...]
    """For each loop whether it is a rim without corners, along which the walls run on smoothly."""
    counts: IntArray
    """Segments of each of the solid's edges."""
    edge_nodes: Mapping[int, IntArray]
    fractions: Mapping[int, FloatArray]
    """Arc-length fractions of the nodes of each edge."""
    known: FloatArray
    """Points of all nodes that the cap has so far, (n, 3)."""
    opposite: FloatArray
    """Interior angles of the ring's nodes on the target cap; NaN where they are not known."""
    size: float
    sizes: Callable[[FloatArray], FloatArray] | None
    walls: Walls | None = None
    """Edges along which rows of quads are laid, where there are such."""

    @cached_property
    def nodes(self) -> tuple[IntArray, ...]:
        """Nodes of each loop, each once."""
        return tuple(self.chain_nodes(loop)[:-1] for loop in self.loops)

    def chain_nodes(self, chain: Sequence[DirectedEdge]) -> IntArray:
        """Nodes along edges that follow each other, both ends included."""
        return join_chains([self.edge_nodes[e][:: 1 if forward else -1] for e, forward in chain])

    def chain_uv(self, chain: Sequence[DirectedEdge]) -> FloatArray:
        """Parameters on the face's surface of the nodes along edges that follow each other."""
        uv = self.face.surface.edge_uv
        return join_chains([uv(e, self.fractions[e])[:: 1 if forward else -1] for e, forward in chain])

    def angles(self, loop: Sequence[DirectedEdge]) -> list[float]:
        """Interior angle of the face at the vertex where each edge of a loop begins."""
        at_start = self._angles
        return [at_start[directed] for directed in loop]

    @cached_property
    def _angles(self) -> dict[DirectedEdge, float]:
        """Of all loops at once: a plate may have hundreds, and each is asked for several times."""
        return angles_by_edge(self.face)

    def four_sides(self) -> list[list[DirectedEdge]] | None:
        """Split the only loop at its four corners; None where there are not four, or opposite counts differ."""
        return four_sides(self.face, self.loops[0], self.counts) if len(self.loops) == 1 else None

    def charts(self, nodes: Sequence[IntArray]) -> Iterator[Chart]:
        """Plane charts of the face, the most faithful first; `nodes` may be turned by a place or two."""
        if all(map(np.array_equal, nodes, self.nodes)):
            return self._charts.replayed()
        return self._made_charts(nodes)

    @cached_property
    def _charts(self) -> _Remembered:
        """Several ways to fill a face ask for its charts; one that is conformal takes as long as the quads in it."""
        return _Remembered(self._made_charts(self.nodes))

    def _made_charts(self, nodes: Sequence[IntArray]) -> Iterator[Chart]:
        size = self.largest(nodes)
        return charts_of(self.face, self.loops, self.fractions, nodes, self.known, size=size)

    def largest(self, nodes: Sequence[IntArray]) -> float:
        """Wanted length inside the face, away from its outline.

        An outline that is divided coarsely goes before the size. So does one that is divided a little finer all
        around, for its curves: a few larger quads in the middle of a section would gain nothing.
        """
        outline = typical_length([self.known[ids] for ids in nodes])
        return outline if outline >= self.size / _FINER_OUTLINE else self.size

    def grows(self) -> bool:
        """Whether quads inside should be larger than those at the outline, or of sizes that a plane's are asked for.

        A lattice's cannot; on a curved face, where sizes are a matter of its curvature, they come near.
        """
        asked = self.sizes is not None and self.face.kind == "plane"
        return asked or self.largest(self.nodes) > typical_length([self.known[i] for i in self.nodes])

    def background(self, chart: Chart, nodes: Sequence[IntArray]) -> Background | None:
        """Sizes inside a chart; None where those of its outline, interpolated, do as well."""
        if chart is next(self.charts(self.nodes), None):
            return self._first_background
        return self._made_background(chart, nodes)

    @cached_property
    def _first_background(self) -> Background | None:
        """Of the first chart, which is asked whether quads must grow, before it is meshed."""
        chart = next(self.charts(self.nodes))
        return self._made_background(chart, self.nodes)

    def _made_background(self, chart: Chart, nodes: Sequence[IntArray]) -> Background | None:
        largest = self.largest(nodes)
        if self.sizes is not None or chart.conformal:
            return surface_background(chart, largest, sizes=self.sizes)
        background = make_background(chart.boundary, largest=largest)
        few = background.count_quads(chart.boundary) < _WORTH * chart.n_interpolated
        return background if few else None

    def opposite_of(self, nodes: IntArray) -> FloatArray:
        """Angles of nodes on the target cap; NaN for those on edges inside the cap, too."""
        on_ring = nodes < len(self.opposite)
        return np.where(on_ring, self.opposite[np.where(on_ring, nodes, 0)], np.nan)

    def lift(
        self,
        chart: Chart,
        inner: FloatArray,
        quads: IntArray,
        boundary: IntArray,
        *,
        n_rows: int = 0,
        rows: tuple[FloatArray, FloatArray] | None = None,
    ) -> FaceQuads:
        """Bring a chart's mesh onto the surface and relax it, but for the first `n_rows` nodes inside.

        `rows`: places and parameters of these, where they are known better than the chart does.
        """
        points, uv = chart.lift(inner)
        if rows is not None:
            points[:n_rows], uv[:n_rows] = rows
        everything = np.concatenate([self.known[boundary], points])
        n = len(boundary)
        all_uv = np.concatenate([chart.boundary_uv, uv])
        everything, _, worst = relax_quads(self.face.surface, everything, all_uv, quads, n_fixed=n + n_rows)
        ids = np.concatenate([boundary, len(self.known) + np.arange(len(inner), dtype=np.int64)])
        return self.judged(everything[n:], ids[quads], worst)

    def judged(self, inner: FloatArray, quads: IntArray, worst: float) -> FaceQuads:
        """Quads with what their corners will be where vertices of the other cap have other angles."""
        nodes, uses = np.unique(quads, return_counts=True)
        angles = self.opposite_of(nodes) / uses
        sines = np.sin(np.minimum(angles[np.isfinite(angles)], np.pi))
        return FaceQuads(
            inner_points=inner,
            quads=quads,
            worst=worst,
            expected=min([worst, *sines.tolist()]),
            excess=self._excess(inner, quads),
        )

    def _excess(self, inner: FloatArray, quads: IntArray) -> float:
        """How far quads without a node of the outline are too large: a mesher's front passes by a small crown."""
        inside = quads[(quads >= len(self.known)).all(axis=1)]
        if self.sizes is None or not len(inside):
            return 1.0
        corners = inner[inside - len(self.known)]
        lengths = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean(axis=1)
        return max(1.0, float(np.max(lengths / self.sizes(corners.mean(axis=1)))) / _COARSE)


def reversed_loop(loop: Sequence[DirectedEdge]) -> list[DirectedEdge]:
    """A face's loop run the other way: seen along the sweep instead of from outside."""
    return [(edge, not forward) for edge, forward in reversed(loop)]


def loop_angles(face: Face, loop: Sequence[DirectedEdge]) -> list[float]:
    """Interior angle of a face at the vertex where each edge of one of its reversed loops begins."""
    at_start = angles_by_edge(face)
    return [at_start[directed] for directed in loop]


def angles_by_edge(face: Face) -> dict[DirectedEdge, float]:
    """Interior angle of a face at the vertex where each edge of its reversed loops begins, for all of them."""
    # The reversed loop begins edge j where the face's own loop ends it.
    return {
        (edge, not forward): own.angles[(j + 1) % len(own.angles)]
        for own in face.loops
        for j, (edge, forward) in enumerate(own.directed)
    }


def four_sides(face: Face, loop: Sequence[DirectedEdge], counts: IntArray) -> list[list[DirectedEdge]] | None:
    """Split a reversed loop of a face at its four corners; None where there are not four, or opposite counts differ."""
    angles = loop_angles(face, loop)
    corners = [j for j, angle in enumerate(angles) if CORNER[0] < angle < CORNER[1]]
    straight = [j for j, angle in enumerate(angles) if STRAIGHT[0] <= angle <= STRAIGHT[1]]
    if len(corners) != 4 or len(corners) + len(straight) != len(angles):
        return None
    turned = list(loop[corners[0] :]) + list(loop[: corners[0]])
    cuts = [c - corners[0] for c in corners] + [len(loop)]
    sides = [turned[a:b] for a, b in pairwise(cuts)]
    sums = [int(sum(counts[e] for e, _ in side)) for side in sides]
    return sides if sums[0] == sums[2] and sums[1] == sums[3] else None
