"""Which face, edge and vertex of a part answers which of another: by names, and by how they hang together.

Place in the flow: before a mesh is carried from one part to another (:mod:`.like`). Topology and names alone decide
what may correspond; where a part is symmetric, and several ways are left, the numbers of the faces in the input decide,
if all of them agree (the same script makes its faces in the same order), and otherwise the way in which the vertices,
seen in the parts' bounding boxes, move least.

Method: a *dart* is an edge as one of its two faces runs through it. The dart after it in the loop, and the twin on the
other face, are what an isomorphism keeps; so the image of one dart settles all that can be reached from it. Loops that
no edges join to the rest (holes) are settled one by one, and shared out by least cost.

Not handled: mirror images; a face that a variant divides in two.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from ..arrays import FloatArray
from ..brep import Solid
from ..errors import CadError

FORBIDDEN = 1e9
"""Cost of a pairing that cannot be."""


@dataclass(frozen=True, kw_only=True)
class Graph:
    """Faces, edges and vertices of a solid as plain data.

    Attributes
    ----------
    loops : tuple of tuple of tuple of (int, bool)
        Loops of every face, as directed edges.
    face_names, edge_names : tuple of tuple of str
        The user's names of every face and edge, sorted.
    face_keys : tuple of str
        What the faces are called in the input.
    face_labels : tuple of str
        What messages call them.
    ends : tuple of (int, int)
        Start and end vertex of every edge.
    vertices : tuple of (float, float, float)
        In the bounding box of all of them: 0 to 1.
    """

    loops: tuple[tuple[tuple[tuple[int, bool], ...], ...], ...]
    face_names: tuple[tuple[str, ...], ...]
    edge_names: tuple[tuple[str, ...], ...]
    face_keys: tuple[str, ...]
    face_labels: tuple[str, ...]
    ends: tuple[tuple[int, int], ...]
    vertices: tuple[tuple[float, ...], ...]


def graph_of(solid: Solid) -> Graph:
    """The graph of a solid."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    size = np.where(high > low, high - low, 1.0)
    return Graph(
        loops=tuple(tuple(tuple(loop.directed) for loop in face.loops) for face in solid.faces),
        face_names=tuple(tuple(sorted(face.names)) for face in solid.faces),
        edge_names=tuple(tuple(sorted(edge.names)) for edge in solid.edges),
        face_keys=tuple(face.key for face in solid.faces),
        face_labels=tuple(face.label() for face in solid.faces),
        ends=tuple((edge.start, edge.end) for edge in solid.edges),
        vertices=tuple(tuple(row) for row in ((solid.vertices - low) / size).tolist()),
    )


@dataclass(frozen=True, kw_only=True)
class Match:
    """Partners of the first part's entities in the second.

    Attributes
    ----------
    faces : dict of int to int
    edges : dict of int to (int, bool)
        The edge, and whether start answers to start.
    vertices : dict of int to int
    """

    faces: dict[int, int]
    edges: dict[int, tuple[int, bool]]
    vertices: dict[int, int]


