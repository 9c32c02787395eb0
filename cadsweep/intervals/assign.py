"""Join the steps of :mod:`cadsweep.intervals`: check the wishes, then settle layers and loops."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isfinite
from numbers import Integral, Real
from typing import Any

import numpy as np

from ..brep import Edge
from ..errors import InputError
from ..sweep import Intervals, Sweep
from .demands import Demand
from .layers import assign_layers
from .loops import assign_loops, loop_edges
from .naming import name_edges
from .sizes import (
    TURN_LAYER,
    TURN_SIZED,
    Split,
    default_layers,
    default_size,
    greatest_turn,
    path_length,
    split_counts,
    wanted_counts,
)

log = logging.getLogger(__name__)

MOST_SEGMENTS = 1_000_000
"""Segments of one edge beyond which a size is taken for a mistake."""


def assign_intervals(
    sweep: Sweep,
    *,
    size: float | None = None,
    layers: int | None = None,
    edge_sizes: Mapping[int, float] | None = None,
    edge_counts: Mapping[tuple[int, ...], int] | None = None,
    splits: Sequence[Split] = (),
) -> Intervals:
    """Choose the number of segments of every edge of a sweep.

    Parameters
    ----------
    sweep : Sweep
    size : float, optional
        Target edge length, working units; derived from the part if None (some 1e3 to 1e5 hexes).
    layers : int, optional
        Layers of hexes from source to target, shared among the spans by their length; derived
        from `size` if None.
    edge_sizes : mapping of int to float, optional
        Target edge length of single edges, working units. On an edge along the sweep it sets the layers that
        its span wants; a total that is not demanded follows.
    edge_counts : mapping of tuple of int to int, optional
        Demanded counts of edges together: of one, of a chain of rails, of the pieces of a divided edge.
    splits : sequence of (edges, callable)
        Edges around the loops that are graded together, and how they share their segments.

    Returns
    -------
    Intervals
        Opposite sides of every linking side have equal sums; the loops of the source cap's faces
        have even ones.

    Raises
    ------
    InputError
        A size, number or edge id is not what it should be, there are fewer layers than spans, or counts
        demanded along the sweep contradict each other or `layers`.
    SurfaceMeshError
        Counts demanded around the loops contradict each other.
    """
    solid = sweep.solid
    if size is not None:
        size = _check_size(size, lambda: "size")
    if layers is not None:
        layers = _check_count("layers", layers)
    sizes = {
        int(e): _check_size(s, partial(_size_of, solid.edges[_check_edge(sweep, e)]))
        for e, s in (edge_sizes or {}).items()
    }
    demands = [_check_demand(sweep, edges, n) for edges, n in (edge_counts or {}).items()]
    target_size = default_size(sweep) if size is None else size

    rails = set(sweep.rails)
    n_wanted = max(
        default_layers(sweep, target_size) if size is None else max(1.0, path_length(sweep) / target_size),
        greatest_turn(sweep) / (TURN_LAYER if size is None else TURN_SIZED),
    )
    demands_along = [demand for demand in demands if rails.issuperset(demand.edges)]
    demands_around = [demand for demand in demands if not rails.issuperset(demand.edges)]
    for demand in demands_around:
        if not rails.isdisjoint(demand.edges):
            raise InputError(
                f"a count of {demand.label(solid)} is demanded, and some of them run along the sweep, some around it: "
                "demand counts of the ones and of the others"
            )
    rail_wishes = {e: max(1.0, solid.edges[e].length / s) for e, s in sizes.items() if e in rails}
    _check_division(sweep, rail_wishes, sizes, target_size)
    rail_layers = assign_layers(
        sweep,
        n_wanted=n_wanted,
        n_fixed=layers,
        wanted=rail_wishes,
        demands=demands_along,
    )
    wanted = wanted_counts(sweep, loop_edges(sweep), target_size, sizes, sized=size is not None)
    for demand in demands_around:
        total = sum(solid.edges[e].length for e in demand.edges)
        wanted |= {e: max(1.0, demand.count * solid.edges[e].length / total) for e in demand.edges}
    shared = split_counts(wanted, splits)
    wanted |= shared
    _check_division(sweep, wanted, sizes, target_size)
    wished = sizes.keys() | shared.keys() | {e for demand in demands_around for e in demand.edges}
    loop_counts = assign_loops(sweep, wanted=wanted, wished=wished, demands=demands_around)
    counts = np.zeros(len(solid.edges), dtype=np.int64)
    for e, n in loop_counts.items():
        counts[e] = n
    for e, (begin, end) in rail_layers.items():
        counts[e] = end - begin
    n_layers = max(end for _, end in rail_layers.values())
    span_layers = tuple(
        tuple(max(rail_layers[e][1] for e in span) - min(rail_layers[e][0] for e in span) for span in loop)
        for loop in sweep.spans
    )
    log.debug("size %g, %d layers, %d segments around", target_size, n_layers, sum(loop_counts.values()))
    return Intervals(counts=counts, n_layers=n_layers, size=float(target_size), span_layers=span_layers)


def _check_division(sweep: Sweep, wanted: Mapping[int, float], sizes: Mapping[int, float], size: float) -> None:
    """Refuse a size so small that the programme would never end."""
    edge = max(wanted, key=lambda e: wanted[e], default=None)
    if edge is not None and wanted[edge] > MOST_SEGMENTS:
        solid = sweep.solid
        raise InputError(
            f"size {sizes.get(edge, size) * solid.units.scale:g} would divide {solid.edges[edge].label()} into "
            f"{wanted[edge]:.3g} segments: take a larger size"
        )


def _check_demand(sweep: Sweep, edges: tuple[int, ...], count: Any) -> Demand:
    chosen = tuple(_check_edge(sweep, e) for e in edges)
    if not chosen:
        raise InputError("a count is demanded of no edge")
    count = _check_count(f"the count of {name_edges(sweep.solid, chosen)},", count)
    if count < len(chosen):
        raise InputError(f"{name_edges(sweep.solid, chosen)} need a segment each, and {count} are demanded")
    return Demand(edges=chosen, count=count)


def _check_edge(sweep: Sweep, edge: Any) -> int:
    if isinstance(edge, bool) or not isinstance(edge, Integral) or not 0 <= int(edge) < len(sweep.solid.edges):
        raise InputError(f"there is no edge {edge!r}; the solid has edges 0 to {len(sweep.solid.edges) - 1}")
    return int(edge)


def _size_of(edge: Edge) -> str:
    return f"the size of {edge.label()},"


def _check_size(size: Any, what: Callable[[], str]) -> float:
    if isinstance(size, bool) or not isinstance(size, Real) or not isfinite(float(size)) or float(size) <= 0.0:
        raise InputError(f"{what()} must be a positive length, not {size!r}")
    return float(size)


def _check_count(what: str, count: Any) -> int:
    if isinstance(count, bool) or not isinstance(count, Integral) or int(count) < 1:
        raise InputError(f"{what} must be a whole number of at least 1, not {count!r}")
    if int(count) > MOST_SEGMENTS:
        raise InputError(f"{what} {int(count)} is more than {MOST_SEGMENTS}: take a smaller number")
    return int(count)
