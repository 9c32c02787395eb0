"""From the user's words for graded edges to divisions of single edges."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from ... import cad
from ...asked import SYMMETRIC, EdgeBias, edge_bias
from ...brep import Edge, Part, Solid
from ...errors import InputError
from ...intervals import Split
from ...options import SweepOptions
from ...surface import Chain, ChainPiece, Division, chains_of, say_chains
from ..complexes.subsets import subset
from .edge_pieces import pieces_along

_T = TypeVar("_T")
_SAME = 1e-6
"""Distances that differ by less than this part of an edge's length count as the same."""


def resolve_biases(part: Part, options: SweepOptions, model: Part | None = None) -> list[Chain]:
    """How edges are graded, as chains of pieces by their keys in the whole part; `model` is the part before it was cut.

    Raises
    ------
    InputError
        Nothing has such a name, an edge is asked for in two ways, or an end of an edge is no nearer to what it is to be
        fine towards than the other.
    """
    model = part if model is None else model
    found: list[Chain] = []
    known: dict[tuple[int, int], tuple[EdgeBias, str]] = {}
    for word, value in (options.biases or {}).items():
        bias = edge_bias(f"the bias of '{word}'", value)
        places = named(model, word, cad.select_edges)
        near = _nearness(model, bias.towards)
        for cell, edge in places:
            asked, by = known.setdefault((cell, edge), (bias, word))
            if asked != bias:
                label = model.solids[cell].edges[edge].label()
                raise InputError(f"{label}: biases of '{by}' and of '{word}' ask for different things")
        for whole in _whole_chains(model, places):
            chain = _chain(part, model, bias, near, whole)
            if chain is not None:
                found.append(chain)
    return found


def divisions_of(chains: Sequence[Chain]) -> dict[int, Division]:
    """How the edges of chains divide themselves; one that is in two, as where solids touch, goes with the longer."""
    found: dict[int, Division] = {}
    for chain in sorted(chains, key=lambda own: -sum(own.lengths)):
        for place, (edge, _) in enumerate(chain.edges):
            found.setdefault(edge, ChainPiece(chain=chain, place=place))
    return found


def splits_of(divisions: Mapping[int, Division]) -> list[Split]:
    """How the pieces of the chains among divisions share their segments, for the counts."""
    return [(tuple(e for e, _ in own.edges), own.shares) for own in chains_of(divisions) if len(own.edges) > 1]


def say_graded(divisions: Mapping[int, Division], edges: Iterable[int], counts: Mapping[int, int]) -> list[str]:
    """Notes on edges to be graded that are one segment, and on chains whose counts do not allow what is asked."""
    own = [edge for edge in edges if edge in divisions]
    n = sum(counts[edge] == 1 and not _is_piece(divisions[edge]) for edge in own)
    notes = [f"biases: {n} of {len(own)} edges are one segment long, and so not graded"] if n else []
    return notes + say_chains(chains_of({edge: divisions[edge] for edge in own}), counts)


def _is_piece(division: Division) -> bool:
    return isinstance(division, ChainPiece) and len(division.chain.edges) > 1


def biases_of(solid: Solid, chains: Sequence[Chain]) -> list[Chain]:
    """Those of the chains that are on one solid, by the ids of its edges."""
    ids = {key: e for e, key in enumerate(solid.edge_keys.tolist())}
    return [
        replace(own, edges=tuple((ids[key], forward) for key, forward in own.edges))
        for own in chains
        if all(key in ids for key, _ in own.edges)
    ]


def named(part: Part, word: Any, select: Callable[[Part, Any], Iterable[int]]) -> list[tuple[int, int]]:
    """Solid and id of all that a word names in any of them.

    Raises
    ------
    InputError
        It names nothing in any of them.
    """
    cells = {id(solid): cell for cell, solid in enumerate(part.solids)}
    return [place for _, place in everywhere(part, word, select, lambda solid, j: (0, (cells[id(solid)], j)))]


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


Nearness = Callable[[int, int], float]
"""``near(solid, vertex)``: how far a vertex is from what a bias goes towards, working units."""


def _nearness(model: Part, towards: Any) -> Nearness | None:
    """How near vertices are to a face, a vertex or a point; None where a bias has no side.

    What a word names on the edge's own solid goes before what it names on others.
    """
    if towards in SYMMETRIC:
        return None
    solids = model.solids
    if not isinstance(towards, str | int):
        target = (np.asarray(towards, dtype=float) - model.offset) / model.scale
        return lambda cell, v: float(np.linalg.norm(solids[cell].vertices[v] - target))
    if str(towards).startswith("vertices:"):
        corners = named(model, towards, cad.select_vertices)

        def to_vertices(cell: int, v: int) -> float:
            own = [j for j in corners if j[0] == cell] or corners
            places = np.array([solids[c].vertices[j] for c, j in own])
            return float(np.linalg.norm(places - solids[cell].vertices[v], axis=1).min())

        return to_vertices
    faces = named(model, towards, cad.select_faces)

    def to_faces(cell: int, v: int) -> float:
        own = [solids[c].faces[f] for c, f in ([j for j in faces if j[0] == cell] or faces)]
        if any(c == cell for c, _ in faces) and any(v in _ends(solids[cell], e) for face in own for e in face.edges):
            return 0.0
        return min(float(face.surface.distance(solids[cell].vertices[v][None])[0]) for face in own)

    return to_faces


def _ends(solid: Solid, edge: int) -> tuple[int, int]:
    return solid.edges[edge].start, solid.edges[edge].end


Whole = tuple[int, list[tuple[int, bool]]]
"""A solid, and edges of it one after another, with whether they run along."""


def _whole_chains(model: Part, places: Sequence[tuple[int, int]]) -> Iterator[Whole]:
    """Edges as the user knows them: the pieces of one edge of the input that are named, from end to end."""
    for cell in dict.fromkeys(cell for cell, _ in places):
        solid = model.solids[cell]
        for pieces in whole_edges(solid, tuple(e for c, e in places if c == cell)):
            chain = _open_chain(pieces, {e: _ends(solid, e) for e in pieces})
            # A closed edge has no ends: each piece by itself.
            yield from [(cell, [(e, True)]) for e in pieces] if chain is None else [(cell, chain)]


def _chain(part: Part, model: Part, bias: EdgeBias, near: Nearness | None, whole: Whole) -> Chain | None:
    """The pieces that an edge became in the part; None where it is there no more (merged, say)."""
    cell, edges = whole
    solid = model.solids[cell]
    (first, ahead), (last, on) = edges[0], edges[-1]
    length = sum(solid.edges[e].length for e, _ in edges)
    fine = (bias.towards == "both", bias.towards == "both")
    if near is not None:
        ends = _ends(solid, first)[not ahead], _ends(solid, last)[on]
        fine = _nearer_end(solid.edges[first], bias, [near(cell, v) / length for v in ends])
    pieces = [piece for e, forward in edges for piece in pieces_along(part, model, cell, e, forward=forward)]
    if not pieces:
        return None
    return Chain(
        edges=tuple((key, forward) for key, forward, _ in pieces),
        lengths=tuple(own for _, _, own in pieces),
        fine=fine,
        ratio=bias.ratio,
        share=None if bias.first is None else bias.first / part.scale / length,
        first=bias.first,
        label=solid.edges[first].label(),
    )


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
