"""Labels of a skin changed, one or two quads at a time, until faces, edges and vertices are as many as the model's.

Labels that are the least cost together may be a quad away from a skin like the model: a corner of a third face between
two that ought to meet, two vertices where three edges meet in one. What differs is counted (:mod:`.counting`); the
change that leaves the least is made, as long as there is one that leaves less.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import IntArray
from ..brep import Solid
from ..harmonic import sides_of
from .counting import count_changed, count_runs, count_skin
from .topology import closed_euler

_MOST = 25
"""How much counts may differ at first, and how often labels are changed: what takes more has no fault here or there."""
_TRIED = 25_000
"""Pairs of changes that are tried at most, each a count of all: what is mended at all mostly takes a tenth of them."""
_WORSE = 1
"""How much worse a first change may leave it that a second is tried with."""


class Skin(NamedTuple):
    """Some quads of a skin, by number, what lies between them, and the quads at every node, numbered from 0.

    Attributes
    ----------
    own : (m,) int64
    segments, beside : (s, 2) int64
        Segments of these, by nodes, and the quads on both sides of each.
    first, around : int64 arrays
        Of the quads at node i, ``around[first[i] : first[i + 1]]``.
    """

    own: IntArray
    segments: IntArray
    beside: IntArray
    first: IntArray
    around: IntArray

    @classmethod
    def of(cls, quads: IntArray) -> Skin:
        """The whole of a closed skin of quads (q, 4)."""
        segments, beside = sides_of(quads)
        nodes, local = np.unique(quads, return_inverse=True)
        first = np.append(0, np.cumsum(np.bincount(local.ravel()))).astype(np.int64)
        around = np.argsort(local.ravel(), kind="stable") // 4
        return cls(np.arange(len(quads)), np.searchsorted(nodes, segments), beside, first, around)

    def part(self, own: IntArray) -> Skin:
        """That with some of the quads of a whole one: what does not change needs not be counted."""
        is_own = np.zeros(len(self.own), dtype=bool)
        is_own[own] = True
        chosen = is_own[self.beside].any(axis=1)
        nodes, segments = np.unique(self.segments[chosen], return_inverse=True)
        counts = np.diff(self.first)[nodes]
        first = np.append(0, np.cumsum(counts)).astype(np.int64)
        at = np.repeat(self.first[nodes] - first[:-1], counts) + np.arange(first[-1])
        return Skin(own, segments.reshape(-1, 2).astype(np.int64), self.beside[chosen], first, self.around[at])

    def neighbours(self) -> IntArray:
        """The four quads (q, 4) beside every quad of a whole skin."""
        owners, others = np.concatenate([self.beside, self.beside[:, ::-1]]).T
        return np.asarray(others[np.argsort(owners, kind="stable")].reshape(-1, 4), dtype=np.int64)

    def counts(self, labels: IntArray, n_faces: int) -> tuple[IntArray, IntArray, int]:
        """Euler numbers (n,), runs (n, n), and the number of vertices."""
        euler, runs = np.empty(n_faces, dtype=np.int64), np.empty((n_faces, n_faces), dtype=np.int64)
        n_vertices = count_skin(*self, labels, euler, runs)
        return euler, runs, int(n_vertices)


class Wanted(NamedTuple):
    """Of the model: the Euler number (n,) of every face, the runs (n, n) between two, and the number of vertices."""

    euler: IntArray
    runs: IntArray
    n_vertices: int

    @classmethod
    def of(cls, solid: Solid) -> Wanted:
        ends = np.array([(edge.start, edge.end) for edge in solid.edges], dtype=np.int64).reshape(-1, 2)
        faces = np.array([edge.faces for edge in solid.edges], dtype=np.int64).reshape(-1, 2)
        runs = np.empty((len(solid.faces), len(solid.faces)), dtype=np.int64)
        n_vertices = int(count_runs(ends, faces, len(solid.vertices), runs))
        return cls(np.array([closed_euler(solid, face) for face in solid.faces], dtype=np.int64), runs, n_vertices)


def mend_labels(solid: Solid, quads: IntArray, labels: IntArray) -> IntArray:
    """Labels (q,) of quads (q, 4) with which their counts are the solid's; those given where none are found."""
    skin, wanted = Skin.of(quads), Wanted.of(solid)
    beside, now, n_tried = skin.neighbours(), labels.copy(), 0

    def changes_of(chosen: IntArray) -> IntArray:
        """Every quad of some with every other label that one beside it has (c, 2)."""
        found = np.stack([np.repeat(chosen, 4), now[beside[chosen]].ravel()], axis=1)
        return np.unique(found[now[found[:, 0]] != found[:, 1]], axis=0)

    for _ in range(_MOST):
        euler, runs, n_vertices = skin.counts(now, len(solid.faces))
        amiss = abs(euler - wanted.euler).sum() + abs(runs - wanted.runs).sum() + abs(n_vertices - wanted.n_vertices)
        if amiss == 0:
            return now
        border = np.flatnonzero((now[beside] != now[:, None]).any(axis=1))
        part = skin.part(np.union1d(border, beside[border]))
        left_out = euler - part.counts(now, len(euler))[0]

        def left_by(changes: IntArray) -> IntArray:
            """What counts differ by after each change (c, k, 2)."""
            ours = (wanted.euler - left_out, wanted.runs, wanted.n_vertices)  # noqa: B023
            return np.asarray(count_changed(*part, now, *ours, changes))  # noqa: B023

        touched = np.unique([*np.flatnonzero(euler != wanted.euler), *np.argwhere(runs != wanted.runs).ravel()])
        near = np.isin(now[border], touched) | np.isin(now[beside[border]], touched).any(axis=1)
        tried = changes_of(border[near] if len(touched) else border)[:, None]
        if amiss > _MOST or not len(tried):
            break
        left = left_by(tried)
        if left.min() >= amiss:
            pairs = []
            for quad, label in tried[left <= amiss + _WORSE, 0].tolist():
                kept, now[quad] = now[quad], label
                pairs += [((quad, label), other) for other in changes_of(beside[quad]).tolist() if other[0] != quad]
                now[quad] = kept
            n_tried += len(pairs)
            if not pairs or n_tried > _TRIED:
                break
            tried = np.array(pairs)
            left = left_by(tried)
        if left.min() >= amiss:
            break
        alike = (now[beside[tried[:, :, 0]]] == tried[:, :, 1, None]).sum(axis=(1, 2))
        best = tried[np.lexsort((-alike, left))[0]]
        now[best[:, 0]] = best[:, 1]
    return labels
