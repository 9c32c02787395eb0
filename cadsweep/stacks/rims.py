"""Heights of free levels along the lines between cells, evened out: no level jumps where a rim ends.

Place in the flow: after the levels over every place are filled by themselves (:mod:`.nodes`, :mod:`.straight`).

Method: over two places beside each other a level may be a cap's rim at one and free at the other. Filled by the known
levels of its own place alone, it jumps there, however near the two are: a quad of a wall at a pinch of
the plane is then narrow and steep, all but flat. A wall is a strip, along by lengths and upwards by the mean heights
of the levels; by how much a level is off its mean height solves Laplace's equation there, the known levels given. Short
sides of quads from line to line are strips, too: lines that come near each other are as one. Where that would bring two
levels near each other, the layer between them keeps part of its height, and the others of its place give way.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
import scipy

from ..arrays import BoolArray, FloatArray, IntArray

_SAME = 1e-9
"""Part of all heights by which a known level may be off its mean height without anything being evened out."""
_SHORT = 0.5
"""Length of a side, in layers, up to which what it joins is evened out."""
_ACCURACY = 1e-12
"""Residual, beside what is given, at which the evened heights are taken as solved."""
_LEAST = 0.1
"""Part of its height filled by itself that a layer keeps in any case."""


def segments_of(lines: Iterable[IntArray], sides: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Pairs of nodes (s, 2) next to each other on the lines, or at the ends of sides (t, 2), and their distances."""
    pairs = np.concatenate([*(np.stack([line[:-1], line[1:]], axis=1) for line in lines), sides])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    return pairs, np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1)


def short_sides(quads: IntArray, points: FloatArray, means: FloatArray) -> IntArray:
    """Pairs of nodes (s, 2) at the ends of the sides of quads (q, 4) that are short beside layers of mean heights."""
    corners = points[quads]
    following = [1, 2, 3, 0]
    lengths = np.linalg.norm(corners[:, following] - corners, axis=2)
    q, i = np.nonzero(lengths < _SHORT * float(np.diff(means).mean()))
    return np.unique(np.sort(np.stack([quads[q, i], quads[q, (i + 1) % 4]], axis=1), axis=1), axis=0)


def even_out(  # noqa: PLR0917
    below: FloatArray, above: FloatArray, known: BoolArray, means: FloatArray, segments: IntArray, lengths: FloatArray
) -> FloatArray:
    """Heights of all levels along lines; of a known level that is open, the middle.

    Parameters
    ----------
    below, above : (n_levels, n) float64
        Where the layer below a level ends and the one above it begins, filled over every place by itself; NaN below the
        lowest known level and above the highest. Only known ones may differ.
    known : (n_levels, n) bool
        Where they stay.
    means : (n_levels,) float64
        Mean heights of the levels, rising.
    segments : (s, 2) int
        Places beside each other.
    lengths : (s,) float64
        Their distances.
    """
    heights = 0.5 * (below + above)
    there = np.isfinite(heights)
    free = there & ~known
    off = np.where(there, heights - means[:, None], 0.0)
    if not free.any() or float(np.abs(off[known]).max()) <= _SAME * float(means[-1] - means[0]):
        return heights
    n = heights.shape[1]
    number = np.arange(heights.size).reshape(heights.shape)
    steps = np.diff(means)
    share = 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))
    reach = np.bincount(segments.ravel(), weights=np.repeat(0.5 * lengths, 2), minlength=n)
    a, b = segments.T
    beside = there[:, a] & there[:, b]
    over = there[:-1] & there[1:]
    along, upwards = share[:, None] / lengths, reach / steps[:, None]
    first = np.concatenate([number[:, a][beside], number[:-1][over]])
    second = np.concatenate([number[:, b][beside], number[1:][over]])
    weights = np.concatenate([along[beside], upwards[over]])
    matrix = scipy.sparse.coo_array(
        (np.tile(weights, 2), (np.append(first, second), np.append(second, first))), shape=(heights.size,) * 2
    ).tocsr()
    inner, outer = np.flatnonzero(free), np.flatnonzero(known & there)
    rows = matrix[inner]
    degree = np.asarray(matrix.sum(axis=1)).ravel()[inner]
    wanted = heights.copy()
    wanted.ravel()[inner] = _solved(rows[:, inner], degree, rows[:, outer] @ off.ravel()[outer])
    wanted[free] += np.broadcast_to(means[:, None], heights.shape)[free]
    return _in_order(heights, below, above, wanted, known)


def _solved(beside: scipy.sparse.csr_array, degree: FloatArray, given: FloatArray) -> FloatArray:
    """Solve (D - B) x = g for the degrees D and weights B of a graph.

    By conjugate gradients, scaled by the degrees: where many short sides lie beside each other, the graph fills space,
    and its factors would take minutes where this takes a second. Its measure of error weighs differences along short
    segments as the quads there need it. Inner products are numpy's own: the threads of BLAS wait for each other on a
    busy machine, which took ten times as long as the rest for 10,000 unknowns.
    """
    scale = scipy.sparse.diags_array(1.0 / np.sqrt(degree))
    matrix = scipy.sparse.csr_array(scipy.sparse.eye_array(len(degree)) - scale @ beside @ scale)
    found, left = np.zeros(len(degree)), scale @ given
    along, off = left, np.einsum("i,i->", left, left)
    enough = _ACCURACY**2 * off
    for _ in range(10 * len(degree)):
        if off <= enough:
            return np.asarray(scale @ found)
        turned = matrix @ along
        step = off / np.einsum("i,i->", along, turned)
        found = found + step * along
        left = left - step * turned
        before, off = off, np.einsum("i,i->", left, left)
        along = left + off / before * along
    raise AssertionError("a Laplacian with known levels is positive definite")


def _in_order(
    heights: FloatArray, below: FloatArray, above: FloatArray, wanted: FloatArray, known: BoolArray
) -> FloatArray:
    """The wanted heights, where every layer between two known levels keeps its part of its own height.

    Layers that would be lower get that part, and the others between the same known levels give what it takes.
    """
    found = heights.copy()
    patterns, which = np.unique(known, axis=1, return_inverse=True)
    for j, rows in enumerate(patterns.T):
        nodes = np.flatnonzero(which.ravel() == j)
        for low, high in pairwise(np.flatnonzero(rows)):
            if high - low == 1:
                continue
            between = slice(low + 1, high)
            first, last = above[low, nodes], below[high, nodes]
            least = _LEAST * np.diff(np.vstack([first, heights[between, nodes], last]), axis=0)
            spare = np.maximum(np.diff(np.vstack([first, wanted[between, nodes], last]), axis=0) - least, 0.0)
            room, asked = (last - first) - least.sum(axis=0), spare.sum(axis=0)
            with np.errstate(invalid="ignore"):
                layers = least + spare * np.where(asked > room, room / asked, 1.0)
            found[between, nodes] = np.where(
                asked > room * (1.0 + _ACCURACY), first + np.cumsum(layers, axis=0)[:-1], wanted[between, nodes]
            )
    return found


__all__ = ["even_out", "segments_of", "short_sides"]
