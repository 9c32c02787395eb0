"""Cells that follow each other around a ring: where quads carried all the way come back to themselves.

Place in the flow: asked by :mod:`.search` where an order of cells would be a circle.
"""

from __future__ import annotations

from collections.abc import Mapping, Set

from ..brep import Part
from ..sweep import Sweep
from .ways import Role, Way, over

Shared = dict[int, list[tuple[int, int]]]
"""Face key to the cells and local faces that have it."""


def begin_around(part: Part, ways: Mapping[int, Way], shared: Shared, waiting: Set[int]) -> int | None:
    """The first of cells around a ring, each with the way that is chosen for it; None where none comes back to itself.

    The last cell finds both caps meshed then, with quads that answer each other.
    """
    for first in sorted(waiting):
        cell, seen = first, set[int]()
        landed: dict[int, int] | None = None
        while cell not in seen and cell in waiting:
            seen.add(cell)
            sweep, keys = ways[cell].fill, part.solids[cell].vertex_keys
            if not isinstance(sweep, Sweep):
                break
            outline = [sweep.solid.first_vertex(edge) for loop in sweep.source_loops for edge in loop]
            step = {int(keys[v]): int(keys[over(sweep, v)]) for v in outline if over(sweep, v) >= 0}
            landed = step if landed is None else {v: step.get(at, -1) for v, at in landed.items()}
            cell = _following(part, ways, shared, cell)
        if cell == first and landed and all(v == at for v, at in landed.items()):
            return first
    return None


def _following(part: Part, ways: Mapping[int, Way], shared: Shared, cell: int) -> int:
    """The cell whose source is the target of another one; -1 where there is none."""
    target = _faces(part, ways, cell, "last")
    beside = (other for other, _ in shared.get(min(target, default=-1), []) if other != cell and other in ways)
    return next((other for other in beside if _faces(part, ways, other, "first") == target), -1)


def _faces(part: Part, ways: Mapping[int, Way], cell: int, role: Role) -> set[int]:
    """Keys of the faces that have a role in the way of a cell."""
    keys = part.solids[cell].face_keys.tolist()
    return {key for key, own in zip(keys, ways[cell].roles, strict=True) if own == role}


__all__ = ["Shared", "begin_around"]
