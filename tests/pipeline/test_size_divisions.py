"""Edges that begin where others are finer grow back, and are divided as if every place were asked of every edge."""

import cadquery as cq
import numpy as np
import pytest

import cadsweep as cs
from cadsweep.pipeline.wishes.local_sizes import GROWTH
from cadsweep.pipeline.wishes.size_divisions import _AROUND, divide_beside, divide_by_sizes


@pytest.mark.parametrize("wanted", [(0.1, 0.3, 0.9), (0.4, 0.4, 0.4), (0.05, 0.95, 2.0)])
def test_what_is_beside_finer_edges_is_divided_by_the_nearest_of_them(wanted):
    part = cs.load(cq.Workplane().box(12, 8, 5).faces(">Z").workplane().hole(3))
    (solid,) = part.solids
    sweep = cs.find_sweeps(part)[0]
    grids = [(solid, side) for side in sweep.linking_sides]
    size = 1.0 / part.scale
    finer = {int(solid.edge_keys[e]): w / part.scale for e, w in zip((0, 3, 7), wanted, strict=True)}
    at = np.linspace(0.0, 1.0, _AROUND + 1)

    def of_all(points):
        grown = []
        for edge, key in zip(solid.edges, solid.edge_keys.tolist(), strict=True):
            if finer.get(key, size) < size:
                away = np.linalg.norm(points[:, None] - edge.curve.evaluate(at), axis=2).min(axis=1)
                grown.append(finer[key] + (GROWTH - 1.0) * away)
        return np.minimum(np.min(grown, axis=0), size)

    sizes, divisions = divide_beside([solid], [sweep], grids, finer, size, kept=())
    every, divided = divide_by_sizes([solid], [sweep], grids, of_all)
    assert sizes.keys() == divisions.keys() <= divided.keys() - finer.keys()
    assert sizes
    for key, found in sizes.items():
        assert found == pytest.approx(every[key], rel=1e-12)
        assert divisions[key](7) == pytest.approx(divided[key](7), abs=1e-12)
