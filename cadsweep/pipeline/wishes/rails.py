"""Layers of rails as demands of counts by key; the sweeps that have what is asked of rails and matched faces."""

from __future__ import annotations

import re

from ... import cad, intervals
from ...brep import Part
from ...errors import InputError, SurfaceMeshError
from ...intervals import KeyDemand
from ...options import SweepOptions
from ...sweep import Sweep
from .periodic import find_matches, partners_of
from .shared_hints import demand

_SPAN = re.compile(r"span\s+(\d+)")


def demand_layers(part: Part, sweep: Sweep, options: SweepOptions, demands: dict[tuple[int, ...], KeyDemand]) -> None:
    """Demand the layers that the user asks of rails and spans of a sweep.

    Raises
    ------
    InputError
        An edge that is no rail, or layers that contradict what is demanded already.
    """
    for word, count in (options.rail_layers or {}).items():
        for chain in _chains(part, sweep, word):
            demand(part, demands, sweep.solid.edge_keys[list(chain)].tolist(), count, f"rail_layers of '{word}'")


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
    matches = find_matches(part, part, options)
    fitting, errors = [], []
    for sweep in sweeps:
        try:
            partners_of(part, matches)
            for word in options.rail_layers or {}:
                _chains(part, sweep, word)
            fitting.append(sweep)
        except (InputError, SurfaceMeshError) as error:
            errors.append(error)
    if not fitting:
        raise errors[0]
    return fitting


def _chains(part: Part, sweep: Sweep, word: str | int) -> list[tuple[int, ...]]:
    span = _SPAN.fullmatch(str(word).strip())
    if span:
        return [intervals.span_chain(sweep, int(span[1]))]
    return intervals.rail_chains(sweep, cad.select_edges(part, word))
