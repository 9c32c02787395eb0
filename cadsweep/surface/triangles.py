"""Removing the last triangles of a mesh of quads.

Place in the flow: ``gmsh_quads``, where Blossom leaves a few triangles (on an even boundary always
an even number of them).

Method: a triangle and a neighbouring quad are a pentagon, and a pentagon is a triangle and a quad in
five ways: so a triangle walks through the quads, along a shortest path, until it meets another, and
the two become a quad. At each step the way with the best quad is taken; relaxing does the rest.
"""

from __future__ import annotations

from collections import deque
from itertools import pairwise

import numpy as np

from ..arrays import FloatArray, IntArray

Edge = tuple[int, int]


def remove_triangles(points: FloatArray, quads: IntArray, triangles: IntArray) -> IntArray | None:
    """Merge triangles in pairs.

    Parameters
    ----------
    points : (n, 2) float64
    quads, triangles : (q, 4), (t, 3) int64
        Counter-clockwise, conforming.

    Returns
    -------
    (q', 4) int64 or None
        Quads of the same boundary nodes; None where a triangle finds no partner.
    """
    cells: list[list[int] | None] = [*triangles.tolist(), *quads.tolist()]
    owner: dict[Edge, int] = {}
    for i, cell in enumerate(cells):
        for edge in _edges(cell or []):
            owner[edge] = i
    for i in range(len(triangles)):
        if cells[i] is None or len(cells[i] or ()) != 3:
            continue
        path = _path_to_triangle(cells, owner, i)
        if path is None:
            return None
        _walk(points, cells, owner, path)
    kept = [cell for cell in cells if cell is not None]
    return np.array(kept, dtype=np.int64) if all(len(cell) == 4 for cell in kept) else None


def _edges(cell: list[int]) -> list[Edge]:
    return list(zip(cell, cell[1:] + cell[:1], strict=True))


def _path_to_triangle(cells: list[list[int] | None], owner: dict[Edge, int], start: int) -> list[int] | None:
    """Cells from one triangle to the nearest other, each sharing an edge with the next."""
    before = {start: start}
    queue = deque([start])
    while queue:
        i = queue.popleft()
        cell = cells[i]
        assert cell is not None
        if len(cell) == 3 and i != start:
            path = [i]
            while path[-1] != start:
                path.append(before[path[-1]])
            return path[::-1]
        for a, b in _edges(cell):
            j = owner.get((b, a))
            if j is not None and j not in before:
                before[j] = i
                queue.append(j)
    return None


def _set(cells: list[list[int] | None], owner: dict[Edge, int], i: int, cell: list[int]) -> None:
    cells[i] = cell
    for edge in _edges(cell):
        owner[edge] = i


def _walk(points: FloatArray, cells: list[list[int] | None], owner: dict[Edge, int], path: list[int]) -> None:
    """Move the triangle path[0] along the path and merge it with the triangle at its end."""
    walker = path[0]
    for j, following in pairwise(path[1:]):
        border = _union(cells, walker, j)
        exits = {(b, a) for a, b in _edges(cells[following] or [])}
        best: tuple[float, list[int], list[int]] | None = None
        for k in range(5):
            ring = border[k:] + border[:k]
            triangle, quad = ring[:3], [ring[0], *ring[2:]]
            # The triangle must touch the next cell, and not be the one there was.
            if not exits & {(ring[0], ring[1]), (ring[1], ring[2])} or set(triangle) == set(cells[walker] or ()):
                continue
            quality = min(_least_sine(points[quad]), _least_sine(points[triangle]))
            if best is None or quality > best[0]:
                best = (quality, triangle, quad)
        assert best is not None
        # The walker leaves its quad behind in place of the one it enters.
        _set(cells, owner, j, best[2])
        _set(cells, owner, walker, best[1])
    border = _union(cells, walker, path[-1])
    cells[path[-1]] = None
    _set(cells, owner, walker, border)


def _union(cells: list[list[int] | None], i: int, j: int) -> list[int]:
    """The nodes around two cells that share an edge, counter-clockwise."""
    edges = set(_edges(cells[i] or [])) | set(_edges(cells[j] or []))
    following = {a: b for a, b in edges if (b, a) not in edges}
    ring = [min(following)]
    while following[ring[-1]] != ring[0]:
        ring.append(following[ring[-1]])
    return ring


def _least_sine(polygon: FloatArray) -> float:
    step = np.roll(polygon, -1, axis=0) - polygon
    step = step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
    back = np.roll(step, 1, axis=0)
    return float(np.min(back[:, 0] * step[:, 1] - back[:, 1] * step[:, 0]))
