"""How far the quads of order p are off the CAD faces between their nodes.

Place in the flow: :func:`cadsweep.orders.elevate.elevate` says it in the mesh's record; the distance falls with the
power p + 1 of the size.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray, IntArray
from ..lattice import Lattice, lexicographic
from .placing import OnCad


def distance(points: FloatArray, lattice: Lattice, surfaces: OnCad, n_nodes: int) -> float:
    """Greatest distance of the quads from their faces, in the middle between each four nodes, model units.

    Parameters
    ----------
    points : (n, 3) float64
    lattice : Lattice
    surfaces : sequence of (quads (q, 4) int64, projection or None)
    n_nodes : int
        Of a quad; of 8 the shape inside follows from its sides.
    """
    order = lattice.order
    at = (np.arange(order) + 0.5) / order
    nodes, degree = np.arange(order + 1) / order, np.arange(order + 1)
    values = at[:, None] ** degree @ np.linalg.inv(nodes[:, None] ** degree)
    farthest = 0.0
    for quads, project in surfaces:
        if project is None:
            continue
        own = points[lattice.quads(quads)]
        if n_nodes == 8:
            own[:, 8] = own[:, 4:8].sum(axis=1) / 2 - own[:, :4].sum(axis=1) / 4
        grid = own[:, quad_lexicographic(order)].reshape(-1, order + 1, order + 1, 3)
        sample = np.einsum("jJ,iI,qJIc->qjic", values, values, grid, optimize=True).reshape(-1, 3)
        farthest = max(farthest, float(np.linalg.norm(project(sample) - sample, axis=1).max(initial=0.0)))
    return farthest


def quad_lexicographic(order: int) -> IntArray:
    """Number ((p + 1)^2,) in a quad of the node i + (p + 1) j: as on the side k = 0 of a hexahedron."""
    inner, numbers = order - 1, lexicographic(order)[: (order + 1) ** 2]
    in_face = numbers - (8 + 12 * inner + 4 * inner**2) + 4 + 4 * inner
    return np.where(numbers < 8, numbers, np.where(numbers < 8 + 4 * inner, numbers - 4, in_face))
