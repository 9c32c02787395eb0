"""How the inner edges of a target cap of several faces divide themselves.

Place in the flow: after the rings, where recognition found which edge of the target answers to which of the source.

Method: as on the rings: an edge divides itself as the affine image of the source edge does. Of a cap that leaves the
plane of its loops, as the skin of a drawn sheet does, the map across that plane is fitted to the corners of its faces.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..arrays import FloatArray, IntArray
from ..sweep import Sweep
from .spacing import Fit, divide_like, finer

_PLANE = 1e-9
"""Height, as a share of their extent, up to which a loop's nodes lie in a plane."""
_N_CHORDS = 16
"""Chords that stand for a curved edge's segment."""


def divide_target_edges(
    sweep: Sweep, counts: IntArray, fractions: Mapping[int, FloatArray], rings: FloatArray, fit: Fit
) -> dict[int, FloatArray]:
    """Arc-length fractions of the nodes of inner target edges, by target edge id, from its start to its end.

    `fractions` are those of the source's edges that are not divided evenly.
    """
    on_loops = {edge for loop in sweep.source_loops for edge, _ in loop}
    inner = [e for e in sweep.target_edges if e not in on_loops]
    if not inner:
        return {}
    linear = fit(rings[0], rings[-1:])[0]
    linear = linear + _across_plane(sweep, rings, linear)
    found: dict[int, FloatArray] = {}
    for e in inner:
        n = int(counts[e])
        own = fractions.get(e, np.linspace(0.0, 1.0, n + 1))
        fine = sweep.solid.edges[e].curve.evaluate(finer(own, _N_CHORDS))
        along = divide_like(np.diff(fine, axis=0).reshape(n, _N_CHORDS, 3), linear)
        target, same_direction = sweep.target_edges[e]
        found[target] = along if same_direction else (1.0 - along)[::-1]
    return found


def _across_plane(sweep: Sweep, rings: FloatArray, linear: FloatArray) -> FloatArray:
    """What the linear part (3, 3) of a plane source ring's map lacks: the image of what is across its plane."""
    center, far_center = rings[0].mean(axis=0), rings[-1].mean(axis=0)
    off = rings[0] - center
    _, extents, directions = np.linalg.svd(off, full_matrices=False)
    if extents[-1] > _PLANE * extents[0]:
        return np.zeros((3, 3))
    edges = sweep.solid.edges
    pairs: dict[int, int] = {}
    for e, (target, same) in sweep.target_edges.items():
        ends = edges[target].start, edges[target].end
        pairs.update(zip((edges[e].start, edges[e].end), ends if same else ends[::-1], strict=True))
    corners, far_corners = (sweep.solid.vertices[list(found)] for found in (pairs, pairs.values()))
    corners, far_corners = corners - center, far_corners - far_center
    heights = corners @ directions[-1]
    if np.abs(heights).max() <= _PLANE * extents[0]:
        return np.zeros((3, 3))
    image = heights @ (far_corners - corners @ linear.T) / (heights @ heights)
    return np.outer(image, directions[-1])
