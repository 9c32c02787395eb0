"""How wide the cells of an arrangement are at places along their edges.

Place in the flow: after outlines were laid together, for who chooses the lengths of segments.

Method: every edge is sampled; the width of a cell at a sample is the distance to the nearest edge across it, which is
one that does not meet its own. Where a corner comes near to an edge, that edge has samples around the nearest place,
the closer to each other the nearer they are, so that no pinch is missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..brep import Edge
from ..stack import Stack
from .along import across

_STEP = 0.25
"""Distance between two samples, in the largest width that is looked for."""
_SAMPLES = (4, 65)
"""Fewest and most samples along an edge, but for those at pinches."""


class Samples:
    """Places along the edges of an arrangement.

    Attributes
    ----------
    fractions : dict of int to (n,) float64
        By edge: where along it, from 0 to 1.
    places : dict of int to (n, 2) float64
        In the frame of :func:`~cadsweep.stacks.along.across`.
    """

    def __init__(self, stack: Stack, reach: float) -> None:
        """`reach`: a few samples lie within it, working units."""
        self._frame = across(stack.direction)
        self._edges = stack.arrangement.prism.edges
        self.fractions: dict[int, FloatArray] = {}
        self.places: dict[int, FloatArray] = {}
        for e in stack.arrangement.over:
            n = int(np.clip(np.ceil(self._edges[e].length / (_STEP * reach)), *_SAMPLES))
            self.fractions[e] = np.linspace(0.0, 1.0, n + 1)
            self.places[e] = self._on(e, self.fractions[e])

    def _on(self, e: int, fractions: FloatArray) -> FloatArray:
        return np.asarray(self._edges[e].curve.evaluate(fractions) @ self._frame.T)

    def lifted(self, place: FloatArray) -> FloatArray:
        """A place (2,) as a point (3,)."""
        return np.asarray(place @ self._frame)


class Pairs(NamedTuple):
    """Samples and segments of other edges of one cell near them.

    Attributes
    ----------
    cell : (m,) int64
        Which cell, by its place among those asked for.
    one, at : (m,) int64
        Edge and number of a sample.
    other, segment : (m,) int64
        Edge and number of a segment, which does not meet the other edge.
    along : (m,) float64
        Where on the segment the nearest place is, from 0 to 1.
    distances : (m,) float64
    """

    cell: IntArray
    one: IntArray
    at: IntArray
    other: IntArray
    segment: IntArray
    along: FloatArray
    distances: FloatArray


def pairs_across(
    all_edges: Sequence[Edge], cells: Sequence[Sequence[int]], places: dict[int, FloatArray], reach: float
) -> Pairs:
    """Find the samples of cells' edges, and the segments between others, within reach of each other, or hardly more.

    Parameters
    ----------
    all_edges : sequence of Edge
    cells : sequence of sequence of int
        Edges of each.
    places : dict of int to (n, 2) float64
    reach : float
    """
    edges = np.array([e for own in cells for e in own], dtype=np.int64)
    cell = np.repeat(np.arange(len(cells)), [len(own) for own in cells])
    points = np.concatenate([np.empty((0, 2)), *(places[e] for e in edges.tolist())])
    counts = np.array([len(places[e]) for e in edges.tolist()], dtype=np.int64)
    firsts = np.concatenate([[0], np.cumsum(counts)])[:-1]
    owner, segment_owner = (np.repeat(np.arange(len(edges)), n) for n in (counts, counts - 1))
    begin = np.flatnonzero(np.diff(owner, append=-1) == 0)
    starts, steps = points[begin], points[begin + 1] - points[begin]
    longest = np.zeros(len(cells))
    np.maximum.at(longest, cell[segment_owner], np.linalg.norm(steps, axis=1))
    # One search for all: each cell in its own reach, and on a floor of its own.
    floors, within = cell.astype(np.float64), reach + longest[cell] / 2.0
    one, other = (
        scipy.spatial.cKDTree(np.column_stack([own / within[of][:, None], 2.0 * floors[of]]))
        for own, of in ((points, owner), (starts + steps / 2.0, segment_owner))
    )
    near = one.sparse_distance_matrix(other, 1.0, output_type="ndarray")
    i, j = near["i"], near["j"]
    ends = np.array([(all_edges[e].start, all_edges[e].end) for e in edges.tolist()], dtype=np.int64).reshape(-1, 2)
    beyond = ~(ends[owner[i], :, None] == ends[segment_owner[j], None, :]).any(axis=(1, 2))
    order = np.lexsort((j[beyond], i[beyond]))
    i, j = i[beyond][order], j[beyond][order]
    along = np.clip(
        ((points[i] - starts[j]) * steps[j]).sum(axis=1) / np.maximum((steps[j] ** 2).sum(axis=1), 1e-300), 0.0, 1.0
    )
    return Pairs(
        cell=cell[owner[i]],
        one=edges[owner[i]],
        at=i - firsts[owner[i]],
        other=edges[segment_owner[j]],
        segment=begin[j] - firsts[segment_owner[j]],
        along=along,
        distances=np.linalg.norm(starts[j] + along[:, None] * steps[j] - points[i], axis=1),
    )


class Widths(Samples):
    """Samples along the edges of an arrangement, and the least width of the cells beside them.

    Attributes
    ----------
    fractions, widths : dict of int to (n,) float64
        By edge: where along it, from 0 to 1, and how wide; infinite where nothing is within reach.
    places : dict of int to (n, 2) float64
        In the frame of :func:`~cadsweep.stacks.along.across`.
    """

    def __init__(self, stack: Stack, reach: float) -> None:
        """`reach`: largest width that is looked for, working units."""
        super().__init__(stack, reach)
        self._reach = reach
        self.widths = {e: np.full(len(own), np.inf) for e, own in self.fractions.items()}
        faces = stack.arrangement.prism.faces
        pairs = pairs_across(self._edges, [faces[f].edges for f in stack.arrangement.bottoms], self.places, reach)
        order = np.argsort(pairs.one, kind="stable")
        ids, firsts = np.unique(pairs.one[order], return_index=True)
        for e, own in zip(ids.tolist(), np.split(order, firsts[1:]), strict=False):
            np.minimum.at(self.widths[e], pairs.at[own], pairs.distances[own])
        for e, at, corner in self._pinches(pairs):
            self._add(e, at, corner)

    def _pinches(self, pairs: Pairs) -> list[tuple[int, float, FloatArray]]:
        """Where along edges (edge, fraction) the first corners (2,) of edges of their cell are nearest to them."""
        at_corner = (pairs.at == 0) & (pairs.distances < self._reach)
        cell, one, _, other, segment, along, distances = (part[at_corner] for part in pairs)
        found = []
        order = np.lexsort((distances, other, one, cell))
        for k, after in zip(order.tolist(), [-1, *order.tolist()], strict=False):
            if after >= 0 and cell[after] == cell[k] and one[after] == one[k] and other[after] == other[k]:
                continue  # not the nearest place of that edge
            e = int(other[k])
            n = len(self.fractions[e]) - 1
            found.append((e, (int(segment[k]) + float(along[k])) / n, self.places[int(one[k])][0]))
        return found

    def _add(self, e: int, at: float, corner: FloatArray) -> None:
        """Samples around the place of an edge that is nearest to a corner."""
        length = self._edges[e].length
        width = max(float(np.linalg.norm(self._on(e, np.array([at]))[0] - corner)), 1e-6 * self._reach)
        offsets = width * 2.0 ** np.arange(-1, np.ceil(np.log2(self._reach / width)) + 1) / length
        fractions = at + np.concatenate([-offsets, [0.0], offsets])
        fractions = fractions[(fractions > 0.0) & (fractions < 1.0)]
        places = self._on(e, fractions)
        everywhere = np.concatenate([self.fractions[e], fractions])
        order = np.argsort(everywhere, kind="stable")
        self.fractions[e] = everywhere[order]
        self.places[e] = np.concatenate([self.places[e], places])[order]
        self.widths[e] = np.concatenate([self.widths[e], np.linalg.norm(places - corner, axis=1)])[order]


__all__ = ["Widths"]
