"""Faces and strips of faces narrower than a cell, that a grid has no quads for, laid in as rows of quads.

Where a loop of a face is close to another, a grid has the faces beyond the two meet, and the faces between have lost
their quads there. A sheet around one of them leaves a rim of quads along the loop: they are what is missing, however
narrow, each of the face that lies beyond its part of the loop in the model.

What it does not handle: faces whose loops touch, or are too close for the grid to have one ring of sides for each.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..arrays import FloatArray, IntArray
from ..brep import Face, Solid
from ..harmonic import sides_of
from .sheets import Fitted, with_rim, with_skin
from .topology import divided

_ASTRAY = 2.0
"""Cells that a ring of sides and its loop may be off each other."""
_PLACES = 33
"""Places of an edge from which the distance of a loop is measured."""


def lay_strips(solid: Solid, mesh: Fitted, size: float, on_step: Callable[[], None] = lambda: None) -> Fitted:
    """The mesh with a row of quads around every loop that has other faces beyond it on the grid than in the model.

    `on_step` is called now and then, and may raise.
    """
    laid: set[tuple[int, int]] = set()
    loops = [_Loops.of(solid, face) for face in solid.faces]
    known: dict[int, tuple[bytes, list[_Strip]]] = {}
    while True:
        segments, pairs = sides_of(mesh.quads)
        beside = mesh.labels[pairs]
        is_border = beside[:, 0] != beside[:, 1]
        segments, beside = segments[is_border], beside[is_border]
        for face in solid.faces:  # but few have changed since the last strip
            own = (beside == face.id).any(axis=1)
            sides, others = segments[own], beside[own].sum(axis=1) - face.id
            key = sides.tobytes() + others.tobytes()  # nodes stay where they are
            if face.id not in known or known[face.id][0] != key:
                known[face.id] = key, list(_amiss(solid, face, loops[face.id], sides, others, mesh.points[sides], size))
        left = [strip for _, found in known.values() for strip in found if (strip.face, strip.loop) not in laid]
        if not left:
            return mesh
        on_step()
        worst = max(left, key=lambda strip: strip.order)
        laid.add((worst.face, worst.loop))
        skin = mesh if mesh.has_skin else with_skin(solid, mesh, size)
        mesh = with_rim(skin, worst.face, worst.beyond(solid, skin.points)).mesh


class _Loops(NamedTuple):
    """The loops of a face: places of each, and the faces beyond it."""

    places: list[cKDTree]
    beyond: list[list[int]]

    @classmethod
    def of(cls, solid: Solid, face: Face) -> _Loops:
        along = np.linspace(0.0, 1.0, _PLACES)
        return cls(
            [
                cKDTree(np.concatenate([solid.edges[e].curve.evaluate(along) for e in loop.edges]))
                for loop in face.loops
            ],
            [[sum(solid.edges[e].faces) - face.id for e in loop.edges] for loop in face.loops],
        )


class _Strip(NamedTuple):
    """A loop of a face with other faces beyond it than in the model.

    Attributes
    ----------
    order : (bool, int)
        Which comes first, the highest.
    face, loop : int
    run : list of (int, bool)
        The edges of the loop, directed, head to tail.
    path : list of int
        Nodes around it, the first again at the end.
    """

    order: tuple[bool, int]
    face: int
    loop: int
    run: list[tuple[int, bool]]
    path: list[int]

    def beyond(self, solid: Solid, points: FloatArray) -> dict[tuple[int, int], int]:
        """The face that belongs beyond each side of the path, both ways."""
        wanted = {}
        for edge, nodes in divided(solid, self.run, self.path, points):
            for a, b in itertools.pairwise(nodes.tolist()):
                wanted[a, b] = wanted[b, a] = sum(solid.edges[edge].faces) - self.face
        return wanted


def _amiss(  # noqa: PLR0917
    solid: Solid, face: Face, loops: _Loops, sides: IntArray, others: IntArray, places: FloatArray, size: float
) -> Iterator[_Strip]:
    """The loops of a face that are amiss, from its sides (s, 2) on a skin, the faces (s,) beyond, and their places."""
    if not len(sides) or np.bincount(sides.ravel()).max() > 2:  # a sheet around it would touch itself
        return
    rings = _rings(sides)
    if len(rings) != len(face.loops):
        return
    for j, loop in _near(loops, [(places[r], others[r]) for r in rings], size):
        ring = rings[j]
        run, path = _in_turn(solid, face.loops[loop].edges), _path(sides[ring])
        if run is None or path is None or len(ring) < len(run):
            continue
        beyond = {sum(solid.edges[e].faces) - face.id for e, _ in run}
        between = dict(zip(map(frozenset, sides[ring].tolist()), others[ring].tolist(), strict=True))
        n = sum(between[frozenset(side)] not in beyond for side in itertools.pairwise(path))
        if n:  # where one face is beyond, it cannot be divided wrongly
            yield _Strip((len(beyond) == 1, n), face.id, loop, run, path)


def _in_turn(solid: Solid, edges: tuple[int, ...]) -> list[tuple[int, bool]] | None:
    """The edges of a loop, directed, head to tail; None of one that touches itself."""
    left = list(dict.fromkeys(edges))
    run = [(left.pop(0), True)]
    while left:
        last = solid.last_vertex(run[-1])
        following = [e for e in left if last in (solid.edges[e].start, solid.edges[e].end)]
        if not following or (len(following) > 1 and len(run) > 1):
            return None
        left.remove(following[0])
        run.append((following[0], solid.edges[following[0]].start == last))
    return run if solid.last_vertex(run[-1]) == solid.first_vertex(run[0]) else None


def _path(sides: IntArray) -> list[int] | None:
    """Nodes of sides that go round once, the first again at the end; None where they touch."""
    beside: dict[int, list[int]] = {}
    for a, b in sides.tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    if any(len(found) != 2 for found in beside.values()):
        return None
    path = sides[0].tolist()
    while path[-1] != path[0]:
        one, other = beside[path[-1]]
        path.append(other if one == path[-2] else one)
    return path


def _rings(sides: IntArray) -> list[IntArray]:
    """Which of the sides (s, 2) hang together."""
    nodes, ends = np.unique(sides, return_inverse=True)
    one, other = ends.reshape(-1, 2).T
    graph = coo_array((np.ones(len(sides)), (one, other)), shape=(len(nodes), len(nodes)))
    n_rings, of_node = connected_components(graph, directed=False)
    return [np.flatnonzero(of_node[one] == ring) for ring in range(n_rings)]


def _near(loops: _Loops, rings: list[tuple[FloatArray, IntArray]], size: float) -> Iterator[tuple[int, int]]:
    """Rings that are about where a loop of a face is, and the loop: nearest in the sum, and with the faces beyond it.

    Of each ring come its sides (s, 2, 3), and the face (s,) beyond each.
    """
    middles = [sides.mean(axis=1) for sides, _ in rings]
    foreign = np.array([[1.0 - np.isin(met, faces).mean() for faces in loops.beyond] for _, met in rings])
    away = np.array([[max(_off(one, at), _off(at.data, cKDTree(one))) for at in loops.places] for one in middles])
    for ring, loop in zip(*linear_sum_assignment(away + size * foreign), strict=True):
        if away[ring, loop] < _ASTRAY * size:
            yield int(ring), int(loop)


def _off(places: FloatArray, tree: cKDTree) -> float:
    return float(tree.query(places)[0].max())
