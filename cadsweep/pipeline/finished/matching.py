"""Which face, edge and vertex of a part answers which of another: by names, and by how they hang together.

Place in the flow: before a mesh is carried from one part to another (:mod:`.like`). Topology and names alone decide
what may correspond. Where a part is symmetric, and several ways are left, the numbers of the faces in the input decide
for the largest outline, if all of them agree, and otherwise the way in which it moves least (:mod:`.movement`); for
what hangs in its faces, such as holes, the least movement decides.

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

from ...arrays import FloatArray
from ...errors import CadError
from .graphs import Graph
from .movement import Places

FORBIDDEN = 1e9
"""Cost of a pairing that cannot be."""

RENUMBERED = 0.05
"""Cost of a hole that has another number in the input: it decides only where two holes are as near to one place, for
OpenCASCADE changes their order where one passes the height of the other."""


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
        self.across = self._across()
        self.components = list(self._components())

    def _across(self) -> list[int]:
        """The same edge on the same face as the solid on the other side has it; -1 where there is none."""
        across = [-1] * len(self.face)
        one_of = {other: own[0] for own in self.graph.shared_edges for other in own}
        beyond = {a: b for one, other in self.graph.shared_faces for a, b in ((one, other), (other, one))}
        places = [(face, one_of.get(edge, edge)) for face, edge in zip(self.face, self.edge, strict=True)]
        known = {place: dart for dart, place in enumerate(places)}
        for dart, (face, edge) in enumerate(places):
            if face in beyond:
                across[dart] = known[beyond[face], edge]
        return across

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
                for other in (self.following[dart], self.twin[dart], self.across[dart]):
                    if other >= 0 and other not in seen:
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
        self.uses = Counter(self.classes[1])
        self.first, self.second = _Darts(base), _Darts(other)
        self.places = Places(*_points(self.first, self.second), self.first.face, self.second.face)

    def best(self) -> Match:
        """The way of least cost."""
        main = max(self.first.components, key=len)
        # Whoever keeps all numbers is preferred to whoever does not, so that most ways need never be tried.
        for ways in (self.numbered(main), self.images(main, {}, set(range(len(self.second.face))))):
            found = self.cheapest(main, list(ways))
            if found is not None:
                return self.match(found)
        raise CadError(
            "the parts do not correspond: they have the same faces and edges, but these are joined in another way"
        )

    def numbered(self, main: Sequence[int]) -> Iterator[dict[int, int]]:
        """The ways to lay the largest component in which its faces keep their numbers in the input."""
        here, there = self.first.graph.face_keys, self.second.graph.face_keys
        own = here[self.first.face[self.start_of(main)]]
        within = {dart for dart, face in enumerate(self.second.face) if there[face] == own}
        return (image for image in self.images(main, {}, within) if self.keeps_numbers(image))

    def cheapest(self, main: Sequence[int], ways: list[dict[int, int]]) -> list[dict[int, int]] | None:
        """The images of all components that move least; None where no way fits the rest."""
        best: tuple[float, list[dict[int, int]] | None] = FORBIDDEN, None
        for cost, _, whole in sorted((self.places.moved(whole), number, whole) for number, whole in enumerate(ways)):
            if cost >= best[0]:
                break
            rest, images = self.with_the_rest(main, whole)
            best = min(best, (cost + rest, images), key=lambda one: one[0])
        return best[1]

    def match(self, images: list[dict[int, int]]) -> Match:
        """The partners in terms of faces, edges and vertices."""
        match = Match(faces={}, edges={}, vertices={})
        for image in images:
            for dart, partner in image.items():
                same = self.first.forward[dart] == self.second.forward[partner]
                match.faces[self.first.face[dart]] = self.second.face[partner]
                match.edges[self.first.edge[dart]] = (self.second.edge[partner], same)
                match.vertices[self.first.start(dart)] = self.second.start(partner)
        _check_shared(self.first.graph, self.second.graph, match)
        return match

    def start_of(self, component: Sequence[int]) -> int:
        """The dart of a component that has the fewest places to go to."""
        uses, classes = self.uses, self.classes[0]
        return min(component, key=lambda dart: (uses[classes[self.first.face[dart]]], dart))

    def images(self, component: Sequence[int], faces: dict[int, int], within: set[int]) -> Iterator[dict[int, int]]:
        """The ways to lay a component over some darts of the other part that agree with the faces known."""
        first, second, (classes, other_classes) = self.first, self.second, self.classes
        start = self.start_of(component)
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
            for step, step_there in (
                (first.following, second.following),
                (first.twin, second.twin),
                (first.across, second.across),
            ):
                if step[dart] < 0 or step_there[partner] < 0:
                    if step[dart] != step_there[partner]:
                        return None
                elif step[dart] not in image:
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
        places = [component for component in second.components if used.isdisjoint(component)]
        if len(places) != len(others):
            return FORBIDDEN, []
        maps = self.places.known(whole)
        kinds = [
            np.array([hash(tuple(sorted(classes[of[dart]] for dart in darts))) for darts in components])
            for components, classes, of in zip(
                (others, places), self.classes, (self.first.face, self.second.face), strict=True
            )
        ]
        distances = np.minimum(maps.distances(others, places, faces), FORBIDDEN)
        costs = np.where(kinds[0][:, None] == kinds[1], distances, FORBIDDEN)
        ways: dict[tuple[int, int], dict[int, int]] = {}
        while True:  # who goes where is settled by distance, and whether it can lie there is looked at for these alone
            rows, columns = scipy.optimize.linear_sum_assignment(costs)
            pairs = list(zip(rows.tolist(), columns.tolist(), strict=True))
            if costs[rows, columns].max(initial=0.0) >= FORBIDDEN:
                return FORBIDDEN, []
            new = [pair for pair in pairs if pair not in ways]
            for i, j in new:
                # How a hole lies on another is a question of its own shape: moved by more than its size, it would
                # else be turned round.
                image = min(self.images(others[i], faces, set(places[j])), key=maps.turned, default=None)
                if image is None:
                    costs[i, j] = FORBIDDEN
                else:
                    ways[i, j] = image
                    costs[i, j] += 0.0 if self.keeps_numbers(image) else RENUMBERED
            if not new:
                break
        images = [whole, *(ways[pair] for pair in pairs)]
        partners: dict[int, int] = {}
        for image in images:
            for dart, partner in image.items():
                if partners.setdefault(first.face[dart], second.face[partner]) != second.face[partner]:
                    return FORBIDDEN, []
        return float(costs[rows, columns].sum()), images

    def keeps_numbers(self, image: dict[int, int]) -> bool:
        """Whether all faces of an image have the numbers of their partners in the input."""
        here, there = self.first.graph.face_keys, self.second.graph.face_keys
        return all(here[self.first.face[d]] == there[self.second.face[p]] for d, p in image.items())


def _points(first: _Darts, second: _Darts) -> tuple[FloatArray, FloatArray]:
    """Start of every dart, and middle of its edge where both graphs know it: two arrays (n, 1 or 2, 3)."""
    with_middles = bool(first.graph.middles and second.graph.middles)

    def points(darts: _Darts) -> FloatArray:
        graph, numbers = darts.graph, range(len(darts.face))
        starts = np.array([graph.vertices[darts.start(dart)] for dart in numbers])
        if not with_middles:
            return starts[:, None]
        return np.stack([starts, np.array(graph.middles)[darts.edge]], axis=1)

    return points(first), points(second)


def _check_shared(base: Graph, other: Graph, match: Match) -> None:
    """Refuse parts whose solids touch in other edges or vertices."""
    edges = {edge: there for edge, (there, _) in match.edges.items()}
    for what, own, theirs, partners in (
        ("an edge", base.shared_edges, other.shared_edges, edges),
        ("a vertex", base.shared_vertices, other.shared_vertices, match.vertices),
    ):
        if {frozenset(partners[one] for one in ids) for ids in own} != {frozenset(ids) for ids in theirs}:
            raise CadError(f"the parts do not correspond: solids share {what} in one of them, and not in the other")


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
