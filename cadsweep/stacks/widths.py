"""How wide the cells of an arrangement are at places along their edges.

Place in the flow: after outlines were laid together, for who chooses the lengths of segments.

Method: every edge is sampled; the width of a cell at a sample is the distance to the nearest edge across it, which is
one that does not meet its own. Where a corner comes near to an edge, that edge has samples around the nearest place,
the closer to each other the nearer they are, so that no pinch is missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
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
    one, at : (m,) int64
        Edge and number of a sample.
    other, segment : (m,) int64
        Edge and number of a segment, which does not meet the other edge.
    along : (m,) float64
        Where on the segment the nearest place is, from 0 to 1.
    distances : (m,) float64
    """

    one: IntArray
    at: IntArray
    other: IntArray
    segment: IntArray
    along: FloatArray
    distances: FloatArray


def pairs_across(all_edges: Sequence[Edge], edges: Sequence[int], places: dict[int, FloatArray], reach: float) -> Pairs:
    """Find the samples of a cell's edges, and the segments between others, within reach of each other, or hardly more.

    Parameters
    ----------
    all_edges : sequence of Edge
    edges : sequence of int
        Those of the cell.
    places : dict of int to (n, 2) float64
    reach : float
    """
    points = np.concatenate([places[e] for e in edges])
    starts = np.concatenate([places[e][:-1] for e in edges])
    steps = np.concatenate([np.diff(places[e], axis=0) for e in edges])
    counts = np.array([len(places[e]) for e in edges])
    owner, segment_owner = (np.repeat(np.arange(len(edges)), n) for n in (counts, counts - 1))
    reach = reach + np.linalg.norm(steps, axis=1).max() / 2.0
    near = scipy.spatial.cKDTree(points).query_ball_tree(scipy.spatial.cKDTree(starts + steps / 2.0), reach)
    i = np.repeat(np.arange(len(points)), [len(own) for own in near])
    j = np.fromiter(chain.from_iterable(near), dtype=np.int64, count=len(i))
    ends = np.array([(all_edges[e].start, all_edges[e].end) for e in edges])
    meet = (ends[:, None, :, None] == ends[None, :, None, :]).any(axis=(2, 3))
    beyond = ~meet[owner[i], segment_owner[j]]
    i, j = i[beyond], j[beyond]
    along = np.clip(
        ((points[i] - starts[j]) * steps[j]).sum(axis=1) / np.maximum((steps[j] ** 2).sum(axis=1), 1e-300), 0.0, 1.0
    )
    ids, firsts = np.array(edges), np.concatenate([[0], np.cumsum(counts)])
    return Pairs(
        one=ids[owner[i]],
        at=i - firsts[owner[i]],
        other=ids[segment_owner[j]],
        segment=j - (firsts - np.arange(len(firsts)))[segment_owner[j]],
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
        pinches: list[tuple[int, float, FloatArray]] = []
        for f in stack.arrangement.bottoms:
            pairs = pairs_across(self._edges, stack.arrangement.prism.faces[f].edges, self.places, reach)
            for e in np.unique(pairs.one).tolist():
                own = pairs.one == e
                np.minimum.at(self.widths[e], pairs.at[own], pairs.distances[own])
            pinches += self._pinches(pairs)
        for e, at, corner in pinches:
            self._add(e, at, corner)

    def _pinches(self, pairs: Pairs) -> list[tuple[int, float, FloatArray]]:
        """Where along edges (edge, fraction) the first corners (2,) of edges of their cell are nearest to them."""
        at_corner = (pairs.at == 0) & (pairs.distances < self._reach)
        one, _, other, segment, along, distances = (part[at_corner] for part in pairs)
        found = []
        order = np.lexsort((distances, other, one))
        for k, after in zip(order.tolist(), [-1, *order.tolist()], strict=False):
            if after >= 0 and one[after] == one[k] and other[after] == other[k]:
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
