"""Relaxing quads on a surface: the worst corner goes up, or nothing moves.

Place in the flow: ``quads`` calls it on every unstructured cap, ``transfinite`` on a filling that
comes out badly.

Method: a few sweeps of Laplacian smoothing, in which no quad falls below both a good value and what
it was; then the nodes of the worst quads look around themselves for the place where the worst
corner of their quads is best, nodes that share a quad one after the other. Moves are made in the
tangent plane and brought onto the surface through its parameters; what does not hold there is
taken back.
"""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
import scipy

from ..arrays import FloatArray, IntArray
from ..brep import Surface
from .relax_kernels import best_places, quad_sines
from .relax_plane import relax_in_plane

_Number = TypeVar("_Number", bound=np.generic)

_GOOD_CORNER = 0.7
"""Corner sine above which a node may lose quality for the sake of smoothness, and none is looked after."""
_N_SWEEPS = 5
"""Laplacian sweeps; each gains less than the one before."""
_N_SEARCHES = 60
"""Rounds of looking around; they end as soon as nothing gains."""
_LEAST_GAIN = 5e-3
"""Gain of the worst corner's sine for which a node is moved."""
_DIRECTIONS = 8
"""Ways that a node looks."""
_REACHES = (0.4, 0.12, 0.03)
"""How far a node looks, in lengths of its shortest edge."""
_OFFSETS = np.concatenate(
    [
        reach * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        for angles in [2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS]
        for reach in _REACHES
    ]
)


def corner_sines(points: FloatArray, quads: IntArray, normals: FloatArray) -> FloatArray:
    """Sines (q, 4) of the corner angles of quads, seen along the nodes' normals (n, 3)."""
    out = np.empty(quads.shape)
    quad_sines(np.ascontiguousarray(points), np.ascontiguousarray(quads), np.ascontiguousarray(normals), out)
    return out


def relax_quads(
    surface: Surface, points: FloatArray, uv: FloatArray, quads: IntArray, *, n_fixed: int
) -> tuple[FloatArray, FloatArray, float]:
    """Relax quads on a surface, seen along the sweep (against the surface's outward normals).

    Parameters
    ----------
    points, uv : (n, 3), (n, 2) float64
        Nodes and their parameters; the first `n_fixed` stay.
    quads : (q, 4) int64

    Returns
    -------
    points, uv : (n, 3), (n, 2) float64
    worst : float
        Least corner sine; never less than it was.
    """
    if n_fixed < len(points):
        normals, by_uv = surface.normals(uv), surface.derivatives(uv)
        if all((rows == rows[0]).all() for rows in (normals, *by_uv)):
            return _relaxed_in_plane(surface, points, uv, quads, n_fixed)
    state = _State(surface, points, uv, quads, n_fixed)
    if n_fixed < len(points):
        state.smooth()
        state.search()
    return state.points, state.uv, float(np.min(state.sines))


def _relaxed_in_plane(
    surface: Surface, points: FloatArray, uv: FloatArray, quads: IntArray, n_fixed: int
) -> tuple[FloatArray, FloatArray, float]:
    """As :func:`relax_quads`, on a surface that is a plane."""
    frame = _tangents(-surface.normals(uv[:1])[0])
    flat = np.ascontiguousarray((points - points[0]) @ frame.T)
    given = flat.copy()
    worst = relax_in_plane(
        flat, np.ascontiguousarray(quads), n_fixed, _OFFSETS, _N_SWEEPS, _N_SEARCHES, _GOOD_CORNER, _LEAST_GAIN
    )
    moved = np.flatnonzero((flat != given).any(axis=1))
    uv, points = uv.copy(), points.copy()
    uv[moved] = _follow(surface, uv[moved], (flat[moved] - given[moved]) @ frame)
    points[moved] = surface.evaluate(uv[moved])
    return points, uv, float(worst)


def _tangents(normal: FloatArray) -> FloatArray:
    """Two unit vectors (2, 3), counter-clockwise seen along a normal, as the nodes of a curved surface have them."""
    x, y, z = np.abs(normal)
    axis = 0 if x <= y and x <= z else 1 if y <= z else 2
    first = np.cross(normal, np.eye(3)[axis])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


