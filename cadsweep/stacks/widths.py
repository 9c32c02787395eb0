"""How wide the cells of an arrangement are at places along their edges.

Place in the flow: after outlines were laid together, for who chooses the lengths of segments.

Method: every edge is sampled; the width of a cell at a sample is the distance to the nearest edge across it, which is
one that does not meet its own. Where a corner comes near to an edge, that edge has samples around the nearest place,
the closer to each other the nearer they are, so that no pinch is missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..stack import Stack
from .along import across

_STEP = 0.25
"""Distance between two samples, in the largest width that is looked for."""
_SAMPLES = (4, 65)
"""Fewest and most samples along an edge, but for those at pinches."""


class Widths:
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
        self._frame = across(stack.direction)
        self._edges = stack.arrangement.prism.edges
        self._reach = reach
        self.fractions: dict[int, FloatArray] = {}
        self.places: dict[int, FloatArray] = {}
        self.widths: dict[int, FloatArray] = {}
        for e in stack.arrangement.over:
            n = int(np.clip(np.ceil(self._edges[e].length / (_STEP * reach)), *_SAMPLES))
            self.fractions[e] = np.linspace(0.0, 1.0, n + 1)
            self.places[e] = self._on(e, self.fractions[e])
            self.widths[e] = np.full(n + 1, np.inf)
        pinches: list[tuple[int, float, FloatArray]] = []
        for f in stack.arrangement.bottoms:
            pinches += self._across_cell(stack.arrangement.prism.faces[f].edges)
        for e, at, corner in pinches:
            self._add(e, at, corner)

    def _on(self, e: int, fractions: FloatArray) -> FloatArray:
        return np.asarray(self._edges[e].curve.evaluate(fractions) @ self._frame.T)

    def _across_cell(self, edges: Sequence[int]) -> list[tuple[int, float, FloatArray]]:
        """Lessen the widths of edges by those of one cell; return where corners are near to edges across it."""
        points = np.concatenate([self.places[e] for e in edges])
        starts = np.concatenate([self.places[e][:-1] for e in edges])
        steps = np.concatenate([np.diff(self.places[e], axis=0) for e in edges])
        counts = np.array([len(self.places[e]) for e in edges])
        owner, segment_owner = (np.repeat(np.arange(len(edges)), n) for n in (counts, counts - 1))
        reach = self._reach + np.linalg.norm(steps, axis=1).max() / 2.0
        near = scipy.spatial.cKDTree(points).query_ball_tree(scipy.spatial.cKDTree(starts + steps / 2.0), reach)
        i = np.repeat(np.arange(len(points)), [len(own) for own in near])
        j = np.fromiter(chain.from_iterable(near), dtype=np.int64, count=len(i))
        ends = np.array([(self._edges[e].start, self._edges[e].end) for e in edges])
        meet = (ends[:, None, :, None] == ends[None, :, None, :]).any(axis=(2, 3))
        beyond = ~meet[owner[i], segment_owner[j]]
        i, j = i[beyond], j[beyond]
        along = np.clip(
            ((points[i] - starts[j]) * steps[j]).sum(axis=1) / np.maximum((steps[j] ** 2).sum(axis=1), 1e-300), 0.0, 1.0
        )
        distances = np.linalg.norm(starts[j] + along[:, None] * steps[j] - points[i], axis=1)
        widths = np.full(len(points), np.inf)
        np.minimum.at(widths, i, distances)
        firsts = np.cumsum([0, *counts])
        for e, first, last in zip(edges, firsts[:-1], firsts[1:], strict=True):
            self.widths[e] = np.minimum(self.widths[e], widths[first:last])
        return self._pinches(edges, (i, j, along, distances), points, firsts)

    def _pinches(
        self,
        edges: Sequence[int],
        pairs: tuple[IntArray, IntArray, FloatArray, FloatArray],
        points: FloatArray,
        firsts: IntArray,
    ) -> list[tuple[int, float, FloatArray]]:
        """Where along edges (edge, fraction) the corners (2,) of their cell are nearest to them."""
        i, j, along, distances = pairs
        segments = firsts - np.arange(len(firsts))
        at_corner = np.isin(i, firsts[:-1]) & (distances < self._reach)
        i, j, along, distances = i[at_corner], j[at_corner], along[at_corner], distances[at_corner]
        found = []
        owner = np.searchsorted(segments, j, side="right") - 1
        order = np.lexsort((distances, owner, i))
        for k, after in zip(order.tolist(), [-1, *order.tolist()], strict=False):
            if after >= 0 and i[after] == i[k] and owner[after] == owner[k]:
                continue  # not the nearest place of that edge
            e = edges[int(owner[k])]
            n = len(self.fractions[e]) - 1
            found.append((e, (int(j[k] - segments[owner[k]]) + float(along[k])) / n, points[i[k]]))
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
