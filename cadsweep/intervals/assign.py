"""The counts of one sweep, asked for by the ids of its edges: checked, and settled as those of a part of one cell."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from math import isfinite
from numbers import Integral, Real
from typing import Any

from ..brep import Edge
from ..errors import InputError
from ..sweep import Intervals, Sweep
from .cell_sweeps import CellSweep, KeyDemand, Wishes
from .demands import Demand
from .naming import name_edges
from .sizes import Split
from .whole import assign_shared_intervals

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

    keys = sweep.solid.edge_keys
    wishes = Wishes(
        size=size,
        layers=layers,
        edge_sizes={int(keys[e]): own for e, own in sizes.items()},
        demands=[
            KeyDemand(keys=tuple(keys[list(own.edges)].tolist()), count=own.count, label=own.label(solid))
            for own in demands
        ],
        splits=[(tuple(keys[list(own)].tolist()), shares) for own, shares in splits],
    )
    cell = CellSweep(fill=sweep, grids=tuple(sweep.linking_sides), free=sweep.source, by_itself=True)
    return assign_shared_intervals([cell], wishes)[0]


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
