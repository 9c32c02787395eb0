"""The inside of a mesh carried along with its boundary: the affine map of the boundary, and its residual.

Place in the flow: ``pipeline`` calls it for meshes that are not of one sweep, so that no layers have maps of their own.

Method: the affine map of least squares between the boundary there and here takes all nodes along. What it leaves of the
boundary goes inwards harmonically, on the graph of the hexahedra's edges weighted by one over their length squared, so
that thin layers at a wall move with it.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, others
from ..cells import HEX_EDGES
from ..errors import ProjectionError

RESIDUAL = 1e-11
"""Relative residual at which the iteration stops: derivatives are differences of what it gives."""


def carry_inside(
    points: FloatArray, hexes: IntArray, known: IntArray, places: FloatArray, *, n_steps: int = 1
) -> FloatArray:
    """Place all nodes of a mesh of which some are placed.

    Parameters
    ----------
    points : (n, 3) float64
        Where the nodes were.
    hexes : (m, 8) int64
    known : (k,) int64
        Nodes that are placed, those of the whole boundary among them.
    places : (k, 3) float64
    n_steps : int
        Steps in which the residual is carried, each weighted by the lengths that the last one has left: what is
        squeezed thin resists being squeezed further, so that fewer hexahedra fold.

    Returns
    -------
    (n, 3) float64
        Exact for an affine map.

    Raises
    ------
    ProjectionError
        The iteration does not converge.
    """
    center, there = points[known].mean(axis=0), places.mean(axis=0)
    linear = np.linalg.lstsq(points[known] - center, places - there, rcond=None)[0]
    image = (points - center) @ linear + there
    step = (places - image[known]) / n_steps
    free = others(len(points), known)
    result, shape = image.copy(), points
    if len(free) and step.any():
        for _ in range(n_steps):
            result[free] += _harmonic(shape, hexes, known, free, step)
            result[known] += step
            shape = result
    result[known] = places
    return result


def _harmonic(points: FloatArray, hexes: IntArray, known: IntArray, free: IntArray, values: FloatArray) -> FloatArray:
    """Values (f, 3) at the free nodes, in the weighted mean of their neighbours'."""
    pairs = np.unique(np.sort(hexes[:, HEX_EDGES], axis=2).reshape(-1, 2), axis=0)
    weights = 1.0 / np.sum((points[pairs[:, 0]] - points[pairs[:, 1]]) ** 2, axis=1)
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    links = scipy.sparse.coo_array((np.tile(weights, 2), (rows, columns)), shape=(len(points),) * 2).tocsr()
    matrix = (scipy.sparse.diags_array(np.asarray(links.sum(axis=1)).ravel()) - links).tocsr()[free]
    inner, right = matrix[:, free], -(matrix[:, known] @ values)
    scale = scipy.sparse.diags_array(1.0 / inner.diagonal())
    result = np.empty((len(free), 3))
    for axis in range(3):
        result[:, axis], failed = scipy.sparse.linalg.cg(inner, right[:, axis], rtol=RESIDUAL, maxiter=20000, M=scale)
        if failed:
            raise ProjectionError("the inside of the mesh cannot be carried: the iteration does not converge")
    return result
