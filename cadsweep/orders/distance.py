"""How far the quads of order p are off the CAD faces between their nodes.

Place in the flow: :func:`cadsweep.orders.elevate.elevate` says it in the mesh's record; the distance falls with the
power p + 1 of the size.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray
from ..lattice import Lattice, quad_lexicographic
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
