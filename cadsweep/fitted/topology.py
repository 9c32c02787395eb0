"""The model's edges and vertices on a labelled skin: borders of labels are edges, where they meet are vertices.

What differs from the model is refused: a face without quads, in pieces, or with other holes; a border between faces
that have no edge, or more or fewer of them; a path that lies too far from its curve. Nothing is bent to fit; a
:class:`MisfitError` knows the edges without which it might be found.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from ..arrays import FloatArray, IntArray
from ..brep import Edge, Face, Solid
from ..errors import SurfaceMeshError
from ..harmonic import sides_of

_ASTRAY = 2.0
"""Cells that a node of a path may be off its curve, before it is moved there."""


class MisfitError(SurfaceMeshError):
    """The skin has not the topology of the solid.

    Attributes
    ----------
    edges : tuple of int
        Of the solid, those that it has not, where counts alone would not tell.
    """

    def __init__(self, what: object, *, edges: Sequence[int] = ()) -> None:
        super().__init__(what)
        self.edges = tuple(edges)


def match_topology(  # noqa: PLR0912
    solid: Solid, points: FloatArray, quads: IntArray, labels: IntArray, size: float
) -> dict[int, IntArray]:
    """Nodes of every edge of the solid, by its id, from its start to its end.

    Raises
    ------
    MisfitError
        The skin has not the topology of the solid; names what is wrong first.
    """
    segments, pairs = sides_of(quads)
    _check_faces(solid, quads, labels)
    sides = np.sort(labels[pairs], axis=1)
    is_border = sides[:, 0] != sides[:, 1]
    segments, sides = segments[is_border], sides[is_border]
    met: dict[int, set[int]] = {}
    for label, nodes in zip(labels.tolist(), quads.tolist(), strict=True):
        for node in nodes:
            met.setdefault(node, set()).add(label)
    degree = np.bincount(segments.ravel(), minlength=len(points))
    ends = {int(node) for node in np.flatnonzero(degree) if len(met[int(node)]) > 2 or degree[node] != 2}
    by_pair: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for (a, b), (f, g) in zip(segments.tolist(), sides.tolist(), strict=True):
        by_pair.setdefault((f, g), []).append((a, b))
    wanted: dict[tuple[int, int], list[int]] = {}
    for edge in solid.edges:
        wanted.setdefault(_sides(edge), []).append(edge.id)
    for f, g in by_pair:
        if (f, g) not in wanted:
            where = points[by_pair[f, g][0][0]]
            raise MisfitError(
                f"{solid.faces[f].label()} and {solid.faces[g].label()} meet on the grid and not in the model, near "
                f"{solid.units.place(where)}"
            )
    chains: dict[int, IntArray] = {}
    nodes_of: dict[int, int] = {}
    for pair, edges in wanted.items():
        runs = list(_runs(solid, edges))
        paths = list(_paths(by_pair.get(pair, []), ends))
        if len(runs) != len(paths):
            label = solid.edges[edges[0]].label()
            raise MisfitError(
                f"{label}: {len(paths)} paths on the grid for {len(runs)} between its faces", edges=edges[:1]
            )
        for run, path in _matched(solid, runs, paths, points):
            for edge_id, nodes in divided(solid, run, path, points):
                chains[edge_id] = nodes
    for edge in solid.edges:
        nodes = chains[edge.id]
        away = edge.curve.distance(points[nodes])
        if away.max() > _ASTRAY * size:
            raise MisfitError(
                f"{edge.label()}: its path on the grid is {away.max() / size:.1f} cells away from it", edges=[edge.id]
            )
        for vertex, node in ((edge.start, int(nodes[0])), (edge.end, int(nodes[-1]))):
            if nodes_of.setdefault(vertex, node) != node:
                raise MisfitError(
                    f"the edges at {solid.units.place(solid.vertices[vertex])} do not meet on the grid", edges=[edge.id]
                )
    if len(set(nodes_of.values())) != len(nodes_of) or len(ends - set(nodes_of.values())):
        raise MisfitError("the grid has other vertices than the model: it is too coarse")
    return chains


def divide_ring(solid: Solid, edges: Sequence[int], path: list[int], points: FloatArray) -> dict[int, IntArray]:
    """Nodes of edges that go round once, from those of the whole ring, of which the first is also the last."""
    (run,) = _runs(solid, list(edges))
    return dict(divided(solid, run, path, points))


def _check_faces(solid: Solid, quads: IntArray, labels: IntArray) -> None:
    """Every face has quads, with as many holes as it has itself (its Euler number)."""
    for face in solid.faces:
        own = quads[labels == face.id]
        if not len(own):
            raise MisfitError(f"{face.label()} has no quad: it is smaller than a cell of the grid")
        sides = np.sort(np.stack([own, np.roll(own, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
        euler = len(np.unique(own)) - len(np.unique(sides, axis=0)) + len(own)
        if euler != closed_euler(solid, face):
            raise MisfitError(f"{face.label()} has other holes on the grid than in the model")


def closed_euler(solid: Solid, face: Face) -> int:
    """Euler number of a face with its border."""
    ends = {v for e in face.edges for v in (solid.edges[e].start, solid.edges[e].end)}
    return len(ends) - len(set(face.edges)) + face.euler


def _sides(edge: Edge) -> tuple[int, int]:
    """The faces beside an edge, ascending."""
    low, high = sorted(edge.faces)
    return low, high


def _runs(solid: Solid, edges: list[int]) -> Iterator[list[tuple[int, bool]]]:
    """Edges between one pair of faces joined where nothing else ends: directed, head to tail; rings begin anywhere."""
    n_at: dict[int, int] = {}
    for edge in solid.edges:
        for vertex in (edge.start, edge.end):
            n_at[vertex] = n_at.get(vertex, 0) + 1
    left = dict.fromkeys(edges)

    def grow(run: list[tuple[int, bool]]) -> None:
        while True:
            last, forward = run[-1]
            vertex = solid.edges[last].end if forward else solid.edges[last].start
            following = (
                [e for e in left if vertex in (solid.edges[e].start, solid.edges[e].end)] if n_at[vertex] == 2 else []
            )
            if not following:
                return
            del left[following[0]]
            run.append((following[0], solid.edges[following[0]].start == vertex))

    while left:
        first = next(iter(left))
        del left[first]
        run = [(first, False)]
        grow(run)
        run = [(e, not forward) for e, forward in reversed(run)]
        grow(run)
        yield run


def _paths(segments: list[tuple[int, int]], ends: set[int]) -> Iterator[list[int]]:
    """Nodes of segments joined head to tail where no path ends; of a ring the first node is also the last."""
    beside: dict[int, list[int]] = {}
    for a, b in segments:
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    used: set[tuple[int, int]] = set()
    starts = [node for node in beside if node in ends] + [node for node in beside if node not in ends]
    for start in starts:
        for following in beside[start]:
            if (start, following) in used:
                continue
            path = [start, following]
            used |= {(start, following), (following, start)}
            while path[-1] not in ends and path[-1] != start:
                ahead = [node for node in beside[path[-1]] if node != path[-2]]
                path.append(ahead[0])
                used |= {(path[-2], path[-1]), (path[-1], path[-2])}
            yield path


def _matched(
    solid: Solid, runs: list[list[tuple[int, bool]]], paths: list[list[int]], points: FloatArray
) -> Iterator[tuple[list[tuple[int, bool]], list[int]]]:
    """Which path is which run's, in the sum nearest."""
    trees = [cKDTree(np.concatenate([_along(solid, e, True) for e, _ in run])) for run in runs]
    paths_at = [cKDTree(points[path]) for path in paths]
    cost = np.array(
        [[tree.query(at.data)[0].mean() + at.query(tree.data)[0].mean() for at in paths_at] for tree in trees]
    )
    for row, column in zip(*linear_sum_assignment(cost), strict=True):
        yield runs[row], paths[column]


