"""From the user's words for graded edges to divisions of single edges."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np

from .. import cad
from ..arrays import FloatArray
from ..asked import SYMMETRIC, EdgeBias, edge_bias
from ..brep import Edge, Part, Solid
from ..errors import InputError, SurfaceMeshError
from ..options import SweepOptions
from ..surface import Division, fractions_from, graded_fractions, turned_round
from .subsets import subset

_T = TypeVar("_T")
_SAME = 1e-6
"""Distances that differ by less than this part of an edge's length count as the same."""


def resolve_biases(part: Part, options: SweepOptions) -> dict[int, Division]:
    """How the edges of a part divide themselves, by their keys in the whole part.

    Raises
    ------
    InputError
        Nothing has such a name, an edge is asked for in two ways, or an end of an edge is no nearer to what it is to be
        fine towards than the other.
    """
    found: dict[int, tuple[Division, EdgeBias, str]] = {}
    for word, value in (options.biases or {}).items():
        bias = edge_bias(f"the bias of '{word}'", value)
        edges = dict(everywhere(part, word, cad.select_edges, lambda solid, e: (solid.edge_keys[e], solid.edges[e])))
        near = _nearness(part, bias.towards)
        for key, division in _divisions(part, edges, bias, near):
            _, known, by = found.setdefault(key, (division, bias, word))
            if known != bias:
                raise InputError(f"{edges[key].label()}: biases of '{by}' and of '{word}' ask for different things")
    return {key: division for key, (division, _, _) in found.items()}


def names_edges(part: Part, word: Any) -> bool:
    """Whether a word names edges of any cell."""
    try:
        return any(True for _ in everywhere(part, word, cad.select_edges, lambda solid, e: (e, e)))
    except InputError:
        return False


def biases_of(solid: Solid, by_key: Mapping[int, Division]) -> dict[int, Division]:
    """The same by the ids of one solid's edges."""
    keys = solid.edge_keys.tolist()
    return {e: by_key[key] for e, key in enumerate(keys) if key in by_key}


def everywhere(
    part: Part, word: Any, select: Callable[[Part, Any], Iterable[int]], look: Callable[[Solid, int], tuple[int, _T]]
) -> Iterator[tuple[int, _T]]:
    """What `look` makes of all that a word names in any of the cells.

    Raises
    ------
    InputError
        It names nothing in any of them.
    """
    refused: InputError | None = None
    n = 0
    for cell, solid in enumerate(part.solids):
        try:
            chosen = select(subset(part, [cell]), word)
        except InputError as error:
            refused = refused or error
            continue
        n += 1
        for item in chosen:
            key, value = look(solid, item)
            yield int(key), value
    if not n and refused is not None:
        raise refused


def single_segments(counts: Collection[int]) -> list[str]:
    """A note on edges to be graded that are one segment, from their counts."""
    n = sum(count == 1 for count in counts)
    return [f"biases: {n} of {len(counts)} edges are one segment long, and so not graded"] if n else []


Nearness = Callable[[FloatArray, int], float]
"""``near(point, vertex key)``: how far a vertex is from what a bias goes towards, working units."""


def _nearness(part: Part, towards: Any) -> Nearness | None:
    """How near vertices are to a face, a vertex or a point; None where a bias has no side."""
    if towards in SYMMETRIC:
        return None
    if not isinstance(towards, str | int):
        target = (np.asarray(towards, dtype=float) - part.offset) / part.scale
        return lambda point, key: float(np.linalg.norm(point - target))
    if str(towards).startswith("vertices:"):
        chosen = everywhere(part, towards, cad.select_vertices, lambda s, v: (s.vertex_keys[v], s.vertices[v]))
        places = np.array(list(dict(chosen).values()))
        return lambda point, key: float(np.linalg.norm(places - point, axis=1).min())
    faces = dict(everywhere(part, towards, cad.select_faces, lambda s, f: (s.face_keys[f], (s, s.faces[f]))))
    on = {
        int(solid.vertex_keys[v])
        for solid, face in faces.values()
        for e in face.edges
        for v in (solid.edges[e].start, solid.edges[e].end)
    }

    def distance(point: FloatArray, key: int) -> float:
        if key in on:
            return 0.0
        return min(float(face.surface.distance(point[None])[0]) for _, face in faces.values())

    return distance


