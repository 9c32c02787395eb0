"""How large the quads inside a cap should be: a size at every place of a chart, growing away from what is fine.

Place in the flow: ``quads`` makes a background for a chart, ``gmsh_quads`` hands it to gmsh.

Method: sizes stand at the nodes of a triangulation: those of the boundary have the length of their segments, those
inside what is wished there; the triangulation is finer where small sizes are wished. Then no node may want more
than its neighbour's size plus `growth` times the way there, as along a graph of ways. gmsh interpolates between them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray
from ..polygons import is_inside, mean_sides, next_corners

GROWTH = 1.3
"""Length of a segment over that of its neighbour towards what is fine."""
_MOST_NODES = 20_000
_LEVELS = 6
"""Halvings of the grid of sizes at most: cells a 64th of the face across."""
_FINE = 1.5
"""The triangulation is divided where its spacing is more than this many wished sizes."""


@dataclass(frozen=True, kw_only=True)
class Background:
    """Sizes on a triangulation that covers a polygon.

    Attributes
    ----------
    places : (n, 2) float64
    triangles : (t, 3) int64
    sizes : (n,) float64
        Wanted edge lengths.
    """

    places: FloatArray
    triangles: IntArray
    sizes: FloatArray

    def count_quads(self, loops: Sequence[FloatArray]) -> float:
        """About how many quads of these sizes fill a polygon."""
        return _count_quads(loops, self.places, self.triangles, self.sizes)


def count_interpolated(loops: Sequence[FloatArray]) -> float:
    """About how many quads fill a polygon where sizes inside are those of the outline, interpolated."""
    places = np.concatenate(loops)
    return _count_quads(loops, places, triangulated(places), mean_sides(loops))


def triangulated(places: FloatArray) -> IntArray:
    """Triangles (t, 3) of places (n, 2); of places on one line, flat ones from each to the next."""
    try:
        return np.asarray(scipy.spatial.Delaunay(places).simplices, dtype=np.int64)
    except scipy.spatial.QhullError:
        way = places[np.linalg.norm(places - places[0], axis=1).argmax()] - places[0]
        order = np.argsort(places @ way, kind="stable").astype(np.int64)
        return np.stack([order[:-1], order[1:], order[1:]], axis=1)


def _count_quads(loops: Sequence[FloatArray], places: FloatArray, triangles: IntArray, sizes: FloatArray) -> float:
    corners = places[triangles]
    inside = is_inside(loops, corners.mean(axis=1))
    first, second = corners[inside, 1] - corners[inside, 0], corners[inside, 2] - corners[inside, 0]
    areas = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    return float((areas / sizes[triangles[inside]].mean(axis=1) ** 2).sum())


def typical_length(loops: Sequence[FloatArray]) -> float:
    """Median length of the loops' segments, by length: half of the outline has shorter ones."""
    starts = np.concatenate(loops)
    steps = np.sort(np.linalg.norm(starts[next_corners(loops)] - starts, axis=1))
    run = np.cumsum(steps)
    return float(steps[np.searchsorted(run, run[-1] / 2)])


def make_background(
    loops: Sequence[FloatArray],
    *,
    largest: float,
    sizes_at: Callable[[FloatArray], FloatArray] | None = None,
    growth: float = GROWTH,
) -> Background:
    """Size field of a polygon.

    Parameters
    ----------
    loops : sequence of (m, 2) float64
        Outer loop counter-clockwise, holes clockwise.
    largest : float
        Greatest wanted length.
    sizes_at : callable, optional
        Wanted lengths (n,) at places (n, 2) of the polygon.
    growth : float
        Above 1.

    Returns
    -------
    Background
        Its boundary sizes are those of the boundary's segments, or less.
    """
    boundary = np.concatenate(loops)
    at_boundary = mean_sides(loops)
    low, high = boundary.min(axis=0), boundary.max(axis=0)
    spacing = max(largest, float(np.sqrt(np.prod(high - low) / (_MOST_NODES / 2))))
    n = np.maximum(2, np.ceil((high - low) / spacing).astype(np.int64)) + 1
    x, y = (np.linspace(low[j] - 0.01 * spacing, high[j] + 0.01 * spacing, n[j]) for j in (0, 1))
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    if sizes_at is None:
        inner, wished = grid, np.full(len(grid), largest)
    else:
        inner, wished = _sampled(loops, grid, spacing, largest, sizes_at)
    # Nodes that fall together with the boundary's would make needles of triangles.
    places = np.concatenate([boundary, inner])
    sizes = np.concatenate([at_boundary, wished])
    _, kept = np.unique(np.round(places / (1e-6 * spacing)), axis=0, return_index=True)
    kept = np.sort(kept)
    places, sizes = places[kept], sizes[kept]
    triangles = triangulated(places)
    return Background(places=places, triangles=triangles, sizes=limited(places, triangles, sizes, growth - 1.0))


def limited(places: FloatArray, triangles: IntArray, sizes: FloatArray, slope: float) -> FloatArray:
    """Sizes that rise by no more than `slope` times the length of the ways along a triangulation's edges."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    lengths = slope * np.linalg.norm(places[ends[:, 0]] - places[ends[:, 1]], axis=1)
    n = len(places)
    # One more node, from which every node is reached at the price of its own size: the rest is shortest ways.
    least = float(sizes.min())
    starts = np.concatenate([ends[:, 0], ends[:, 1], np.full(n, n)])
    stops = np.concatenate([ends[:, 1], ends[:, 0], np.arange(n)])
    prices = np.concatenate([lengths, lengths, sizes - 0.5 * least])
    entries = scipy.sparse.coo_matrix((prices, (starts, stops)), shape=(n + 1, n + 1))
    order = np.lexsort((entries.col, entries.row))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(entries.row[order]) != 0) | (np.diff(entries.col[order]) != 0)
    kept = order[first]  # edges of two triangles come twice, and a sparse matrix would add their lengths
    graph = scipy.sparse.csr_matrix((prices[kept], (starts[kept], stops[kept])), shape=(n + 1, n + 1))
    found: FloatArray = scipy.sparse.csgraph.dijkstra(graph, indices=n)[:n] + 0.5 * least
    return found


def _sampled(
    loops: Sequence[FloatArray],
    grid: FloatArray,
    spacing: float,
    largest: float,
    sizes_at: Callable[[FloatArray], FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Places inside, close where small sizes are wished, and the sizes there."""
    places, sizes = [], []
    left = _MOST_NODES
    for _ in range(_LEVELS):
        grid = grid[is_inside(loops, grid)]
        if not len(grid) or len(grid) > left:
            break
        wished = np.minimum(sizes_at(grid), largest)
        places.append(grid)
        sizes.append(wished)
        left -= len(grid)
        fine = grid[wished * _FINE < spacing]
        spacing /= 2
        corners = spacing / 2 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        grid = (fine[:, None] + corners).reshape(-1, 2)
    if not places:
        return np.empty((0, 2)), np.empty(0)
    return np.concatenate(places), np.concatenate(sizes)