def _along(solid: Solid, edge: int, forward: bool) -> FloatArray:
    points = solid.edges[edge].curve.evaluate(np.linspace(0.0, 1.0, 17))
    return points if forward else points[::-1]


def divided(
    solid: Solid, run: list[tuple[int, bool]], path: list[int], points: FloatArray
) -> Iterator[tuple[int, IntArray]]:
    """The nodes of every edge of a run, from its start to its end."""
    if len(path) - 1 < len(run):
        shortest = min((edge for edge, _ in run), key=lambda edge: solid.edges[edge].length)
        raise MisfitError(f"{solid.edges[run[0][0]].label()}: fewer segments on the grid than edges", edges=[shortest])
    corners = np.array([_along(solid, e, forward)[0] for e, forward in run] + [_along(solid, *run[-1])[-1]])
    middle = np.array([_along(solid, e, forward)[8] for e, forward in run])
    marks = np.empty((2 * len(run) + 1, 3))
    marks[::2], marks[1::2] = corners, middle
    ways = []
    if path[0] == path[-1]:
        ring = path[:-1]
        first = int(np.argmin(np.linalg.norm(points[ring] - corners[0], axis=1)))
        turned = [*ring[first:], *ring[:first], ring[first]]
        ways = [turned, turned[::-1]]
    else:
        ways = [path, path[::-1]]
    best = min((_cut(way, marks, points, len(run)) for way in ways), key=lambda found: found[0])
    for (edge, forward), nodes in zip(run, best[1], strict=True):
        yield edge, np.array(nodes if forward else nodes[::-1], dtype=np.int64)


def _cut(path: list[int], marks: FloatArray, points: FloatArray, n: int) -> tuple[float, list[list[int]]]:
    """A path cut at the nodes nearest to the vertices of its run, in turn, and how far it is off them and middles."""
    away = np.linalg.norm(points[path][:, None] - marks[None], axis=2)
    at = [0]
    for j in range(1, n):
        low, high = at[-1] + 1, len(path) - (n - j)
        at.append(low + int(np.argmin(away[low:high, 2 * j])))
    at.append(len(path) - 1)
    off = sum(away[i, 2 * j] for j, i in enumerate(at))
    off += sum(away[a : b + 1, 2 * j + 1].min() for j, (a, b) in enumerate(itertools.pairwise(at)))
    # Of a ring of two like halves both ways are as near: the order of what is passed tells them apart.
    halves = [away[(a + b) // 2, 2 * j + 1] for j, (a, b) in enumerate(itertools.pairwise(at))]
    return float(off + sum(halves)), [path[a : b + 1] for a, b in itertools.pairwise(at)]