class _Darts:
    """Darts of a graph by number, and what is next to each."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.face: list[int] = []
        self.edge: list[int] = []
        self.forward: list[bool] = []
        self.following: list[int] = []
        self.twin: list[int] = []
        by_edge: dict[int, list[int]] = {}
        for face, loops in enumerate(graph.loops):
            for loop in loops:
                first = len(self.face)
                for position, (edge, forward) in enumerate(loop):
                    by_edge.setdefault(edge, []).append(first + position)
                    self.face.append(face)
                    self.edge.append(edge)
                    self.forward.append(forward)
                    self.following.append(first + (position + 1) % len(loop))
        self.twin = [-1] * len(self.face)
        for first, second in by_edge.values():
            self.twin[first], self.twin[second] = second, first
        self.components = list(self._components())

    def _components(self) -> Iterator[list[int]]:
        seen: set[int] = set()
        for start in range(len(self.face)):
            if start in seen:
                continue
            seen.add(start)
            found, waiting = [], [start]
            while waiting:
                dart = waiting.pop()
                found.append(dart)
                for other in (self.following[dart], self.twin[dart]):
                    if other not in seen:
                        seen.add(other)
                        waiting.append(other)
            yield found

    def start(self, dart: int) -> int:
        """Vertex where a dart begins."""
        return self.graph.ends[self.edge[dart]][0 if self.forward[dart] else 1]


def match_graphs(base: Graph, other: Graph) -> Match:
    """Find the partners of all faces, edges and vertices.

    Raises
    ------
    CadError
        The parts do not correspond; names the first face or edge without a partner.
    """
    return _Matcher(base, other).best()


class _Matcher:
    """Ways to lay one graph over another."""

    def __init__(self, base: Graph, other: Graph) -> None:
        self.classes = _classes(base, other)
        self.first, self.second = _Darts(base), _Darts(other)

    def best(self) -> Match:
        """The way of least cost."""
        main = max(self.first.components, key=len)
        best: tuple[float, list[dict[int, int]]] | None = None
        for whole in self.images(main, {}, set(range(len(self.second.face)))):
            cost, images = self.with_the_rest(main, whole)
            if cost < FORBIDDEN and (best is None or cost < best[0]):
                best = cost, images
        if best is None:
            raise CadError(
                "the parts do not correspond: they have the same faces and edges, but these are joined in another way"
            )
        match = Match(faces={}, edges={}, vertices={})
        for image in best[1]:
            for dart, partner in image.items():
                same = self.first.forward[dart] == self.second.forward[partner]
                match.faces[self.first.face[dart]] = self.second.face[partner]
                match.edges[self.first.edge[dart]] = (self.second.edge[partner], same)
                match.vertices[self.first.start(dart)] = self.second.start(partner)
        return match

    def images(self, component: Sequence[int], faces: dict[int, int], within: set[int]) -> Iterator[dict[int, int]]:
        """The ways to lay a component over some darts of the other part that agree with the faces known."""
        first, second, (classes, other_classes) = self.first, self.second, self.classes
        uses = Counter(other_classes)  # the start has the fewest places to go to
        start = min(component, key=lambda dart: (uses[classes[first.face[dart]]], dart))
        for candidate in sorted(within):
            if other_classes[second.face[candidate]] == classes[first.face[start]]:
                image = self.spread(start, candidate, faces)
                if image is not None:
                    yield image

    def spread(self, start: int, candidate: int, faces: dict[int, int]) -> dict[int, int] | None:
        """All darts that are reached from one, and their partners; None where these are joined in another way."""
        first, second, (classes, other_classes) = self.first, self.second, self.classes
        image, waiting = {start: candidate}, [start]
        of_face = dict(faces)
        taken = {there: here for here, there in of_face.items()}
        while waiting:
            dart = waiting.pop()
            partner = image[dart]
            here, there = first.face[dart], second.face[partner]
            if of_face.setdefault(here, there) != there or taken.setdefault(there, here) != here:
                return None
            if classes[here] != other_classes[there]:
                return None
            if first.graph.edge_names[first.edge[dart]] != second.graph.edge_names[second.edge[partner]]:
                return None
            for step, step_there in ((first.following, second.following), (first.twin, second.twin)):
                if step[dart] not in image:
                    image[step[dart]] = step_there[partner]
                    waiting.append(step[dart])
                elif image[step[dart]] != step_there[partner]:
                    return None
        return image if len(set(image.values())) == len(image) else None

    def with_the_rest(self, main: Sequence[int], whole: dict[int, int]) -> tuple[float, list[dict[int, int]]]:
        """The cost of a way to lay the largest component, with the best ways for all others that go with it."""
        first, second = self.first, self.second
        faces = {first.face[dart]: second.face[partner] for dart, partner in whole.items()}
        used = set(whole.values())
        others = [component for component in first.components if component is not main]
        places = [set(component) for component in second.components if used.isdisjoint(component)]
        if len(places) != len(others):
            return FORBIDDEN, []
        costs = np.full((len(others), len(places)), FORBIDDEN)
        ways: dict[tuple[int, int], dict[int, int]] = {}
        for i, component in enumerate(others):
            for j, place in enumerate(places):
                for image in self.images(component, faces, place) if len(place) == len(component) else ():
                    cost = self.cost(image)
                    if cost < costs[i, j]:
                        costs[i, j], ways[i, j] = cost, image
        rows, columns = scipy.optimize.linear_sum_assignment(costs)
        pairs = list(zip(rows.tolist(), columns.tolist(), strict=True))
        if any(pair not in ways for pair in pairs):
            return FORBIDDEN, []
        images = [whole, *(ways[pair] for pair in pairs)]
        partners: dict[int, int] = {}
        for image in images:
            for dart, partner in image.items():
                if partners.setdefault(first.face[dart], second.face[partner]) != second.face[partner]:
                    return FORBIDDEN, []
        return self.cost(whole) + float(costs[rows, columns].sum()), images

    def cost(self, image: dict[int, int]) -> float:
        """Small where all faces keep their numbers; else above 1, and more the further vertices move."""
        here, there = self.first.graph, self.second.graph
        starts: FloatArray = np.array([here.vertices[self.first.start(dart)] for dart in image])
        partners: FloatArray = np.array([there.vertices[self.second.start(partner)] for partner in image.values()])
        away = float(np.linalg.norm(starts - partners, axis=1).mean())
        same = all(here.face_keys[self.first.face[d]] == there.face_keys[self.second.face[p]] for d, p in image.items())
        return 1e-3 * away if same else 1.0 + away


def _classes(base: Graph, other: Graph) -> tuple[list[int], list[int]]:
    """Classes of faces that may answer each other: equal names, outlines, and neighbours, and theirs, and so on."""
    marks: list[list[Any]] = [
        [(names, len(loops)) for names, loops in zip(graph.face_names, graph.loops, strict=True)]
        for graph in (base, other)
    ]
    _compare(base, other, marks, "name, or number of outlines")
    marks = [
        [
            (mark, tuple(sorted(tuple(sorted(graph.edge_names[e] for e, _ in loop)) for loop in loops)))
            for mark, loops in zip(of, graph.loops, strict=True)
        ]
        for graph, of in zip((base, other), marks, strict=True)
    ]
    _compare(base, other, marks, "edges")
    n_classes = 0
    while True:
        numbers = {mark: i for i, mark in enumerate(dict.fromkeys([*marks[0], *marks[1]]))}
        ids = [[numbers[mark] for mark in of] for of in marks]
        if len(numbers) == n_classes:
            return ids[0], ids[1]
        n_classes = len(numbers)
        marks = [
            [
                (own, tuple(sorted(tuple(sorted(of[n] for n in loop)) for loop in loops)))
                for own, loops in zip(of, around, strict=True)
            ]
            for of, around in zip(ids, (_neighbours(base), _neighbours(other)), strict=True)
        ]
        _compare(base, other, marks, "neighbours")


def _neighbours(graph: Graph) -> list[list[list[int]]]:
    """Faces beyond the edges of every loop of every face."""
    beside: dict[int, list[int]] = {}
    for face, loops in enumerate(graph.loops):
        for loop in loops:
            for edge, _ in loop:
                beside.setdefault(edge, []).append(face)
    return [
        [[sum(beside[edge]) - face for edge, _ in loop] for loop in loops] for face, loops in enumerate(graph.loops)
    ]


def _compare(base: Graph, other: Graph, marks: Sequence[Sequence[object]], what: str) -> None:
    """Refuse parts of which a mark is more often on one than on the other; names such a face, a named one if any."""
    counts = [Counter(of) for of in marks]
    alone = [
        (own, face)
        for own in (0, 1)
        for face, mark in enumerate(marks[own])
        if counts[own][mark] > counts[1 - own][mark]
    ]
    if not alone:
        return
    graphs, parts = (base, other), ("the mesh's part", "this part")
    own, face = min(alone, key=lambda one: not graphs[one[0]].face_names[one[1]])
    n_edges = sum(len(loop) for loop in graphs[own].loops[face])
    raise CadError(
        f"the parts do not correspond: {graphs[own].face_labels[face]} of {parts[own]}, with {n_edges} edges, has no "
        f"partner in {parts[1 - own]} that is like it by {what} ({len(base.loops)} faces and {len(base.ends)} edges "
        f"there, {len(other.loops)} and {len(other.ends)} here); mesh this part by itself"
    )
