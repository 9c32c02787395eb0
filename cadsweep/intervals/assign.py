"""Join the steps of :mod:`cadsweep.intervals`: check the wishes, then settle layers and loops."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from math import isfinite
from numbers import Integral, Real
from typing import Any

import numpy as np

from ..errors import InputError
from ..topology import Intervals, Sweep
from .layers import assign_layers
from .loops import assign_loops, loop_edges
from .sizes import TURN_LAYER, TURN_SIZED, default_size, path_length, turning, wanted_counts

log = logging.getLogger(__name__)

MOST_SEGMENTS = 1_000_000
"""Segments of one edge beyond which a size is taken for a mistake."""


def assign_intervals(
    sweep: Sweep,
    *,
    size: float | None = None,
    layers: int | None = None,
    edge_sizes: Mapping[int, float] | None = None,
    edge_counts: Mapping[int, int] | None = None,
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
        Target edge length of single edges, working units.
    edge_counts : mapping of int to int, optional
        Demanded counts of single edges.

    Returns
    -------
    Intervals
        Opposite sides of every linking side have equal sums; the loops of the source cap's faces
        have even ones.

    Raises
    ------
    InputError
        A size, number or edge id is not what it should be, or there are fewer layers than spans.
    SurfaceMeshError
        The demanded counts contradict each other.
    """
    solid = sweep.solid
    wide = max(float(np.linalg.norm(np.ptp(solid.vertices, axis=0))), solid.size)
    if size is not None:
        size = _check_size("size", size, wide)
    if layers is not None:
        layers = _check_count("layers", layers)
    sizes = {_check_edge(sweep, e): _check_size(f"size of edge {e}", s, wide) for e, s in (edge_sizes or {}).items()}
    fixed = {_check_edge(sweep, e): _check_count(f"count of edge {e}", n) for e, n in (edge_counts or {}).items()}
    target_size = default_size(sweep) if size is None else size

    rails = set(sweep.rails)
    n_wanted = max(
        path_length(sweep) / target_size,
        2.0 if size is None else 1.0,
        _rail_turning(sweep) / (TURN_LAYER if size is None else TURN_SIZED),
    )
    rail_wishes = {e: max(1.0, solid.edges[e].length / s) for e, s in sizes.items() if e in rails}
    rail_counts, n_layers = assign_layers(
        sweep,
        n_wanted=n_wanted,
        n_fixed=layers,
        wanted=rail_wishes,
        fixed={e: n for e, n in fixed.items() if e in rails},
    )
    wanted = wanted_counts(sweep, loop_edges(sweep), target_size, sizes, sized=size is not None)
    most = max(wanted.values())
    if most > MOST_SEGMENTS:
        raise InputError(f"size {target_size:g} would divide an edge into {most:.3g} segments: take a larger size")
    loop_counts = assign_loops(
        sweep, wanted=wanted, wished=sizes.keys(), fixed={e: n for e, n in fixed.items() if e not in rails}
    )
    counts = np.zeros(len(solid.edges), dtype=np.int64)
    for e, n in (rail_counts | loop_counts).items():
        counts[e] = n
    log.debug("size %g, %d layers, %d segments around", target_size, n_layers, sum(loop_counts.values()))
    return Intervals(counts=counts, n_layers=n_layers, size=float(target_size))


def _rail_turning(sweep: Sweep) -> float:
    """Greatest turn of the way from source to target: over all spans, the most any of their rails turns."""
    return max(sum(max(turning(sweep, sweep.solid.edges[e]) for e in span) for span in loop) for loop in sweep.spans)


def _check_edge(sweep: Sweep, edge: Any) -> int:
    if isinstance(edge, bool) or not isinstance(edge, Integral) or not 0 <= int(edge) < len(sweep.solid.edges):
        raise InputError(f"there is no edge {edge!r}; the solid has edges 0 to {len(sweep.solid.edges) - 1}")
    return int(edge)


def _check_size(what: str, size: Any, wide: float) -> float:
    if isinstance(size, bool) or not isinstance(size, Real) or not isfinite(float(size)) or float(size) <= 0.0:
        raise InputError(f"{what} must be a positive length, not {size!r}")
    if float(size) > wide:
        raise InputError(f"{what} {float(size):g} is larger than the whole part, whose diagonal is {wide:.4g}")
    return float(size)


def _check_count(what: str, count: Any) -> int:
    if isinstance(count, bool) or not isinstance(count, Integral) or int(count) < 1:
        raise InputError(f"{what} must be a whole number of at least 1, not {count!r}")
    if int(count) > MOST_SEGMENTS:
        raise InputError(f"{what} {int(count)} is more than {MOST_SEGMENTS}: take a smaller number")
    return int(count)
