"""Copies of a solid are recognised once, and get what each by itself would get."""

from dataclasses import replace

import numpy as np

from cadsweep.recognition import alike, search_sweeps, sweeps_of_each

from .recognition_solids import block_with_pocket, box, prism, regular


def moved(solid, by):
    """The same solid elsewhere."""
    return replace(
        solid,
        vertices=solid.vertices + by,
        edges=tuple(replace(edge, midpoint=edge.midpoint + by) for edge in solid.edges),
        faces=tuple(replace(face, center=face.center + by) for face in solid.faces),
    )


def test_copies_get_the_sweeps_that_each_by_itself_has(monkeypatch):
    solids = [box(1, 2, 3), prism(regular(6)), block_with_pocket()]
    every = [moved(solid, k * np.array([0.1, 0.7, -1.3])) for k in range(3) for solid in solids]
    every.append(box(1, 2, 3 + 1e-6))
    expected = [search_sweeps(solid).sweeps for solid in every]
    looked_at = []
    monkeypatch.setattr(alike, "search_sweeps", lambda solid: looked_at.append(solid) or search_sweeps(solid))
    found = sweeps_of_each(every)
    assert looked_at == [every[0], every[1], every[2], every[-1]]
    for solid, own, alone in zip(every, found, expected, strict=True):
        assert all(sweep.solid is solid for sweep in own)
        assert [(s.source, s.target, s.rails) for s in own] == [(s.source, s.target, s.rails) for s in alone]
        assert np.allclose([s.score for s in own], [s.score for s in alone])
