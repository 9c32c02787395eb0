"""Layers of a sweep whose rails wind around each other stand square to them."""

import numpy as np
import pytest

import cadsweep as cs
from cadsweep.pipeline.attempts import open_and_find
from cadsweep.surface import rails_abreast

pytestmark = pytest.mark.cad
cq = pytest.importorskip("cadquery")


def spring(*, turns=3, frenet=False):
    """A wire of radius 1.5 around a helix of radius 10: as CadQuery does by default, its section turns in its plane."""
    helix = cq.Workplane(cq.Wire.makeHelix(6, 6 * turns, 10))
    return cq.Workplane("XZ").center(10, 0).circle(1.5).sweep(helix, isFrenet=frenet)


def sweep_of(shape):
    _, (sweep, *_) = open_and_find(cs.load(shape), None, None)
    return sweep


def leaning(sweep, divisions, n=240):
    """Greatest cosine between rails and the lines from each to the next through equal nodes."""
    solid, places = sweep.solid, []
    for e in sweep.rails:
        at = divisions[e](n) if e in divisions else np.linspace(0.0, 1.0, n + 1)
        points = solid.edges[e].curve.evaluate(at)
        places.append(points if np.allclose(points[0], solid.vertices[solid.edges[e].start]) else points[::-1])
    (a, b), tangents = places, np.gradient(np.mean(places, axis=0), axis=0)
    across = b - a
    cosines = (across * tangents).sum(axis=1) / np.linalg.norm(across, axis=1) / np.linalg.norm(tangents, axis=1)
    return np.abs(cosines).max()


def test_layers_of_a_wire_whose_section_turns_stand_square():
    sweep = sweep_of(spring())
    divisions = rails_abreast(sweep)
    assert set(divisions) == set(sweep.rails)
    for division in divisions.values():
        assert (np.diff(division(240)) > 0.0).all()
        assert division(240)[[0, -1]].tolist() == [0.0, 1.0]
    assert leaning(sweep, {}) > 0.9
    assert leaning(sweep, divisions) < 0.2


@pytest.mark.parametrize(
    "shape",
    [
        cq.Workplane().box(1, 2, 3),
        cq.Workplane().rect(20, 10).twistExtrude(30, 90),
        cq.Workplane().rect(30, 20).workplane(offset=20).circle(8).loft(),
        spring(frenet=True),
    ],
    ids=["box", "twisted", "loft", "frenet"],
)
def test_rails_that_keep_abreast_at_equal_lengths_stay_even(shape):
    assert rails_abreast(sweep_of(shape)) == {}


def test_a_spring_whose_section_turns_is_swept():
    mesh = cs.sweep_mesh(spring(turns=2), size=1.0)
    assert mesh.record.way == "sweep"
    assert mesh.info["quality"].min_scaled_jacobian > 0.5
