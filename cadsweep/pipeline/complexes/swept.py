"""One sweep of one solid as a complex of one cell; of a ring that was cut open both caps are one face."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from ...brep import Part, Solid
from ...intervals import Wishes
from ...options import SweepOptions
from ...plan import Plan, way_of
from ...sweep import Sweep
from ..wishes.rails import demand_layers
from ..wishes.shared_hints import check_words, resolve_wishes
from .complex import Complex


def alone(part: Part, sweep: Sweep) -> Complex:
    """The part as the one cell of a sweep."""
    if sweep.closed:
        sweep = replace(sweep, solid=at_one_place(sweep.solid, sweep.source))
    own = replace(part, solids=(sweep.solid,))
    return Complex(part=own, plan=Plan(ways=(way_of(sweep),), order=(0,)), model=own, sweep=sweep)


def at_one_place(solid: Solid, kept: Collection[int]) -> Solid:
    """A ring that was cut open, what is on one side of the cut under the keys of what is on the other.

    `kept`: faces of the side that keeps its keys.
    """
    assert solid.opened is not None, "it was cut"
    here, there = solid.opened if solid.opened[0] & set(kept) else solid.opened[::-1]
    vertices, edges, faces = (keys.copy() for keys in (solid.vertex_keys, solid.edge_keys, solid.face_keys))
    own, other = (sorted({e for f in side for e in solid.faces[f].edges}) for side in (here, there))
    middles = np.array([solid.edges[e].midpoint for e in own])
    for t in other:
        e = own[int(np.argmin(np.linalg.norm(middles - solid.edges[t].midpoint, axis=1)))]
        edges[t] = edges[e]
        ends = [solid.edges[e].start, solid.edges[e].end]
        for v in (solid.edges[t].start, solid.edges[t].end):
            away = np.linalg.norm(solid.vertices[ends] - solid.vertices[v], axis=1)
            vertices[v] = vertices[ends[int(np.argmin(away))]]
    outlines = {frozenset(edges[list(solid.faces[f].edges)].tolist()): f for f in there}
    for face in here:
        faces[outlines[frozenset(edges[list(solid.faces[face].edges)].tolist())]] = faces[face]
    return replace(solid, vertex_keys=vertices, edge_keys=edges, face_keys=faces)


def twins_of(solid: Solid) -> dict[int, int]:
    """Edges of a ring that was cut open that have the key of another one, and that one."""
    first: dict[int, int] = {}
    pairs = [(e, first.setdefault(key, e)) for e, key in enumerate(solid.edge_keys.tolist())]
    return {e: other for e, other in pairs if e != other}


def wishes_of_sweep(part: Part, sweep: Sweep, options: SweepOptions) -> Wishes:
    """What is asked of the counts of one sweep, layers of its rails among it.

    Raises
    ------
    InputError
        Nothing has such a name, or two wishes contradict each other.
    """
    check_words(part, options)
    wishes = resolve_wishes(part, options, part)
    demands = {own.keys: own for own in wishes.demands}
    demand_layers(part, sweep, options, demands)
    layers = wishes.layers if options.fractions is None else len(options.fractions) - 1
    return replace(wishes, layers=layers, demands=tuple(demands.values()))