class _State:
    """Nodes on their surface, and the corners of their quads."""

    def __init__(self, surface: Surface, points: FloatArray, uv: FloatArray, quads: IntArray, n_fixed: int) -> None:
        self.surface = surface
        self.points = points.copy()
        self.uv = uv.copy()
        self.quads = np.ascontiguousarray(quads)
        self.n_fixed = n_fixed
        self.normals = -surface.normals(uv)
        self.sines = corner_sines(points, quads, self.normals)
        slots = np.arange(quads.size)
        self.uses = scipy.sparse.csr_matrix((slots, (quads.ravel(), slots // 4)), shape=(len(points), len(quads)))

    def _quads_of(self, nodes: IntArray) -> IntArray:
        """Ids of all quads that have one of the nodes."""
        touched = np.zeros(len(self.points), dtype=bool)
        touched[nodes] = True
        a, b, c, d = touched[self.quads].T
        return np.flatnonzero(a | b | c | d)

    def move(self, nodes: IntArray, off: FloatArray, *, singly: bool) -> None:
        """Move nodes along `off` on the surface, but for those whose quads would suffer.

        Nodes that move `singly` share no quad: the worst quad of each must not get worse. Others may
        lower no quad below both a good value and what it was.
        """
        uv = _follow(self.surface, self.uv[nodes], off)
        points, normals = self.surface.evaluate(uv), -self.surface.normals(uv)
        near = self._quads_of(nodes)
        floor = np.minimum(_least(self.sines[near]), _GOOD_CORNER)
        if singly:
            worst = np.full(len(self.points), np.inf)
            np.minimum.at(worst, self.quads[near], np.broadcast_to(floor[:, None], (len(near), 4)))
            mine = np.zeros(len(self.points), dtype=bool)
            mine[nodes] = True
            floor = np.where(mine[self.quads[near]], worst[self.quads[near]], np.inf)
            floor = _least(floor)
        moving = np.ones(len(nodes), dtype=bool)
        slot = np.full(len(self.points), -1, dtype=np.int64)
        slot[nodes] = np.arange(len(nodes))
        for _ in range(20):
            new_points, new_normals = self.points.copy(), self.normals.copy()
            new_points[nodes[moving]], new_normals[nodes[moving]] = points[moving], normals[moving]
            sines = corner_sines(new_points, self.quads[near], new_normals)
            bad = _least(sines) < floor - 1e-12
            guilty = slot[self.quads[near[bad]]]
            guilty = guilty[guilty >= 0]
            if not moving[guilty].any():
                self.points, self.normals = new_points, new_normals
                self.uv[nodes[moving]] = uv[moving]
                self.sines[near] = sines
                return
            moving[guilty] = False

    def smooth(self) -> None:
        """Laplacian smoothing, where it does no harm."""
        neighbours = _mean_matrix(self.quads, len(self.points))
        sizes = self._least_edges()
        for _ in range(_N_SWEEPS):
            off = 0.7 * (neighbours @ self.points - self.points)
            off -= np.einsum("nd,nd->n", off, self.normals)[:, None] * self.normals
            active = np.flatnonzero(np.linalg.norm(off, axis=1) > 0.01 * sizes)
            active = active[active >= self.n_fixed]
            if not len(active):
                break
            self.move(active, off[active], singly=False)

    def _least_edges(self) -> FloatArray:
        sizes = np.full(len(self.points), np.inf)
        step = np.linalg.norm(self.points[self.quads] - self.points[np.roll(self.quads, -1, axis=1)], axis=2)
        np.minimum.at(sizes, self.quads, step)
        np.minimum.at(sizes, np.roll(self.quads, -1, axis=1), step)
        return sizes

    def search(self) -> None:
        """Raise the worst quads by looking around each of their nodes."""
        tired = np.zeros(len(self.points), dtype=bool)  # found nothing, and nothing near has changed since
        for _ in range(_N_SEARCHES):
            nodes = self._choose(tired)
            if not len(nodes):
                break
            off, gain = self._best_places(nodes, _OFFSETS)
            found = gain > _LEAST_GAIN
            tired[nodes[~found]] = True
            if found.any():
                moved = nodes[found]
                self.move(moved, off[found], singly=True)
                tired[self.quads[self._quads_of(moved)].ravel()] = False

    def _choose(self, tired: npt.NDArray[np.bool_]) -> IntArray:
        """Free nodes of the worst quads, no two of which share a quad."""
        worst = _least(self.sines)
        bad = np.flatnonzero(worst < _GOOD_CORNER)
        rank = np.full(len(self.points), np.inf)
        np.minimum.at(rank, self.quads[bad], np.broadcast_to(worst[bad, None], (len(bad), 4)))
        rank[: self.n_fixed] = np.inf
        rank[tired] = np.inf
        candidates = np.flatnonzero(np.isfinite(rank))
        if not len(candidates):
            return candidates
        order = np.full(len(rank), len(rank), dtype=np.int64)
        order[candidates[np.lexsort((candidates, rank[candidates]))]] = np.arange(len(candidates))
        near = self.quads[self._quads_of(candidates)]
        first = np.full(len(rank), len(rank), dtype=np.int64)
        np.minimum.at(first, near, np.broadcast_to(_least(order[near])[:, None], near.shape))
        return candidates[order[candidates] == first[candidates]]

    def _best_places(self, nodes: IntArray, offsets: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Best of the offsets (m, 3) for each node in its tangent plane, and how much its worst corner gains."""
        off, gain = np.zeros((len(nodes), 3)), np.empty(len(nodes))
        uses = self.uses
        best_places(
            self.points, self.normals, self.quads, self.sines, uses.indptr, uses.indices, nodes, offsets, off, gain
        )
        return off, gain


def _least(rows: npt.NDArray[_Number]) -> npt.NDArray[_Number]:
    """Least value of each row of four; numpy's own reduction is several times slower on such short rows."""
    return np.minimum(np.minimum(rows[:, 0], rows[:, 1]), np.minimum(rows[:, 2], rows[:, 3]))


def _mean_matrix(quads: IntArray, n: int) -> Any:
    """Sparse matrix of the mean over the neighbours along quad edges."""
    i = np.concatenate([quads.ravel(), np.roll(quads, -1, axis=1).ravel()])
    j = np.concatenate([np.roll(quads, -1, axis=1).ravel(), quads.ravel()])
    matrix = scipy.sparse.csr_matrix((np.ones(len(i)), (i, j)), shape=(n, n))
    matrix.data[:] = 1.0
    degree = np.asarray(matrix.sum(axis=1)).ravel()
    return scipy.sparse.diags(1.0 / np.maximum(degree, 1.0)) @ matrix


def _follow(surface: Surface, uv: FloatArray, off: FloatArray) -> FloatArray:
    """Parameters after a step `off` in the tangent plane, to first order."""
    by_u, by_v = surface.derivatives(uv)
    e, f, g = ((by_u**2).sum(1), (by_u * by_v).sum(1), (by_v**2).sum(1))
    a, b = (by_u * off).sum(1), (by_v * off).sum(1)
    det = e * g - f * f
    safe = det > 1e-12 * e * g
    det = np.where(safe, det, 1.0)
    step = np.stack([(a * g - b * f) / det, (b * e - a * f) / det], axis=1)
    return uv + np.where(safe[:, None], step, 0.0)
