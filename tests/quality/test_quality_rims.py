"""How far chords are off the sharp edges that they stand for."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.quality.rims import is_rim, off_edges

cq = pytest.importorskip("cadquery")
pytestmark = pytest.mark.cad


def chords(edge, n):
    nodes = edge.curve.evaluate(np.linspace(0.0, 1.0, n + 1))
    return nodes[:-1], nodes[1:]


@pytest.mark.parametrize("n", [1, 3, 8])
def test_a_chord_of_a_circle_is_off_by_its_sagitta(n):
    part = cs.load(cq.Workplane().circle(3).extrude(2))
    solid = part.solids[0]
    found = off_edges(solid, {e.id: chords(e, n) for e in solid.edges if is_rim(e)})
    assert len(found) == 4
    assert np.array(list(found.values())) * part.scale == pytest.approx(3.0 * (1.0 - np.cos(np.pi / (2 * n))))


def test_edges_that_are_asked_together_are_as_far_off_as_each_alone():
    solid = cs.load(cq.Workplane().circle(3).workplane(offset=2).rect(2, 5).loft().faces(">Z").hole(0.8)).solids[0]
    asked = {e.id: chords(e, 2 + e.id % 3) for e in solid.edges if is_rim(e)}
    assert len(asked) > 4
    assert off_edges(solid, {}) == {}
    together = off_edges(solid, asked)
    assert together == pytest.approx({e: off_edges(solid, {e: own})[e] for e, own in asked.items()}, rel=1e-9)
