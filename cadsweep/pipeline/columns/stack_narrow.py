"""Segments of a stack's arrangement that suit the widths of its cells, where one size for all of them is too coarse.

Method: a segment is no longer than the cell beside it is wide, and away from a narrow place lengths grow by a share of
the way, across all outlines, so that neither a cell nor a corner has segments of very unlike lengths around it. Edges
along which the length changes are divided by it.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ... import stacks
from ...arrays import FloatArray, IntArray
from ...stack import Stack
from ...surface import limited_sizes, triangulated
from ..wishes.stack_hints import StackHints

_WIDE = 1.0
"""Length of a segment at most, in widths of the cell."""
_GROWTH = 0.6
"""Share of the way from a narrow place by which segments are longer than there."""
_LEAST = 1.0 / 64.0
"""Length of a segment at least, in sizes: a crack thinner than that asks for more quads than it is worth."""
_VARIES = 1.05
"""Greatest length along an edge over the least from which on it is divided unevenly."""
_SAME = 1e-9
"""Distance, in sizes of the part, up to which samples of different edges are one place."""


def narrow_hints(stack: Stack, hints: StackHints, counts: IntArray, size: float) -> StackHints:
    """The hints with shorter segments at narrow places; what the user asked of single edges stays.

    Parameters
    ----------
    stack : Stack
    hints : StackHints
    counts : (n_edges,) int64
        Segments that edges of the arrangement have otherwise; nowhere are they fewer.
    size : float
        Of the mesh, working units.
    """
    edges = stack.arrangement.prism.edges
    widths = stacks.Widths(stack, size)
    own = {
        e: np.minimum(np.maximum(_WIDE * wide, _LEAST * size), edges[e].length / max(1, int(counts[e])))
        for e, wide in widths.widths.items()
    }
    lengths = _graded(stack, widths, own)
    asked = hints.fixed | hints.plane.divisions.keys()
    most = hints.plane.wishes.most_sizes
    sizes, divisions = {}, {}
    for e, along in lengths.items():
        if e in asked:
            continue
        fractions = widths.fractions[e]
        steps = np.diff(fractions) * 2.0 / (along[1:] + along[:-1])
        run = np.concatenate([[0.0], np.cumsum(steps)])
        sizes[e] = min(1.0 / float(run[-1]), most.get(e, np.inf))
        if along.max() > _VARIES * along.min():
            divisions[e] = partial(_by_run, run=run / run[-1], fractions=fractions)
    return hints.finer(sizes, divisions)


def _graded(stack: Stack, widths: stacks.Widths, own: dict[int, FloatArray]) -> dict[int, FloatArray]:
    """Lengths at all samples that rise from place to place by no more than they may."""
    places = np.concatenate([widths.places[e] for e in own])
    _, first, number = np.unique(
        np.round(places / (_SAME * stack.solid.size)), axis=0, return_index=True, return_inverse=True
    )
    least = np.full(len(first), np.inf)
    np.minimum.at(least, number.ravel(), np.concatenate(list(own.values())))
    graded = limited_sizes(places[first], triangulated(places[first]), least, _GROWTH)[number.ravel()]
    offsets = np.cumsum([len(along) for along in own.values()])[:-1]
    return dict(zip(own, np.split(graded, offsets), strict=True))


def _by_run(n: int, *, run: FloatArray, fractions: FloatArray) -> FloatArray:
    """Fractions (n + 1,) of n segments, from the share of them before each of some places."""
    found = np.interp(np.linspace(0.0, 1.0, n + 1), run, fractions)
    found[0], found[-1] = 0.0, 1.0
    return np.asarray(found)


__all__ = ["narrow_hints"]
