"""From the user's words for edges to their ids: sizes, counts, and layers of rails."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np
import scipy

from ... import cad, intervals
from ...arrays import FloatArray
from ...brep import Part
from ...errors import InputError
from ...options import SweepOptions
from ...surface import Division
from ...sweep import Sweep
from .biases import biases_of, divisions_of, resolve_biases
from .local_sizes import GROWTH, size_field
from .periodic_sides import SweepMatch, of_sweep, with_images
from .shared_hints import check_words, demand, resolve_wishes
from .size_divisions import divide_by_sizes, least_along

_SAMPLES = 100
"""Places along an edge from which sizes grow."""
_SPAN = re.compile(r"span\s+(\d+)")


@dataclass(frozen=True, kw_only=True)
class Hints:
    """What the user asks of single edges of one sweep.

    Attributes
    ----------
    sizes : dict of int to float
        Wanted edge length, working units.
    counts : dict of tuple of int to int
        Demanded segments of edges together.
    wished : frozenset of int
        Edges of `sizes` that the user has named; the others are divided finer for another reason.
    inside : callable or None
        Wanted lengths (m,) at points (m, 3) of the source cap, working units.
    divisions : dict of int to callable
        How edges divide themselves that are not divided evenly.
    matches : tuple of SweepMatch
        Faces whose meshes answer each other.
    """

    sizes: dict[int, float]
    counts: dict[tuple[int, ...], int]
    wished: frozenset[int] = frozenset()
    inside: Callable[[FloatArray], FloatArray] | None = None
    divisions: dict[int, Division] = field(default_factory=dict)
    matches: tuple[SweepMatch, ...] = ()


def resolve_hints(part: Part, sweep: Sweep, options: SweepOptions) -> Hints:
    """Find the edges that the user means.

    Raises
    ------
    InputError
        Nothing has such a name, two wishes contradict each other, or layers are asked of an edge that is no rail.
    """
    check_words(part, options)
    wishes = resolve_wishes(part, options, part)
    ids = {key: e for e, key in enumerate(sweep.solid.edge_keys.tolist())}
    sizes = {ids[key]: size for key, size in wishes.edge_sizes.items()}
    sizes = {e: size for size in wishes.cell_sizes.values() for e in ids.values()} | sizes
    demands = {own.keys: own for own in wishes.demands}
    for word, count in (options.rail_layers or {}).items():
        for chain in _chains(part, sweep, word):
            demand(part, demands, sweep.solid.edge_keys[list(chain)].tolist(), count, f"rail_layers of '{word}'")
    matches = of_sweep(part, sweep, options)
    named = frozenset(sizes)
    divisions = with_images(matches, _graded(part, sweep, options))
    wanted = intervals.default_size(sweep) if options.size is None else options.size / part.scale
    field_ = size_field(part, options, wanted)
    if field_ is not None:
        if options.fractions is not None or options.layers is not None:
            raise InputError("local_sizes divide edges along the sweep, too: without layers and fractions")
        sides = [(sweep.solid, side) for side in sweep.linking_sides]
        by_key, divided_by_key = divide_by_sizes([sweep.solid], [sweep], sides, field_)
        keys = sweep.solid.edge_keys.tolist()
        sizes = {e: by_key[key] for e, key in enumerate(keys)} | sizes
        divisions = {e: divided_by_key[key] for e, key in enumerate(keys) if key in divided_by_key} | divisions
    elif sizes and not (options.wall_layers or options.periodic):
        # Where rows along walls end, and what answers another face, is settled elsewhere.
        grown_sizes, grown = _grown_back(sweep, sizes, wanted, spoken={*named, *divisions})
        sizes, divisions = grown_sizes | sizes, grown | divisions
    return Hints(
        sizes=sizes,
        counts={tuple(sorted(ids[key] for key in own.keys)): own.count for own in demands.values()},
        wished=named,
        inside=None if field_ is None else least_along(sweep, field_),
        divisions=divisions,
        matches=matches,
    )


def fitting_sweeps(part: Part, sweeps: list[Sweep], options: SweepOptions) -> list[Sweep]:
    """Keep the sweeps along which all edges run that the user wants layers on; those first whose walls are alike.

    Raises
    ------
    InputError
        There is none; says what is wrong with the best one.
    """
    if options.wall_layers:
        walls = {f for word in options.wall_layers for f in cad.select_faces(part, word)}
        # Walls that are sides here and caps there get heights that are less exact.
        sweeps = sorted(sweeps, key=lambda sweep: 0 < len(walls.intersection(sweep.source + sweep.target)) < len(walls))
    if not (options.rail_layers or options.periodic):
        return sweeps
    fitting, errors = [], []
    for sweep in sweeps:
        try:
            of_sweep(part, sweep, options)
            for word in options.rail_layers or {}:
                _chains(part, sweep, word)
            fitting.append(sweep)
        except InputError as error:
            errors.append(error)
    if not fitting:
        raise errors[0]
    return fitting


def _grown_back(
    sweep: Sweep, sizes: dict[int, float], size: float, *, spoken: Collection[int]
) -> tuple[dict[int, float], dict[int, Division]]:
    """Mean sizes and divisions of the edges around the caps that begin where others are to be finer."""
    edges, at = sweep.solid.edges, np.linspace(0.0, 1.0, _SAMPLES + 1)
    finer = {e: own for e, own in sizes.items() if own < size}
    if not finer:
        return {}, {}
    places = [(scipy.spatial.cKDTree(edges[e].curve.evaluate(at)), own) for e, own in finer.items()]

    def field(points: FloatArray) -> FloatArray:
        grown = [own + (GROWTH - 1.0) * tree.query(points)[0] for tree, own in places]
        return np.asarray(np.minimum(np.min(grown, axis=0), size))

    sides = [(sweep.solid, side) for side in sweep.linking_sides]
    by_key, divided = divide_by_sizes([sweep.solid], [sweep], sides, field)
    keys = sweep.solid.edge_keys.tolist()
    ends = {v for e in finer for v in (edges[e].start, edges[e].end)}
    rails = set(sweep.rails)
    beside = [e.id for e in edges if e.id not in rails and e.id not in spoken and not ends.isdisjoint((e.start, e.end))]
    return (
        {e: by_key[keys[e]] for e in beside if keys[e] in divided},
        {e: divided[keys[e]] for e in beside if keys[e] in divided},
    )


def _graded(part: Part, sweep: Sweep, options: SweepOptions) -> dict[int, Division]:
    found = divisions_of(biases_of(sweep.solid, resolve_biases(part, options)))
    rails = sorted(found.keys() & set(sweep.rails))
    if rails and options.fractions is not None:
        raise InputError(
            f"{sweep.solid.edges[rails[0]].label()} runs along the sweep, where fractions place the layers: a bias "
            "cannot grade it besides"
        )
    return found


def _chains(part: Part, sweep: Sweep, word: str | int) -> list[tuple[int, ...]]:
    span = _SPAN.fullmatch(str(word).strip())
    if span:
        return [intervals.span_chain(sweep, int(span[1]))]
    return intervals.rail_chains(sweep, cad.select_edges(part, word))
