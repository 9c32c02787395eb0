"""The quality that fixed nodes leave possible: :func:`boundary_limit`, :func:`corner_limits`.

Place in the flow: smoothing and reports ask it how good a swept mesh can become at all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray
from ..cells import SweptStructure

HEX_CORNERS = (
    (0, 1, 3, 4),
    (1, 2, 0, 5),
    (2, 3, 1, 6),
    (3, 0, 2, 7),
    (4, 7, 5, 0),
    (5, 4, 6, 1),
    (6, 5, 7, 2),
    (7, 6, 4, 3),
)
"""Each corner of a hexahedron and the ends of its three edges, in the order of a positive determinant."""


@dataclass(frozen=True, kw_only=True)
class BoundaryLimit:
    """The worst hexahedron corner that no smoothing of inner nodes can change.

    Attributes
    ----------
    value : float
        Scaled Jacobian of the corner; 1 where there is no such corner.
    node, hex, layer : int
        Node of the corner, its hexahedron, and the layer of hexahedra; -1 where there is none.
    """

    value: float = 1.0
    node: int = -1
    hex: int = -1
    layer: int = -1


def boundary_limit(points: FloatArray | Callable[[int], FloatArray], structure: SweptStructure) -> BoundaryLimit:
    """Find the worst hexahedron corner that is made of boundary nodes alone.

    Parameters
    ----------
    points : (n, 3) float64, or callable
        Nodes of the mesh, or a function that gives those of one layer (n_nodes, 3); only boundary nodes are looked at.
    structure : SweptStructure

    Returns
    -------
    BoundaryLimit
        An upper bound of the mesh's worst scaled Jacobian while its boundary nodes stay.
    """
    n, q, layers = structure.n_nodes, structure.quads, structure.n_layers
    nodes_of = points if callable(points) else lambda k: points[k * n : (k + 1) * n]
    rim = np.zeros(n, dtype=np.bool_)
    for loop in structure.loops:
        rim[loop] = True
    here = q.ravel()
    after, before = np.roll(q, -1, axis=1).ravel(), np.roll(q, 1, axis=1).ravel()
    on_rim = rim[here]
    all_rim = np.flatnonzero(on_rim & rim[after] & rim[before])
    best = BoundaryLimit()
    above = nodes_of(0)
    for layer in range(layers):
        upper = 0 if structure.periodic and layer == layers - 1 else layer + 1
        below, above = above, nodes_of(upper)
        for at, nodes in ((layer, below), (upper, above)):
            capped = not structure.periodic and at in (0, layers)
            # On a cap every node is fixed; elsewhere the rim alone. The other end of the upright edge lies on
            # the rim, or on the other cap of a mesh of one layer.
            corners = (np.arange(len(here)) if layers == 1 else np.flatnonzero(on_rim)) if capped else all_rim
            if not len(corners):
                continue
            low = here[corners]
            values = _corner_values(nodes, low, after[corners], before[corners], above[low] - below[low])
            i = int(np.argmin(values))
            if values[i] < best.value:
                node = int(here[corners[i]]) + at * n
                best = BoundaryLimit(
                    value=float(values[i]), node=node, hex=int(corners[i]) // 4 + layer * len(q), layer=layer
                )
    return best


Ways = Callable[[IntArray, IntArray], FloatArray]
"""For nodes (m,) and neighbours of theirs (m,), the directions (m, 3) in which these stay; NaN where they do not."""


def corner_limits(
    points: FloatArray, hexes: IntArray, fixed: npt.NDArray[np.bool_], ways: Ways | None = None
) -> FloatArray:
    """Bound (m,) of each hexahedron's scaled Jacobian by its fixed nodes; 1 where they say nothing.

    A corner whose four nodes are all fixed has its own value. One with two fixed edges is at most the sine of the
    angle between them: the third can do no better than stand upright on both.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 8) int64
    fixed : (n,) bool
    ways : callable, optional
        Knows of neighbours of fixed nodes that can move along a line through these alone: a corner between two such
        lines opens to the angle between them.
    """
    limits = np.ones(len(hexes))
    held = fixed[hexes]
    for corner, *ends in HEX_CORNERS:
        of = np.flatnonzero(held[:, [corner, *ends]].all(axis=1))
        here, after, before, upright = hexes[of][:, [corner, *ends]].T
        values = _corner_values(points, here, after, before, points[upright] - points[here])
        limits[of] = np.minimum(limits[of], values)
        for loose in range(3):
            one, other = ends[(loose + 1) % 3], ends[(loose + 2) % 3]
            of = np.flatnonzero(held[:, [corner, one, other]].all(axis=1) & ~held[:, ends[loose]])
            here, after, before = hexes[of][:, [corner, one, other]].T
            limits[of] = np.minimum(limits[of], _sines(points[after] - points[here], points[before] - points[here]))
            if ways is not None:
                of = np.flatnonzero(held[:, corner] & ~held[:, [one, other]].all(axis=1))
                limits[of] = np.minimum(limits[of], _opened(points, hexes[of][:, [corner, one, other]], fixed, ways))
    return limits


def _opened(points: FloatArray, corners: IntArray, fixed: npt.NDArray[np.bool_], ways: Ways) -> FloatArray:
    """Sines (c,) to which corners (c, 3) between lines through fixed nodes open; 1 where a side is on no such line."""
    here, ends = corners[:, 0], corners[:, 1:].T
    now = [points[end] - points[here] for end in ends]
    then = [np.where(fixed[end][:, None], chord, ways(here, end)) for end, chord in zip(ends, now, strict=True)]
    known: npt.NDArray[np.bool_] = np.all(np.isfinite(then), axis=(0, 2))
    return np.where(known, np.maximum(_sines(*now), _sines(*(np.where(known[:, None], way, 0.0) for way in then))), 1.0)


def _sines(one: FloatArray, other: FloatArray) -> FloatArray:
    """Sines (c,) of the angles between vectors (c, 3); 0 where one is of no length."""
    lengths = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    crossed = np.linalg.norm(np.cross(one, other), axis=1)
    return np.asarray(np.where(lengths > 0, crossed / np.where(lengths > 0, lengths, 1.0), 0.0))


def _corner_values(
    points: FloatArray, here: IntArray, after: IntArray, before: IntArray, upright: FloatArray
) -> FloatArray:
    """Scaled Jacobians of corners with two edges in a layer of nodes and one along the sweep."""
    origin = points[here]
    edges = np.stack([points[after] - origin, points[before] - origin, upright], axis=1)
    lengths = np.linalg.norm(edges, axis=2).prod(axis=1)
    determinants = np.einsum("ij,ij->i", np.cross(edges[:, 0], edges[:, 1]), edges[:, 2])
    values = np.where(lengths > 0, determinants / np.where(lengths > 0, lengths, 1.0), 0.0)
    return np.where(np.isfinite(values), values, -1.0)
