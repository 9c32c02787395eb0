r"""Quads of a round core: kites that meet in its middle, each a grid.

Place in the flow: :mod:`.disc_lattice` puts them inside its circles, :mod:`.symmetric` about the middle of a symmetric
face::

        o---o
       /  |  \       k = 3: a node of three quads in the middle,
      o   o   o       and a corner of the core at each kite's end
       \ / \ /
        o---o
"""

from __future__ import annotations

import numpy as np

from ..arrays import IntArray

ROUNDEST = 8
"""Kites that may meet in one node; more are too sharp."""


def kites(n: int, k: int, turn: int) -> tuple[int, IntArray]:
    """Number of inner nodes, and quads, of k kites in a polygon of n nodes with its first corner at node `turn`."""
    s = n // (2 * k)
    middle, quads = n, []
    spokes = n + 1 + np.arange(k * (s - 1)).reshape(k, s - 1)
    inside = n + 1 + k * (s - 1) + np.arange(k * (s - 1) ** 2).reshape(k, s - 1, s - 1)
    for j in range(k):
        corner = turn + 2 * s * j
        kite = np.empty((s + 1, s + 1), dtype=np.int64)
        kite[0, 0] = middle
        kite[1:s, 0], kite[0, 1:s] = spokes[j - 1], spokes[j]
        kite[1:s, 1:s] = inside[j]
        kite[s, :] = (corner - s + np.arange(s + 1)) % n
        kite[:, s] = (corner + s - np.arange(s + 1)) % n
        quads.append(np.stack([kite[:-1, :-1], kite[1:, :-1], kite[1:, 1:], kite[:-1, 1:]], axis=-1).reshape(-1, 4))
    return 1 + k * (s - 1) + k * (s - 1) ** 2, np.concatenate(quads)
