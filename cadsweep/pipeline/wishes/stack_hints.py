"""From the user's words for edges to a stack's: edges of its arrangement, and layers between its caps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ... import cad
from ...arrays import FloatArray
from ...brep import Part
from ...errors import InputError
from ...intervals import KeyDemand
from ...options import SweepOptions
from ...stack import Levels, Stack
from ...stacks import Sheets
from ...surface import Chain, Division, turned
from .biases import biases_of, divisions_of, resolve_biases, whole_edges
from .shared_hints import check_words, demand, resolve_wishes

_SAMPLES = 1000
"""Places along an edge among which the ends of its pieces on the plane are found."""
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
    divisions : dict of int to callable
        How edges of the arrangement divide themselves that are not divided evenly.
    gradings : dict of (int, int) to callable
        How the layers between two sheets divide the height, from the lower one.
    most_sizes : dict of int to float
        Edge length of edges of the arrangement that places ask for: they may be divided finer.
    inside : callable or None
        Wanted lengths (m,) at points (m, 3) of the plane.
    """

    sizes: dict[int, float] = field(default_factory=dict)
    counts: dict[tuple[int, ...], int] = field(default_factory=dict)
    layer_sizes: dict[tuple[int, int], float] = field(default_factory=dict)
    layers: dict[tuple[int, int], int] = field(default_factory=dict)
    divisions: dict[int, Division] = field(default_factory=dict)
    gradings: dict[tuple[int, int], Division] = field(default_factory=dict)
    most_sizes: dict[int, float] = field(default_factory=dict)
    inside: Callable[[FloatArray], FloatArray] | None = None


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
    check_words(part, options)
    wishes = resolve_wishes(part, options, part)
    ids = {key: e for e, key in enumerate(stack.solid.edge_keys.tolist())}
    for key, size in wishes.edge_sizes.items():
        for own in pieces.get(ids[key], ()):
            found.sizes[own] = min(found.sizes.get(own, size), size)
        pair = _between(stack, sheets, ids[key])
        if pair is not None:
            found.layer_sizes[pair] = min(found.layer_sizes.get(pair, size), size)
    demands = {own.keys: own for own in wishes.demands}
    rails: set[tuple[int, ...]] = set()
    for word, count in (options.rail_layers or {}).items():
        for edges in whole_edges(part.solids[0], cad.select_edges(part, word)):
            keys = tuple(sorted(stack.solid.edge_keys[list(edges)].tolist()))
            demand(part, demands, keys, count, f"rail_layers of '{word}'")
            rails.add(keys)
    known: dict[tuple[int, ...], KeyDemand] = {}
    for one in demands.values():
        edges = tuple(ids[key] for key in one.keys)
        _demand(stack, sheets, pieces, edges, one, known, found, is_rail=one.keys in rails)
    on_plane = []
    for chain in biases_of(stack.solid, resolve_biases(part, options)):
        edge = chain.edges[0][0]
        if _between(stack, sheets, edge) is not None:
            found.gradings.update(_gradings(stack, sheets, chain))
        elif all(e in pieces for e, _ in chain.edges):
            on_plane.append(_below(stack, chain, pieces))
        else:
            raise InputError(
                f"{stack.solid.edges[edge].label()} neither bounds a cap nor runs along the direction of the columns "
                "that the part is meshed in: a bias cannot grade it"
            )
    found.divisions.update(divisions_of(on_plane))
    return found


def _gradings(stack: Stack, sheets: Sheets, chain: Chain) -> Iterator[tuple[tuple[int, int], Division]]:
    """How the layers beside edges along the direction divide the heights of these, from the lower end."""
    for e, division in divisions_of([chain]).items():
        line, pair = stack.solid.edges[e], _between(stack, sheets, e)
        if pair is not None:
            up = float((stack.solid.vertices[line.end] - stack.solid.vertices[line.start]) @ stack.direction) > 0
            yield pair, division if up else turned(division)


def _below(stack: Stack, chain: Chain, pieces: Mapping[int, Sequence[int]]) -> Chain:
    """The chain of the edges of the arrangement under a chain of edges."""
    prism = stack.arrangement.prism
    across = np.eye(3) - np.outer(stack.direction, stack.direction)
    at = np.linspace(0.0, 1.0, _SAMPLES + 1)
    edges: list[tuple[int, bool]] = []
    for edge, forward in chain.edges:
        shadow = stack.solid.edges[edge].curve.evaluate(at) @ across
        own: list[tuple[float, float, int]] = []
        for piece in pieces[edge]:
            ends = prism.vertices[[prism.edges[piece].start, prism.edges[piece].end]] @ across
            begin, end = (float(at[np.argmin(np.linalg.norm(shadow - point, axis=1))]) for point in ends)
            if begin != end:
                own.append((begin, end, piece))
        own.sort(key=lambda one: min(one[:2]), reverse=not forward)
        edges += [(piece, (end > begin) == forward) for begin, end, piece in own]
    return replace(chain, edges=tuple(edges), lengths=tuple(prism.edges[e].length for e, _ in edges))


def grade_levels(levels: Levels, sheets: Sheets, hints: StackHints) -> Levels:
    """Move the levels between sheets to where gradings want them."""
    of = {s: levels.caps[cap] for cap, s in sheets.caps.items()}
    of |= {s: levels.stations[station] for station, s in sheets.stations.items()}
    heights = levels.heights.copy()
    for (low, high), division in hints.gradings.items():
        a, b = of[low], of[high]
        heights[a : b + 1] = heights[a] + (heights[b] - heights[a]) * division(b - a)
    return replace(levels, heights=heights)


def _demand(  # noqa: PLR0917
    stack: Stack,
    sheets: Sheets,
    pieces: dict[int, list[int]],
    edges: tuple[int, ...],
    one: KeyDemand,
    known: dict[tuple[int, ...], KeyDemand],
    found: StackHints,
    *,
    is_rail: bool,
) -> None:
    label = ", ".join(stack.solid.edges[e].label() for e in edges)
    pair = _between(stack, sheets, edges[0])
    on_plane = tuple(sorted({own for edge in edges for own in pieces.get(edge, ())}))
    if pair is not None and len(edges) > 1:
        raise InputError(f"{label}: {one.label} asks for layers of an edge in pieces; ask for those of one of them")
    if pair is None and (is_rail or not on_plane):
        raise InputError(f"{label}: {one.label} asks for layers, and the edge does not run along the stack's direction")
    other = known.setdefault(pair or on_plane, one)
    if other.count != one.count:
        raise InputError(f"{label}: {other.label} asks for {other.count} segments, {one.label} for {one.count}")
    if pair is not None:
        found.layers[pair] = one.count
    else:
        found.counts[on_plane] = one.count


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


def weigh_layers(sheets: Sheets, hints: StackHints, size: float) -> None:
    """Let the layers between sheets be of the height that the user wishes there."""
    for pair, wanted in hints.layer_sizes.items():
        spans = sheets.spans.get(pair)
        if spans:
            sheets.spans[pair] = [(height * size / wanted, weight * _FIRM) for height, weight in spans]
