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

_MOST = 40
"""Quads changed at most: what takes more is not a skin with a fault here or there."""
_WORSE = 1
"""How much worse a first change may leave it that a second is tried with."""


class Skin(NamedTuple):
    """Quads (q, 4) by their corners from 0, what lies between them, and the quads at every corner.

    Attributes
    ----------
    quads : (q, 4) int64
    segments, beside : (s, 2) int64
        Segments, and the quads on both sides of each.
    first, around : int64 arrays
        Of the quads at corner i, ``around[first[i] : first[i + 1]]``.
    """

    quads: IntArray
    segments: IntArray
    beside: IntArray
    first: IntArray
    around: IntArray

    @classmethod
    def of(cls, quads: IntArray) -> Skin:
        segments, beside = sides_of(quads)
        nodes, local = np.unique(quads, return_inverse=True)
        local = local.reshape(-1, 4).astype(np.int64)
        first = np.append(0, np.cumsum(np.bincount(local.ravel()))).astype(np.int64)
        around = np.argsort(local.ravel(), kind="stable") // 4
        return cls(local, np.searchsorted(nodes, segments), beside, first, around)

    def neighbours(self) -> IntArray:
        """The four quads (q, 4) beside every quad."""
        owners, others = np.concatenate([self.beside, self.beside[:, ::-1]]).T
        return np.asarray(others[np.argsort(owners, kind="stable")].reshape(-1, 4), dtype=np.int64)


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
    beside, now = skin.neighbours(), labels.copy()

    def changes_of(chosen: IntArray) -> IntArray:
        """Every quad of some with every other label that one beside it has (c, 2)."""
        found = np.stack([np.repeat(chosen, 4), now[beside[chosen]].ravel()], axis=1)
        return np.unique(found[now[found[:, 0]] != found[:, 1]], axis=0)

    def best_of(changes: IntArray) -> tuple[int, IntArray, IntArray]:
        """What counts differ by at the least, the change (k, 2) that leaves that, and what each leaves."""
        left = np.asarray(count_changed(*skin, now, *wanted, changes))
        alike = (now[beside[changes[:, :, 0]]] == changes[:, :, 1, None]).sum(axis=(1, 2))
        best = np.lexsort((-alike, left))[0]
        return int(left[best]), changes[best], left

    amiss = best_of(np.array([[[0, now[0]]]]))[0]
    for _ in range(_MOST):
        if amiss == 0:
            return now
        singles = changes_of(_near(skin, wanted, beside, now))
        if not len(singles):
            break
        least, best, left = best_of(singles[:, None])
        if least >= amiss:
            pairs = []
            for quad, label in singles[left <= amiss + _WORSE].tolist():
                kept, now[quad] = now[quad], label
                pairs += [((quad, label), other) for other in changes_of(beside[quad]).tolist() if other[0] != quad]
                now[quad] = kept
            if not pairs:
                break
            least, best, _ = best_of(np.array(pairs))
        if least >= amiss:
            break
        now[best[:, 0]] = best[:, 1]
        amiss = least
    return labels


def _near(skin: Skin, wanted: Wanted, beside: IntArray, labels: IntArray) -> IntArray:
    """Quads on a border of faces whose counts differ; on any where none of these do."""
    border = np.flatnonzero((labels[beside] != labels[:, None]).any(axis=1))
    euler, runs = np.empty_like(wanted.euler), np.empty_like(wanted.runs)
    count_skin(*skin, labels, euler, runs)
    touched = np.unique([*np.flatnonzero(euler != wanted.euler), *np.argwhere(runs != wanted.runs).ravel()])
    if not len(touched):
        return border
    return border[np.isin(labels[border], touched) | np.isin(labels[beside[border]], touched).any(axis=1)]