def _divisions(
    part: Part, edges: Mapping[int, Edge], bias: EdgeBias, near: Nearness | None
) -> Iterator[tuple[int, Division]]:
    """Divisions of edges by key, the pieces of one edge of the input together."""
    ends, places = {}, {}
    for solid in part.solids:
        for edge in solid.edges:
            start, end = int(solid.vertex_keys[edge.start]), int(solid.vertex_keys[edge.end])
            ends[int(solid.edge_keys[edge.id])] = (start, end)
            places[start], places[end] = solid.vertices[edge.start], solid.vertices[edge.end]
    groups: dict[str | int, list[int]] = {}
    for key, edge in edges.items():
        groups.setdefault(edge.key or key, []).append(key)
    for pieces in groups.values():
        chain = _open_chain(pieces, ends)
        # A closed edge has no ends: each piece by itself.
        for one in [[(piece, True)] for piece in pieces] if chain is None else [chain]:
            (first, ahead), (last, on) = one[0], one[-1]
            length = sum(edges[key].length for key, _ in one)
            fine = (bias.towards == "both", bias.towards == "both")
            if near is not None:
                distances = [near(places[key], key) / length for key in (ends[first][not ahead], ends[last][on])]
                fine = _nearer_end(edges[first], bias, distances)
            if len(one) == 1:
                yield first, _one_edge(part, edges[first], bias, fine)
                continue
            if bias.ratio is None:
                raise InputError(
                    f"{edges[first].label()} is one of {len(one)} pieces that an edge of the model is divided into "
                    "here: ask for a ratio instead of a first length"
                )
            run = 0.0
            for key, forward in one:
                low, high = run / length, (run + edges[key].length) / length
                yield key, partial(_portion, begin=low, end=high, forward=forward, ratio=bias.ratio, fine=fine)
                run += edges[key].length


def whole_edges(solid: Solid, edges: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Group the pieces of one edge of the input: it is the edge that the user knows."""
    groups: dict[str | int, list[int]] = {}
    for edge in edges:
        groups.setdefault(solid.edges[edge].key or edge, []).append(edge)
    return [tuple(group) for group in groups.values()]


def _open_chain(pieces: Sequence[int], ends: Mapping[int, tuple[int, int]]) -> list[tuple[int, bool]] | None:
    """Pieces that follow each other from one end to the other; None where they close, or do not meet."""
    at: dict[int, list[int]] = {}
    for key in pieces:
        for vertex in ends[key]:
            at.setdefault(vertex, []).append(key)
    outer = [vertex for vertex, own in at.items() if len(own) == 1]
    if len(outer) != 2 or any(len(own) > 2 for own in at.values()):
        return None
    vertex, left = outer[0], set(pieces)
    chain = []
    while left:
        found = [key for key in at[vertex] if key in left]
        if not found:
            return None
        forward = ends[found[0]][0] == vertex
        chain.append((found[0], forward))
        left.discard(found[0])
        vertex = ends[found[0]][forward]
    return chain


def _nearer_end(edge: Edge, bias: EdgeBias, distances: Sequence[float]) -> tuple[bool, bool]:
    """Which end of an edge is the nearer one, from the distances of both in lengths of the edge."""
    start, end = distances
    if abs(start - end) <= _SAME:
        raise InputError(
            f"{edge.label()}: both its ends are as near to {bias.towards!r}, so a bias cannot go towards it: name "
            "fewer edges, or say 'both' or 'middle'"
        )
    return (start < end, end < start)


def _one_edge(part: Part, edge: Edge, bias: EdgeBias, fine: tuple[bool, bool]) -> Division:
    if bias.ratio is not None:
        return partial(_by_ratio, ratio=bias.ratio, fine=fine)
    assert bias.first is not None
    share = bias.first / part.scale / edge.length
    return partial(_by_first, share=share, fine=fine, label=edge.label(), first=bias.first)


def _by_ratio(n: int, *, ratio: float, fine: tuple[bool, bool]) -> FloatArray:
    if fine == (False, False):
        return graded_fractions(n, start=1 / ratio, end=1 / ratio)
    return graded_fractions(n, start=ratio if fine[0] else 1.0, end=ratio if fine[1] else 1.0)


def _by_first(n: int, *, share: float, fine: tuple[bool, bool], label: str, first: float) -> FloatArray:
    try:
        fractions = fractions_from(n, share, both=fine == (True, True))
    except SurfaceMeshError as error:
        raise InputError(
            f"{label} gets {n} segments, of which the first cannot be {first:g} long ({error}): ask for another count "
            "or size there"
        ) from error
    return fractions if fine[0] else turned_round(fractions)


def _portion(n: int, *, begin: float, end: float, forward: bool, ratio: float, fine: tuple[bool, bool]) -> FloatArray:
    """Division of a piece that is a portion of a whole edge, so that segments go on across its ends."""
    whole = _by_ratio(_FINE, ratio=ratio, fine=fine)
    at = np.linspace(0.0, 1.0, _FINE + 1)
    a, b = np.interp([begin, end], whole, at)
    fractions = (np.interp(np.linspace(a, b, n + 1), at, whole) - begin) / (end - begin)
    fractions[0], fractions[-1] = 0.0, 1.0
    return fractions if forward else turned_round(fractions)


_FINE = 1000
"""Steps by which the division of a whole edge is known between its pieces."""
