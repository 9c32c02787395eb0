"""How much of a mesh is one hexahedron thick: such a wall bends as if it were much stiffer.

Place in the flow: ``pipeline`` notes it of meshes of several cells and of columns; of one sweep the surface stage
knows it before there are hexahedra.

Method: a hexahedron two opposite faces of which are on the boundary has nothing else between these. Only those with all
corners on the boundary are looked at, which are few in a fine mesh.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..arrays import FloatArray, IntArray
from ..cells import HEX_FACES
from ..compiled import compiled
from .conformity import row_keys

_OPPOSITE = ((0, 1), (2, 4), (3, 5))
"""Rows of ``HEX_FACES`` that have no corner in common."""


def single_share(points: FloatArray, hexes: IntArray, boundaries: Iterable[IntArray]) -> float:
    """Part of the boundary's area, of two sides of which one hexahedron is all there is.

    Parameters
    ----------
    points : (n, 3) float64
    hexes : (m, 8 or more) int64
    boundaries : iterable of (q, 4 or more) int64
        Quads of the boundary, whoever they belong to; what lies between two parts is none.

    Returns
    -------
    float
        From 0 to 1.
    """
    quads = np.concatenate([np.empty((0, 4), dtype=np.int64), *(np.asarray(q)[:, :4] for q in boundaries)])
    on_boundary = np.zeros(len(points), dtype=bool)
    on_boundary[quads] = True
    corners = hexes[_all_marked(hexes, on_boundary), :8]
    if not len(corners):
        return 0.0
    faces = corners[:, HEX_FACES].reshape(-1, 4)
    keys = row_keys(quads)
    own = row_keys(faces).reshape(-1, 6)
    on_skin = np.isin(own, keys)
    single = [own[on_skin[:, pair].all(axis=1)][:, pair] for pair in map(list, _OPPOSITE)]
    p = points[quads]
    areas = np.linalg.norm(np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]), axis=1) / 2
    return float(areas[np.isin(keys, np.concatenate(single))].sum() / areas.sum())


@compiled(cache=True, nogil=True)
def _all_marked(hexes, marked):  # type: ignore[no-untyped-def]
    """Which of the hexahedra have eight marked corners."""
    found = np.ones(hexes.shape[0], dtype=np.bool_)
    for h in range(hexes.shape[0]):
        for i in range(8):
            if not marked[hexes[h, i]]:
                found[h] = False
                break
    return found
