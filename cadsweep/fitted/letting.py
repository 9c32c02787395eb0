"""Edges that a grid cannot hold, let go: the fewest whose faces have to be one for the rest to be found on its skin.

Method: the model and the labelled skin are the same kind of thing, faces that are parted by pieces of edges. Of both is
counted what must agree: the holes of every face (its Euler number), the runs of edges between every two, the places
where these end; and of every edge, whether the skin has a border of its faces about where it is. Faces are made one,
two at a time, always those whose edges are the least missed for what their going mends, until nothing differs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import pi
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..arrays import FloatArray, IntArray, distinct
from ..brep import Edge, Solid
from ..errors import SurfaceMeshError
from ..harmonic import sides_of
from .counting import count_runs

_FLAT = 0.05
"""What an edge that does not turn is missed, over one that turns by a straight angle."""
_MOST = 0.25
"""Share of the edges, by length and by how far they turn, that may go: a mesh with less of them is another part's."""
_ASTRAY = 2.0
"""Cells from a place of an edge within which its faces have to meet on the skin."""
_ALONG = np.array([0.2, 0.5, 0.8])
"""Places of an edge that are looked at."""


class Parted(NamedTuple):
    """A closed surface in faces.

    Attributes
    ----------
    ends : (s, 2) int64
        Nodes of the pieces of edges.
    faces : (s, 2) int64
        Faces beside each.
    euler : (n_faces,) int64
        Euler number of what is inside each.
    places : (s, k, 3) float64
        Of each piece.
    """

    ends: IntArray
    faces: IntArray
    euler: IntArray
    places: FloatArray

    def bordering(self, of_face: IntArray) -> IntArray:
        """For every piece a number that says which two faces are beside it, -1 inside one."""
        one, other = of_face[self.faces].T
        return np.where(one == other, -1, np.minimum(one, other) * len(of_face) + np.maximum(one, other))

    def in_runs(self) -> tuple[Parted, IntArray]:
        """The same with pieces that follow each other made one, without places; and which one each (s,) has become.

        What is counted stays as it is: between the same two faces a piece and a node more or less are as good as none.
        """
        degree = np.bincount(self.ends.ravel())
        order = np.argsort(self.ends, axis=None, kind="stable")
        nodes = self.ends.ravel()[order]
        follows = np.flatnonzero((nodes[1:] == nodes[:-1]) & (degree[nodes[1:]] == 2))
        one, other = order[follows] // 2, order[follows + 1] // 2
        graph = coo_array((np.ones(len(one)), (one, other)), shape=(len(self.ends), len(self.ends)))
        n_runs, run = connected_components(graph, directed=False)
        ends, faces = np.empty((n_runs, 2), dtype=np.int64), np.empty((n_runs, 2), dtype=np.int64)
        ends[run], faces[run] = self.ends[:, :1], self.faces  # of a ring any node
        is_end = degree[self.ends] != 2
        of_end = np.repeat(run, 2)[is_end.ravel()]
        in_turn = np.argsort(of_end, kind="stable")
        ends[of_end[in_turn][::2]] = self.ends[is_end][in_turn].reshape(-1, 2)
        return Parted(ends, faces, self.euler, np.empty((n_runs, 0, 3))), run.astype(np.int64)

    def counts(self, of_face: IntArray) -> tuple[IntArray, int]:
        """What two of them must have alike, once faces with the same number in `of_face` (n,) are one.

        Runs of edges between every two faces (n, n), low first, and on the diagonal the Euler number of each; and the
        number of vertices.
        """
        sides, n = of_face[self.faces], len(of_face)
        is_border = sides[:, 0] != sides[:, 1]
        n_nodes = int(self.ends.max(initial=-1)) + 1
        at = distinct((sides[:, :, None] * n_nodes + self.ends[:, None]).ravel())
        holes = np.bincount(of_face, weights=self.euler, minlength=n).astype(np.int64)
        holes += np.bincount(at // max(n_nodes, 1), minlength=n)
        holes -= np.bincount(sides[:, 0], minlength=n) + np.bincount(sides[is_border, 1], minlength=n)
        runs = np.empty((n, n), dtype=np.int64)
        n_vertices = count_runs(self.ends, sides, n_nodes, runs)
        np.fill_diagonal(runs, holes)
        return runs, int(n_vertices)


def missed(edge: Edge) -> float:
    """How much an edge is missed: its length, the more the farther it turns."""
    return edge.length * (_FLAT + abs(edge.dihedral - pi) / pi)


class Amiss(NamedTuple):
    """By how much two differ: in what is between every two faces (n, n), and in all."""

    between: IntArray
    total: int


class Compared(NamedTuple):
    """The model and a skin, and where these are near each other: an edge of that, one of its places, a run of this.

    Attributes
    ----------
    model, grid : Parted
    edges, places, runs : (k,) int64
    """

    model: Parted
    grid: Parted
    edges: IntArray
    places: IntArray
    runs: IntArray

    @classmethod
    def of(cls, model: Parted, grid: Parted, reach: float) -> Compared:
        """Near are places within `reach`."""
        away = np.linalg.norm(model.places[:, :, None] - grid.places[:, 0], axis=3)
        edges, places, pieces = np.nonzero(away < reach)
        runs, run = grid.in_runs()
        return cls(model, runs, *np.unique([edges, places, run[pieces]], axis=1))

    def differing(self, of_face: IntArray) -> Amiss:
        """By how much the counts differ, and whether an edge between two faces is astray."""
        (one, n_one), (other, n_other) = self.model.counts(of_face), self.grid.counts(of_face)
        between = np.abs(one - other)
        wanted, had = self.model.bordering(of_face), self.grid.bordering(of_face)
        is_there = np.zeros(self.model.places.shape[:2], dtype=bool)
        alike = wanted[self.edges] == had[self.runs]
        is_there[self.edges[alike], self.places[alike]] = True
        between.ravel()[distinct(wanted[(wanted >= 0) & ~is_there.all(axis=1)])] += 1
        return Amiss(between, int(between.sum()) + abs(n_one - n_other))


def let_go(  # noqa: PLR0917
    solid: Solid,
    points: FloatArray,
    quads: IntArray,
    labels: IntArray,
    size: float,
    asked: Sequence[tuple[int, int]],
    on_step: Callable[[], None] = lambda: None,
) -> IntArray:
    """For every face of the solid the least of those (n_faces,) that it is one with.

    Parameters
    ----------
    solid : Solid
    points : (n, 3) float64
    quads : (q, 4) int64
        Of the skin.
    labels : (q,) int64
        The face of each.
    size : float
        Of its cells.
    asked : sequence of (int, int)
        Faces that have to be one.
    on_step : callable
        Called now and then; may raise.

    Raises
    ------
    SurfaceMeshError
        Too many edges would have to go.
    """
    model, grid = _of_model(solid), _of_skin(points, quads, labels, len(solid.faces))
    compared = Compared.of(model, grid, _ASTRAY * size)
    prices = np.array([missed(edge) for edge in solid.edges])
    joined: list[tuple[int, int]] = []
    while (amiss := compared.differing(of_face := _as_one(len(solid.faces), [*asked, *joined]))).total:
        touched = set(np.argwhere(amiss.between).ravel().tolist())
        sides, beside = np.unique(np.sort(of_face[model.faces], axis=1), axis=0, return_inverse=True)
        price = np.bincount(beside.ravel(), weights=prices)
        best: tuple[float, tuple[int, int]] | None = None
        for i in np.argsort(price, kind="stable"):
            one, other = sides[i].tolist()
            if one == other or not touched & {one, other}:
                continue
            if best is not None and price[i] > best[0] * amiss.total:
                break  # it cannot mend more than all
            on_step()
            tried = np.where(of_face == other, one, of_face)
            mends = amiss.total - compared.differing(tried).total
            if mends > 0:
                found = float(price[i]) / mends, (one, other)
                best = found if best is None else min(best, found)
        if best is None:
            raise SurfaceMeshError("its skin has another topology than the model, whatever edges are let go")
        joined.append(best[1])
    for pair in tuple(joined):  # what came later may have done without it
        rest = [other for other in joined if other != pair]
        if not compared.differing(_as_one(len(solid.faces), [*asked, *rest])).total:
            joined = rest
    of_face = _as_one(len(solid.faces), [*asked, *joined])
    if prices[model.bordering(of_face) < 0].sum() > _MOST * prices.sum():
        raise SurfaceMeshError("its skin has the model's topology only without many of its edges")
    return of_face


def _as_one(n_faces: int, pairs: Iterable[tuple[int, int]]) -> IntArray:
    """For every face the least of those that it is one with."""
    of_face = np.arange(n_faces)
    for pair in pairs:
        low, high = sorted(of_face[list(pair)].tolist())
        of_face[of_face == high] = low
    return of_face


def _of_model(solid: Solid) -> Parted:
    return Parted(
        ends=np.array([(edge.start, edge.end) for edge in solid.edges], dtype=np.int64).reshape(-1, 2),
        faces=np.array([edge.faces for edge in solid.edges], dtype=np.int64).reshape(-1, 2),
        euler=np.array([face.euler for face in solid.faces], dtype=np.int64),
        places=np.array([edge.curve.evaluate(_ALONG) for edge in solid.edges]).reshape(-1, len(_ALONG), 3),
    )


def _of_skin(points: FloatArray, quads: IntArray, labels: IntArray, n_faces: int) -> Parted:
    segments, beside = sides_of(quads)
    faces = labels[beside]
    is_border = faces[:, 0] != faces[:, 1]
    owner = np.zeros(int(quads.max()) + 1, dtype=np.int64)
    owner[quads] = labels[:, None]
    inner = np.setdiff1d(quads, segments[is_border])
    euler = np.bincount(labels, minlength=n_faces) + np.bincount(owner[inner], minlength=n_faces)
    euler -= np.bincount(faces[~is_border, 0], minlength=n_faces)
    places = points[segments[is_border]].mean(axis=1, keepdims=True)
    ends = np.unique(segments[is_border], return_inverse=True)[1]
    return Parted(ends=ends.reshape(-1, 2).astype(np.int64), faces=faces[is_border], euler=euler, places=places)
