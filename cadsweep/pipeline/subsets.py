"""Cells of a part that hang together, and a part with some of its cells alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import scipy

from ..brep import Part


def touching_groups(part: Part) -> list[list[int]]:
    """Cells that hang together by faces, edges or vertices."""
    groups = scipy.cluster.hierarchy.DisjointSet(range(len(part.solids)))
    for kind in ("vertex_keys", "edge_keys", "face_keys"):
        seen: dict[int, int] = {}
        for cell, solid in enumerate(part.solids):
            for key in getattr(solid, kind).tolist():
                groups.merge(seen.setdefault(key, cell), cell)
    return sorted(sorted(group) for group in groups.subsets())


def subset(part: Part, cells: Sequence[int]) -> Part:
    """The part with some of its cells alone."""
    owners = sorted({part.owners[cell] for cell in cells})
    return replace(
        part,
        solids=tuple(part.solids[cell] for cell in cells),
        owners=tuple(owners.index(part.owners[cell]) for cell in cells),
        models=tuple(part.models[owner] for owner in owners),
    )
