"""Once nothing is inverted, only what is around poor hexahedra is moved."""

import numpy as np

from cadsweep.quality import measure_hexes
from cadsweep.smoothing.untangle import Guards, untangle


class Nothing:
    """No node is on a face: all may go anywhere."""

    def projectors(self, nodes, points):
        return np.repeat(np.eye(3)[None], len(nodes), axis=0)

    def snapped(self, nodes, points, start):
        return points


def bar(n=20):
    """Unit cubes in a row of n, three by three across: points, hexahedra, which nodes are inside."""
    at = np.stack(np.meshgrid(np.arange(n + 1), np.arange(4), np.arange(4), indexing="ij"), axis=-1).reshape(-1, 3)
    i, j, k = (own.ravel() for own in np.meshgrid(np.arange(n), np.arange(3), np.arange(3), indexing="ij"))
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    hexes = np.stack([((i + a) * 4 + j + b) * 4 + k + c for a, b, c in corners], axis=1)
    return at.astype(float), hexes, ((at > 0) & (at < [n, 3, 3])).all(axis=1)


def test_a_poor_hexahedron_gets_better_and_what_is_far_off_keeps_its_bits():
    points, hexes, free = bar()
    poor = int(np.flatnonzero((points == [2, 1, 1]).all(axis=1))[0])
    points[poor] += [0.85, 0.0, 0.0]  # nearly upon its neighbour
    before = measure_hexes(points, hexes).scaled_jacobian.min()
    assert 0 < before < 0.7
    none = Guards(np.empty((0, 8), dtype=np.int64), lambda _: np.empty((0, 3)))
    found = untangle(points, hexes, free, np.ones((len(hexes), 3)), Nothing(), goal=0.8, guards=none)
    assert found.worst >= 0.8
    assert measure_hexes(found.points, hexes).scaled_jacobian.min() == found.worst
    moved = (found.points != points).any(axis=1)
    assert not moved[~free].any()
    # The poor ones have the node that was moved, and reach from 1 to 3; three hexahedra more end at 6.
    assert points[moved, 0].max() <= 6
    assert moved[poor]
