"""Which edges of a part's cells are pieces of an edge of the model, before it was cut.

Cells made in the plane of their cuts know neither names nor the kernel's edges, and where an edge runs along a cut the
piece belongs to cells on both sides. So pieces are found by place: those that lie on the model's edge.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...brep import Part

ON_EDGE = 1e-6
"""Distance, in sizes of the solid, up to which a piece lies on the edge that it came from: cuts leave 1e-7 of it."""

Piece = tuple[int, bool, float]
"""Key of an edge of the cells, whether it runs the way that is asked for, and its length."""


def pieces_along(part: Part, model: Part, cell: int, edge: int, *, forward: bool = True) -> list[Piece]:
    """The pieces of an edge of a solid of the model, in the order in which a way along it meets them."""
    solid = model.solids[cell]
    own = solid.edges[edge]
    if part is model or any(solid is one for one in part.solids):
        return [(int(solid.edge_keys[edge]), forward, own.length)]
    near = ON_EDGE * solid.size + 2.0 * max(own.gap, solid.tolerance)
    name = model.models[model.owners[cell]].name
    found: dict[int, tuple[float, float]] = {}
    for key, places in _edges_of(part, name):
        if key in found or np.linalg.norm(places[1] - own.midpoint) > own.length + near:
            continue
        at = np.clip(own.curve.project(places), 0.0, 1.0)
        if np.linalg.norm(own.curve.evaluate(at) - places, axis=1).max() <= near and at[0] != at[2]:
            found[key] = (float(at[0]), float(at[2]))
    pieces = [(key, end > begin, abs(end - begin) * own.length) for key, (begin, end) in _in_order(found)]
    return pieces if forward else [(key, not along, length) for key, along, length in reversed(pieces)]


def _in_order(found: dict[int, tuple[float, float]]) -> list[tuple[int, tuple[float, float]]]:
    return sorted(found.items(), key=lambda item: min(item[1]))


def _edges_of(part: Part, name: str) -> Iterator[tuple[int, np.ndarray]]:
    """Keys, and start, middle and end (3, 3), of the edges of the cells of one solid of the model."""
    for cell, solid in enumerate(part.solids):
        if part.models[part.owners[cell]].name != name:
            continue
        for key, edge in zip(solid.edge_keys.tolist(), solid.edges, strict=True):
            yield key, np.array([solid.vertices[edge.start], edge.midpoint, solid.vertices[edge.end]])
