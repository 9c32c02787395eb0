"""Places of the inner nodes of a quad mesh in a plane chart: at the mean of their neighbours, by one sparse solve.

Place in the flow: for the ways of :mod:`.filling` that know their quads beforehand. What is symmetric in the outline is
symmetric inside.
"""

from __future__ import annotations

import numpy as np
import scipy

from ..arrays import FloatArray, IntArray, distinct
from .chart import Chart
from .outline import Outline

_EVENING = 3
"""Times that a curved face's links are weighed by their lengths."""


def evened(outline: Outline, chart: Chart, places: FloatArray, quads: IntArray) -> FloatArray:
    """Places (n, 2) of a quad mesh whose links pull the harder, the longer they are on the surface.

    Where sizes are wanted, the longer they are beside these.
    """
    n_rim = sum(map(len, chart.boundary))
    rim = outline.known[np.concatenate(outline.nodes)]
    ends = _links_of(quads)
    weights = np.ones(len(ends))
    for _ in range(_EVENING):
        points = np.concatenate([rim, chart.lift(places[n_rim:])[0]])
        lengths = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
        if outline.sizes is not None:
            lengths /= np.minimum(outline.sizes(points[ends].mean(axis=1)), outline.size)
        weights *= lengths / lengths.mean()
        places = embedded(places[:n_rim], len(places) - n_rim, quads, weights)
    return places


def _links_of(quads: IntArray) -> IntArray:
    """The sides (m, 2) of quads, each once."""
    ends = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    width = int(ends.max(initial=0)) + 1
    return np.stack(np.divmod(distinct(ends[:, 0] * width + ends[:, 1]), width), axis=1)


def embedded(rim: FloatArray, n_inner: int, quads: IntArray, weights: FloatArray | None = None) -> FloatArray:
    """Places (n, 2) of all nodes of a quad mesh, its first at `rim`, the others at the mean of their neighbours.

    `weights`: of the sides, as :func:`_links_of` gives them; all alike without.
    """
    if not n_inner:
        return rim
    n = len(rim) + n_inner
    ends = _links_of(quads)
    pulls = np.ones(len(ends)) if weights is None else weights
    links = scipy.sparse.coo_array((pulls, (ends[:, 0], ends[:, 1])), shape=(n, n)).tocsr()
    links = links + links.T
    laplacian = (scipy.sparse.diags_array(links.sum(axis=1)) - links).tocsc()
    free, given = laplacian[len(rim) :, len(rim) :], laplacian[len(rim) :, : len(rim)]
    factors = scipy.sparse.linalg.splu(free, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return np.concatenate([rim, factors.solve(np.asarray(-(given @ rim)))])
