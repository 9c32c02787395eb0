"""How messages name edges."""

from __future__ import annotations

from collections.abc import Sequence

from ..topology import Solid


def name_edges(solid: Solid, edges: Sequence[int], *, most: int = 6) -> str:
    """Name edges by id, name, kind and place."""
    words = []
    for e in edges[:most]:
        edge = solid.edges[e]
        x, y, z = (float(f"{c:.4g}") if abs(c) > 1e-9 else 0.0 for c in edge.midpoint)
        name = f" '{edge.name}'" if edge.name else ""
        words.append(f"edge {e}{name} ({edge.kind} at {x:g}, {y:g}, {z:g})")
    more = f" and {len(edges) - most} more" if len(edges) > most else ""
    return ", ".join(words) + more
