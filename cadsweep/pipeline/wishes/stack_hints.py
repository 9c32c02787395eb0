"""From the user's words for edges to a stack's: edges of its arrangement, and layers between its caps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ... import cad
from ...brep import Part
from ...errors import InputError
from ...intervals import CellSweep, KeyDemand, Wishes, cell_sizes
from ...options import SweepOptions
from ...stack import Levels, Stack
from ...stacks import Sheets
from ...surface import Chain, Division, turned
from .biases import biases_of, divisions_of, resolve_biases, whole_edges
from .cell_asks import CellAsks, divided_asks
from .local_sizes import size_field
from .periodic_walls import matched_walls
from .shared_hints import check_words, demand, resolve_wishes
from .stack_sizes import layers_by_place, least_over

_SAMPLES = 1000
"""Places along an edge among which the ends of its pieces on the plane are found."""
_FIRM = 100.0
"""Weight of a size asked for against that of one that follows from the part's."""


@dataclass(frozen=True, kw_only=True)
class StackHints:
    """What the user asks of a stack.

    Attributes
    ----------
    plane : CellAsks
        Of the prism whose cap the plane is, as a part of one cell.
    layer_sizes : dict of (int, int) to float
        Wanted height of the layers between two sheets, working units.
    layers : dict of (int, int) to int
        Demanded layers between two sheets.
    gradings : dict of (int, int) to callable
        How the layers between two sheets divide the height, from the lower one.
    """

    plane: CellAsks
    layer_sizes: dict[tuple[int, int], float] = field(default_factory=dict)
    layers: dict[tuple[int, int], int] = field(default_factory=dict)
    gradings: dict[tuple[int, int], Division] = field(default_factory=dict)

    @property
    def demanded(self) -> set[int]:
        """Edges of the plane whose counts the user gave."""
        return {e for own in self.plane.wishes.demands for e in own.keys}

    @property
    def fixed(self) -> set[int]:
        """Edges whose segments the user asked for."""
        return self.demanded | set(self.plane.wishes.edge_sizes)

    def on_plane(self, *, divisions: Mapping[int, Division] | None = None, **wishes: Any) -> StackHints:
        """The same with more divisions, and other fields of the plane's wishes."""
        return replace(
            self,
            plane=replace(
                self.plane,
                wishes=replace(self.plane.wishes, **wishes),
                divisions={**self.plane.divisions, **(divisions or {})},
            ),
        )

    def finer(self, sizes: Mapping[int, float], divisions: Mapping[int, Division] | None = None) -> StackHints:
        """The same with edges that may be divided finer than the size asks, and how they divide themselves."""
        return self.on_plane(divisions=divisions, most_sizes={**self.plane.wishes.most_sizes, **sizes})


def resolve_stack_hints(  # noqa: PLR0917
    part: Part, stack: Stack, sheets: Sheets, prism: Part, cells: Sequence[CellSweep], options: SweepOptions
) -> StackHints:
    """Find what the user means on the plane, `prism` as a part of one of `cells`, and between sheets.

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
    check_words(part, options)
    asked = resolve_wishes(part, options, part)
    ids = {key: e for e, key in enumerate(stack.solid.edge_keys.tolist())}
    sizes: dict[int, float] = {}
    layer_sizes: dict[tuple[int, int], float] = {}
    for key, size in asked.edge_sizes.items():
        for own in pieces.get(ids[key], ()):
            sizes[own] = min(sizes.get(own, size), size)
        pair = _between(stack, sheets, ids[key])
        if pair is not None:
            layer_sizes[pair] = min(layer_sizes.get(pair, size), size)
    demands = {own.keys: own for own in asked.demands}
    rails: set[tuple[int, ...]] = set()
    for word, count in (options.rail_layers or {}).items():
        for edges in whole_edges(part.solids[0], cad.select_edges(part, word)):
            keys = tuple(sorted(stack.solid.edge_keys[list(edges)].tolist()))
            demand(part, demands, keys, count, f"rail_layers of '{word}'")
            rails.add(keys)
    layers: dict[tuple[int, int], KeyDemand] = {}
    counts: dict[tuple[int, ...], KeyDemand] = {}
    for one in demands.values():
        _demand(stack, sheets, pieces, tuple(ids[key] for key in one.keys), one, layers, counts, one.keys in rails)
    on_plane, gradings = _graded(part, stack, sheets, pieces, options)
    wishes = Wishes(size=asked.size, layers=1, edge_sizes=sizes, demands=tuple(counts.values()))
    partners = matched_walls(part, stack, options)
    sized = size_field(part, options, cell_sizes(cells, wishes)[0])
    least = None if sized is None else least_over(stack, sheets, sized)
    plane = divided_asks(prism, cells, options, wishes, divisions_of(on_plane), partners, least)
    if sized is not None:
        by_place, graded = layers_by_place(stack, sheets, sized)
        layer_sizes, gradings = by_place | layer_sizes, graded | gradings
    return StackHints(
        plane=plane,
        layer_sizes=layer_sizes,
        layers={pair: own.count for pair, own in layers.items()},
        gradings=gradings,
    )


def _graded(
    part: Part, stack: Stack, sheets: Sheets, pieces: Mapping[int, Sequence[int]], options: SweepOptions
) -> tuple[list[Chain], dict[tuple[int, int], Division]]:
    """Chains of edges of the plane, and layers between sheets, that biases grade."""
    on_plane: list[Chain] = []
    gradings: dict[tuple[int, int], Division] = {}
    for chain in biases_of(stack.solid, resolve_biases(part, options)):
        edge = chain.edges[0][0]
        if _between(stack, sheets, edge) is not None:
            gradings.update(_gradings(stack, sheets, chain))
        elif all(e in pieces for e, _ in chain.edges):
            on_plane.append(_below(stack, chain, pieces))
        else:
            raise InputError(
                f"{stack.solid.edges[edge].label()} neither bounds a cap nor runs along the direction of the columns "
                "that the part is meshed in: a bias cannot grade it"
            )
    return on_plane, gradings


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
    pieces: Mapping[int, Sequence[int]],
    edges: tuple[int, ...],
    one: KeyDemand,
    layers: dict[tuple[int, int], KeyDemand],
    counts: dict[tuple[int, ...], KeyDemand],
    is_rail: bool,
) -> None:
    """Demand a count of the edges of the plane below some edges, or of the layers beside one."""
    label = ", ".join(stack.solid.edges[e].label() for e in edges)
    pair = _between(stack, sheets, edges[0])
    below = tuple(sorted({own for edge in edges for own in pieces.get(edge, ())}))
    if pair is not None and len(edges) > 1:
        raise InputError(f"{label}: {one.label} asks for layers of an edge in pieces; ask for those of one of them")
    if pair is None and (is_rail or not below):
        raise InputError(f"{label}: {one.label} asks for layers, and the edge does not run along the stack's direction")
    other = counts.setdefault(below, replace(one, keys=below)) if pair is None else layers.setdefault(pair, one)
    if other.count != one.count:
        raise InputError(f"{label}: {other.label} asks for {other.count} segments, {one.label} for {one.count}")


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
