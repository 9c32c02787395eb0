"""How messages name edges."""

from __future__ import annotations

from collections.abc import Sequence

from ..brep import Solid


def name_edges(solid: Solid, edges: Sequence[int], *, most: int = 6) -> str:
    """Name edges by id, name, kind and place."""
    words = [solid.edges[e].label() for e in edges[:most]]
    more = f" and {len(edges) - most} more" if len(edges) > most else ""
    return ", ".join(words) + more
