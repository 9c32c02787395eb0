"""Edges along the sweep, as a user means them: chains of rails, and the spans between stations.

Place in the flow: the pipeline asks it which edges a demand for layers is about.
"""

from __future__ import annotations

from collections.abc import Collection

from ..errors import InputError
from ..sweep import Sweep
from .levels import directed_ends
from .naming import name_edges


def rail_chains(sweep: Sweep, edges: Collection[int]) -> list[tuple[int, ...]]:
    """Join rails that follow each other along the sweep.

    Parameters
    ----------
    sweep : Sweep
    edges : collection of int
        Some of ``sweep.rails``.

    Returns
    -------
    list of tuple of int
        Unbroken chains, each from source to target; all edges stand in one of them.

    Raises
    ------
    InputError
        An edge is none of the rails; names it.
    """
    others = sorted(set(edges).difference(sweep.rails))
    if others:
        raise InputError(
            f"{name_edges(sweep.solid, others)} {'does' if len(others) == 1 else 'do'} not run along the sweep from "
            f"{sweep.solid.faces[sweep.source[0]].label()} to {sweep.solid.faces[sweep.target[0]].label()}, so no "
            "layers can be asked of it: ask for a count, or choose the caps with source and target"
        )
    ends = _ends(sweep)
    begins = {ends[e][0]: e for e in edges}
    tops = {ends[e][1] for e in edges}
    chains = []
    for e in sorted(edges):
        if ends[e][0] in tops:
            continue
        chain = [e]
        while ends[chain[-1]][1] in begins:
            chain.append(begins[ends[chain[-1]][1]])
        chains.append(tuple(chain))
    return chains


def span_chain(sweep: Sweep, number: int) -> tuple[int, ...]:
    """A chain of rails from one end of a span of the outer loop to the other; spans count from 1 at the source.

    Raises
    ------
    InputError
        There is no such span, or none of its rails runs all the way.
    """
    spans = sweep.spans[0]
    if not 1 <= number <= len(spans):
        raise InputError(
            f"there is no span {number}: the sweep from {sweep.solid.faces[sweep.source[0]].label()} has "
            + ("one span" if len(spans) == 1 else f"spans 1 to {len(spans)}")
        )
    edges = sweep.solid.edges
    rings = [[e for e, _ in loop] for loop in (*sweep.source_loops, *sweep.target_loops)]
    closed = {v for ring in [*rings, *sweep.stations] for e in ring for v in (edges[e].start, edges[e].end)}
    ends = _ends(sweep)
    for chain in rail_chains(sweep, spans[number - 1]):
        if ends[chain[0]][0] in closed and ends[chain[-1]][1] in closed:
            return chain
    raise InputError(f"no rail runs all the way through span {number}: ask for layers on one of its edges instead")


def _ends(sweep: Sweep) -> dict[int, tuple[int, int]]:
    """Vertex towards the source and vertex towards the target of every rail."""
    return {d[0]: directed_ends(sweep.solid, d) for side in sweep.linking_sides for d in side.left + side.right}
