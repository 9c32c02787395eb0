"""From the user's words for edges to a stack's: edges of its arrangement, and layers between its caps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from .. import cad
from ..brep import Part
from ..errors import InputError
from ..options import SweepOptions
from ..stack import Stack
from ..stacks import Sheets

_FIRM = 100.0
"""Weight of a size asked for against that of one that follows from the part's."""


@dataclass(frozen=True, kw_only=True)
class StackHints:
    """What the user asks of single edges of a stack.

    Attributes
    ----------
    sizes : dict of int to float
        Wanted edge length of edges of the arrangement, working units.
    counts : dict of tuple of int to int
        Demanded segments of edges of the arrangement together.
    layer_sizes : dict of (int, int) to float
        Wanted height of the layers between two sheets, working units.
    layers : dict of (int, int) to int
        Demanded layers between two sheets.
    """

    sizes: dict[int, float] = field(default_factory=dict)
    counts: dict[tuple[int, ...], int] = field(default_factory=dict)
    layer_sizes: dict[tuple[int, int], float] = field(default_factory=dict)
    layers: dict[tuple[int, int], int] = field(default_factory=dict)


def resolve_stack_hints(part: Part, stack: Stack, sheets: Sheets, options: SweepOptions) -> StackHints:
    """Find the edges that the user means.

    Raises
    ------
    InputError
        Nothing has such a name, two wishes contradict each other, or layers are asked of an edge that does not run
        along the stack's direction.
    """
    pieces: dict[int, list[int]] = {}
    for own, over in stack.arrangement.over.items():
        for edge in over:
            pieces.setdefault(edge, []).append(own)
    found = StackHints()
    for edge, size in _sizes(part, options).items():
        for own in pieces.get(edge, ()):
            found.sizes[own] = min(found.sizes.get(own, size), size)
        pair = _between(stack, sheets, edge)
        if pair is not None:
            found.layer_sizes[pair] = min(found.layer_sizes.get(pair, size), size)
    known: dict[tuple[int, ...], tuple[int, str]] = {}
    for option, words in (("counts", options.counts), ("rail_layers", options.rail_layers)):
        for word, count in (words or {}).items():
            for edges in _whole_edges(part, cad.select_edges(part, word)):
                _demand(stack, sheets, pieces, edges, count, f"{option} of '{word}'", known, found, option)
    return found


def _demand(  # noqa: PLR0917
    stack: Stack,
    sheets: Sheets,
    pieces: dict[int, list[int]],
    edges: tuple[int, ...],
    count: int,
    word: str,
    known: dict[tuple[int, ...], tuple[int, str]],
    found: StackHints,
    option: str,
) -> None:
    label = ", ".join(stack.solid.edges[e].label() for e in edges)
    pair = _between(stack, sheets, edges[0])
    on_plane = tuple(sorted({own for edge in edges for own in pieces.get(edge, ())}))
    if pair is not None and len(edges) > 1:
        raise InputError(f"{label}: {word} asks for layers of an edge in pieces; ask for those of one of them")
    if pair is None and (option == "rail_layers" or not on_plane):
        raise InputError(f"{label}: {word} asks for layers, and the edge does not run along the stack's direction")
    key = pair or on_plane
    other, by = known.setdefault(key, (count, word))
    if other != count:
        raise InputError(f"{label}: {by} asks for {other} segments, {word} for {count}")
    if pair is not None:
        found.layers[pair] = count
    else:
        found.counts[on_plane] = count


def _between(stack: Stack, sheets: Sheets, edge: int) -> tuple[int, int] | None:
    """The sheets (lower, upper) at the ends of an edge along the direction; None for another edge."""
    solid, own = stack.solid, stack.solid.edges[edge]
    if any(f in sheets.caps for f in own.faces) or edge in sheets.stations:
        return None
    ends = sorted((own.start, own.end), key=lambda v: float(solid.vertices[v] @ stack.direction))
    low, high = (next(_sheets_at(stack, sheets, v)) for v in ends)
    return low, high


def _sheets_at(stack: Stack, sheets: Sheets, vertex: int) -> Iterator[int]:
    for edge in stack.solid.edges:
        if vertex in (edge.start, edge.end):
            yield from (sheets.caps[f] for f in edge.faces if f in sheets.caps)
            if edge.id in sheets.stations:
                yield sheets.stations[edge.id]


def _sizes(part: Part, options: SweepOptions) -> dict[int, float]:
    """Least size of the faces around each edge, unless the edge itself is named."""
    found: dict[str, dict[int, float]] = {"face": {}, "edge": {}}
    for word, size in (options.sizes or {}).items():
        kind, edges = cad.select_edges_of(part, word)
        for edge in edges:
            found[kind][edge] = min(found[kind].get(edge, size), size)
    return {edge: size / part.scale for edge, size in (found["face"] | found["edge"]).items()}


def _whole_edges(part: Part, edges: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Group the pieces of one edge of the input: it is the edge that the user knows."""
    groups: dict[str | int, list[int]] = {}
    for edge in edges:
        groups.setdefault(part.solids[0].edges[edge].key or edge, []).append(edge)
    return [tuple(group) for group in groups.values()]


def weigh_layers(sheets: Sheets, hints: StackHints, size: float) -> None:
    """Let the layers between sheets be of the height that the user wishes there."""
    for pair, wanted in hints.layer_sizes.items():
        spans = sheets.spans.get(pair)
        if spans:
            sheets.spans[pair] = [(height * size / wanted, weight * _FIRM) for height, weight in spans]
