"""The table of edges of ``cadsweep info --edges``: where each edge is, and what it does in the best sweep.

Place in the flow: beside :mod:`.reasons`.
"""

from __future__ import annotations

from typing import Any

from ..brep import Solid
from ..sweep import Sweep


def describe_edges(solid: Solid, sweep: Sweep | None) -> list[dict[str, Any]]:
    """Return a row for every edge.

    Parameters
    ----------
    solid : Solid
    sweep : Sweep or None
        The best one; None leaves the roles open.

    Returns
    -------
    list of dict
        id, name, groups, type, length, middle, faces, role: ``along, span 2`` (numbered from the source; of which loop,
        where it is not the outer one), ``source``, ``target``, ``station 1``, ``around`` or ``-``.
    """
    roles = {} if sweep is None else _roles(solid, sweep)
    return [
        {
            "id": edge.id,
            "name": edge.name or "",
            "groups": list(edge.groups),
            "type": edge.kind,
            "length": edge.length,
            "middle": tuple(float(c) for c in edge.midpoint),
            "faces": list(edge.faces),
            "role": roles.get(edge.id, "-"),
        }
        for edge in solid.edges
    ]


def _roles(solid: Solid, sweep: Sweep) -> dict[int, str]:
    roles = {e: "around" for side in sweep.linking_sides for e, _ in side.bottom + side.top}
    for number, ring in enumerate(sweep.stations, 1):
        roles |= dict.fromkeys(ring, f"station {number}")
    for role, cap in (("source", sweep.source), ("target", sweep.target)):
        roles |= {e: role for f in cap for e in solid.faces[f].edges}
    for loop, spans in enumerate(sweep.spans):
        for number, span in enumerate(spans, 1):
            roles |= dict.fromkeys(span, f"along, span {number}" + (f" of loop {loop + 1}" if loop else ""))
    return roles
