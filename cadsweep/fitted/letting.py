"""Edges that a grid cannot hold, let go: the fewest whose faces have to be one for the rest to be found on its skin.

Method: the model and the labelled skin are the same kind of thing, faces that are parted by pieces of edges. Of both is
counted what must agree: the holes of every face (its Euler number), the runs of edges between every two, the places
where these end; and of every edge, whether the skin has a border of its faces about where it is. Faces are made one,
two at a time, always those whose edges are the least missed for what their going mends, until nothing differs.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from math import pi
from typing import NamedTuple

import numpy as np

from ..arrays import BoolArray, FloatArray, IntArray, distinct
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

Counts = Counter[tuple[str, int, int]]


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
        low, high = np.sort(of_face[self.faces], axis=1).T
        return np.where(low == high, -1, low * len(of_face) + high)

    def counts(self, of_face: IntArray) -> Counts:
        """What two of them must have alike, once faces with the same number in `of_face` (n_faces,) are one."""
        sides, n = of_face[self.faces], int(of_face.max()) + 1
        is_border = sides[:, 0] != sides[:, 1]
        n_nodes = int(self.ends.max(initial=-1)) + 1
        at = distinct((sides[:, :, None] * n_nodes + self.ends[:, None]).ravel())
        holes = np.bincount(of_face, weights=self.euler, minlength=n).astype(np.int64)
        holes += np.bincount(at // max(n_nodes, 1), minlength=n)
        holes -= np.bincount(sides[:, 0], minlength=n) + np.bincount(sides[is_border, 1], minlength=n)
        runs = np.empty((n, n), dtype=np.int64)
        n_vertices = count_runs(self.ends, sides, n_nodes, runs)
        found: Counts = Counter({("face", face, face): value for face, value in enumerate(holes.tolist())})
        for f, g in np.argwhere(runs).tolist():
            found["edges", f, g] = int(runs[f, g])
        found["vertices", -1, -1] = int(n_vertices)
        return found


def missed(edge: Edge) -> float:
    """How much an edge is missed: its length, the more the farther it turns."""
    return edge.length * (_FLAT + abs(edge.dihedral - pi) / pi)


class Compared(NamedTuple):
    """The model and a skin, and which pieces (n, k, s) of edges of this are near places of edges of that."""

    model: Parted
    grid: Parted
    near: BoolArray

    def differing(self, of_face: IntArray) -> Counts:
        """By how much each of the counts differs, where it does, and how many edges are astray."""
        one, other = self.model.counts(of_face), self.grid.counts(of_face)
        found = {key: abs(one[key] - other[key]) for key in one.keys() | other.keys() if one[key] != other[key]}
        wanted, had = self.model.bordering(of_face), self.grid.bordering(of_face)
        is_there = (self.near & (wanted[:, None] == had[None])[:, None]).any(axis=2).all(axis=1)
        for edge in np.flatnonzero((wanted >= 0) & ~is_there).tolist():
            found["astray", *np.sort(of_face[self.model.faces[edge]]).tolist()] = 1
        return Counter(found)


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
    away = np.linalg.norm(model.places[:, :, None] - grid.places[:, 0], axis=3)
    compared = Compared(model, grid, away < _ASTRAY * size)
    prices = np.array([missed(edge) for edge in solid.edges])
    joined: list[tuple[int, int]] = []
    while amiss := compared.differing(of_face := _as_one(len(solid.faces), [*asked, *joined])):
        touched = {face for _, *faces in amiss for face in faces}
        sides = np.sort(of_face[model.faces], axis=1)
        best: tuple[float, tuple[int, int]] | None = None
        for one, other in np.unique(sides[sides[:, 0] != sides[:, 1]], axis=0).tolist():
            if one in touched or other in touched:
                on_step()
                tried = np.where(of_face == other, one, of_face)
                mends = amiss.total() - compared.differing(tried).total()
                price = float(prices[(sides == (one, other)).all(axis=1)].sum())
                if mends > 0 and (best is None or price / mends < best[0]):
                    best = price / mends, (one, other)
        if best is None:
            raise SurfaceMeshError("its skin has another topology than the model, whatever edges are let go")
        joined.append(best[1])
    for pair in tuple(joined):  # what came later may have done without it
        rest = [other for other in joined if other != pair]
        if not compared.differing(_as_one(len(solid.faces), [*asked, *rest])):
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
